//! A motion of which sensors with other errors read what they read of another before.
//!
//! A fit that begins where a sensor is first thought to misread would have to move the motion by
//! all of its error, in steps that are linear in that. What is read is known better than the
//! motion.

use super::corrected::{at_its_time, corrected};
use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::focus::Focus;
use crate::machine::Measured;
use crate::regression::{derivative, divided};
use crate::smooth::SmoothError;

/// Rounds in which motion and readings are brought to agree.
const ROUNDS: usize = 2;

impl Observed {
    /// Moves the curve to where the sensors of `focus` with the dictionary's values `now` read of
    /// it what they read with the values `before`.
    pub(super) fn reread(&mut self, focus: &Focus, before: &[f64], now: &[f64]) {
        let [before, now] = [before, now].map(|values| focus.values(values));
        if before == now || !focus.machine.has_sensor_errors() {
            return;
        }
        let wanted = self.read(focus, &before);
        let read = self.read(focus, &now);
        for i in 0..self.curve.q.len() {
            let at = |ahead: &[Vec<f64>], k: usize| ahead[i].get(k).copied().unwrap_or(0.0);
            let ahead = (0..self.curve.len()).map(|k| at(&wanted.ahead, k) - at(&read.ahead, k));
            let ahead: Vec<f64> = ahead.collect();
            if ahead.iter().any(|by| *by != 0.0) {
                self.move_in_time(i, &ahead);
            }
        }
        for _ in 0..ROUNDS {
            let read = self.read(focus, &now);
            for i in 0..self.curve.q.len() {
                let add = |x: &mut [f64], wanted: &[f64], shown: &[f64]| {
                    let miss: Vec<f64> = wanted.iter().zip(shown).map(|(w, s)| w - s).collect();
                    let miss = at_its_time(&self.curve.t, &miss, &read.ahead[i]);
                    let miss = divided(&miss, &read.slope[i]);
                    x.iter_mut().zip(miss).for_each(|(x, miss)| *x += miss);
                };
                add(&mut self.curve.q[i], &wanted.q[i], &read.q[i]);
                add(&mut self.curve.v[i], &wanted.v[i], &read.v[i]);
            }
        }
    }

    /// Moves the curve to where the sensors of the model as given read it.
    ///
    /// # Errors
    /// If the log cannot be smoothed.
    pub(super) fn believe(&mut self, dictionary: &Dictionary) -> Result<(), SmoothError> {
        let focus = dictionary.focus(&[]);
        if focus.machine.has_sensor_errors() {
            let values = focus.values(&dictionary.defaults);
            let faultless = corrected(&self.record, &focus, &values)?;
            self.curve = Self::new(faultless, self.hold)?.curve;
        }
        Ok(())
    }

    /// What the sensors of `focus` with these values of its own parameters read of the curve.
    fn read(&self, focus: &Focus, values: &[f64]) -> Measured {
        let states = focus.machine.at_rest(&self.curve, values);
        let rates = self.curve.v.iter();
        let accelerations: Vec<Vec<f64>> = rates.map(|v| derivative(&self.curve.t, v)).collect();
        focus.sensors.read(&states, &accelerations, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::regression::Hold;
    use crate::trace::dictionary::Source;
    use crate::trace::select::wheel::WHEEL;
    use dynamics_codegen::Library;
    use std::collections::BTreeMap;
    use std::fmt::Write;

    /// Of a motion that is read 30 ms late, with an offset and twice as large.
    #[test]
    fn the_motion_behind_wrong_readings_is_found() {
        let motion = |t: f64| (8.0 * t).sin();
        let mut text = String::from("t,q_angle,u_motor\n");
        for k in 0..500 {
            let t = 0.004 * f64::from(k);
            writeln!(text, "{t},{},0", 2.0 * (motion(t - 0.03) + 0.1)).unwrap();
        }
        let source = Source {
            name: "wheel",
            text: WHEEL,
            library: &Library::builtin(),
            parameters: &BTreeMap::new(),
        };
        let log = Log::from_bytes("wheel.csv", text.as_bytes()).unwrap();
        let record = log.select(&["angle".to_string()], &["motor".to_string()]);
        let mut observed = Observed::new(record.unwrap(), Hold::Linear).unwrap();
        let dictionary = Dictionary::new(&source, &observed.ranges()).unwrap();
        let errors = [
            ("time_shift(angle)", 0.03),
            ("measurement_scale(angle)", 2.0),
            ("measurement_offset(angle)", 0.1),
        ];
        let mut now = dictionary.defaults.clone();
        let candidates = errors.map(|(name, value)| {
            let mut all = dictionary.candidates.iter();
            let place = all.position(|c| c.subject.to_string() == name).unwrap();
            now[dictionary.candidates[place].parameters[0]] = value;
            place
        });
        let focus = dictionary.focus(&candidates);
        observed.reread(&focus, &dictionary.defaults, &now);
        let curve = &observed.curve;
        let miss = |k: &usize| (curve.q[0][*k] - motion(curve.t[*k])).abs();
        let worst = (20..480).map(|k| miss(&k)).fold(0.0, f64::max);
        assert!(worst < 1e-4, "{worst}");
    }
}
