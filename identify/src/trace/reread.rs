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
    use crate::trace::wheel::{WHEEL, begun, named};
    use std::fmt::Write;

    fn motion(t: f64) -> f64 {
        (8.0 * t).sin()
    }

    /// A log of the wheel, whose angle at `t` is read as this.
    fn log(read: impl Fn(f64) -> f64) -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        for k in 0..500 {
            let t = 0.004 * f64::from(k);
            writeln!(text, "{t},{},0", read(t)).unwrap();
        }
        text
    }

    /// How far a curve is from the motion, ends left out.
    fn miss(observed: &Observed) -> f64 {
        let curve = &observed.curve;
        let each = (20..480).map(|k| (curve.q[0][k] - motion(curve.t[k])).abs());
        each.fold(0.0, f64::max)
    }

    /// Of a motion that is read 30 ms late, with an offset and twice as large.
    #[test]
    fn the_motion_behind_wrong_readings_is_found() {
        let log = log(|t| 2.0 * (motion(t - 0.03) + 0.1));
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let mut observed = start.observed;
        let errors = [
            ("time_shift(angle)", 0.03),
            ("measurement_scale(angle)", 2.0),
            ("measurement_offset(angle)", 0.1),
        ];
        let mut now = dictionary.defaults.clone();
        let candidates = errors.map(|(name, value)| {
            let candidate = named(&dictionary, name);
            now[dictionary.candidates[candidate].parameters[0]] = value;
            candidate
        });
        let focus = dictionary.focus(&candidates);
        observed.reread(&focus, &dictionary.defaults, &now);
        assert!(miss(&observed) < 1e-4, "{}", miss(&observed));
    }

    #[test]
    fn a_model_that_says_how_late_a_sensor_is_is_believed() {
        let model = format!("{WHEEL}effect time_shift(angle) {{ tau = 0.03 }}\n");
        let (dictionary, start) = begun(&model, &log(|t| motion(t - 0.03)), ["angle", "motor"]);
        let mut observed = start.observed;
        assert!(miss(&observed) > 0.1);
        observed.believe(&dictionary).unwrap();
        assert!(miss(&observed) < 1e-4, "{}", miss(&observed));
    }
}
