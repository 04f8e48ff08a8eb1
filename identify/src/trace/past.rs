//! What is not known of the time before a log.

use super::estimate::Observed;
use super::focus::Focus;
use crate::machine::Signal;

impl Observed {
    /// By how much accelerations may be off, per coordinate and sample at the beginning of the log, where
    /// inputs that are late are of the time before it: these may have been as far from what they were first
    /// as they get in the same time after it. Empty where the whole past is known.
    pub(super) fn doubt_of_past(&self, focus: &Focus, values: &[f64]) -> Vec<Vec<f64>> {
        let machine = &focus.machine;
        let (t, u) = match &self.curve.history {
            Some(history) => (&history.t, &history.u),
            None => (&self.curve.t, &self.curve.u),
        };
        let delays = machine.delays(values);
        let longest = delays.iter().map(|(_, tau)| *tau).fold(0.0, f64::max);
        let begun = t[0];
        let count = self.curve.t.partition_point(|&t| t < begun + longest);
        if count < 2 {
            return Vec::new();
        }
        let states = self.curve.slice(0..count);
        // Where the machine cannot move, what linearises its motion there says so.
        let Ok(known) = machine.felt(&states, self.hold, values) else {
            return Vec::new();
        };
        let mut mirrored = known.clone();
        for (delayed, (input, tau)) in mirrored.memory.delayed.iter_mut().zip(delays) {
            let (u, hold) = (&u[input], self.hold);
            let signal = Signal { t, u, hold };
            for (value, at) in delayed.iter_mut().zip(&states.t) {
                let before = begun - (at - tau);
                if before > 0.0 {
                    *value = signal.at(begun + before).0;
                }
            }
        }
        let [Ok(known), Ok(mirrored)] = [known, mirrored].map(|s| machine.motion(&s, values))
        else {
            return Vec::new();
        };
        let pairs = || known.iter().zip(&mirrored);
        let apart = |i: usize| {
            let each = pairs().map(|(a, b)| (a.acceleration[i] - b.acceleration[i]).abs());
            each.collect()
        };
        (0..self.curve.q.len()).map(apart).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::trace::wheel::{WHEEL, begun, named};
    use std::fmt::Write;

    /// A wheel whose torque goes on before the log as it does after its beginning.
    #[test]
    fn what_came_before_is_doubted_as_far_as_it_may_have_been() {
        const LATE: f64 = 0.0175;
        let torque = |t: f64| 0.04 * (3.0 * t).sin() + 0.06 * (7.0 * t).cos();
        let mut text = String::from("t,q_angle,u_motor\n");
        let stamps: Vec<f64> = (0..400).map(|k| 0.005 * f64::from(k)).collect();
        for &t in &stamps {
            writeln!(text, "{t},{},{}", (4.0 * t).sin(), torque(t)).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let late = named(&dictionary, "input_delay(motor)");
        let focus = dictionary.focus(&[late]);
        let doubts = |late_by: f64| {
            let mut values = start.values.clone();
            values[dictionary.candidates[late].parameters[0]] = late_by;
            let doubt = start.observed.doubt_of_past(&focus, &focus.values(&values));
            doubt.into_iter().next().unwrap_or_default()
        };
        assert!(doubts(0.0).is_empty());
        let doubt = doubts(LATE);
        assert_eq!(doubt.len(), 4);
        for (t, doubt) in stamps.iter().zip(doubt) {
            let miss = (torque(t - LATE) - torque(0.0)).abs() / 0.02;
            assert!(
                0.5 * miss < doubt && doubt < 2.0 * miss,
                "{t}: {miss} {doubt}"
            );
        }
    }
}
