//! A log as faultless sensors would have written it.

use super::focus::Focus;
use crate::log::Record;
use crate::machine::States;
use crate::regression::{derivative, divided};
use crate::smooth::{SmoothError, savgol_states};

/// Rounds in which motion and correction are brought to agree: each gains as many digits
/// as the correction is small.
const ROUNDS: usize = 4;

/// `record` without what the sensors of `focus`, with these values of its own parameters,
/// get wrong. Velocities and accelerations that a reading depends on are those of a filter.
///
/// # Errors
/// If the log cannot be filtered.
pub(super) fn corrected(
    record: &Record,
    focus: &Focus,
    values: &[f64],
) -> Result<Record, SmoothError> {
    let mut motion = record.clone();
    if !focus.machine.has_sensor_errors() {
        return Ok(motion);
    }
    for _ in 0..ROUNDS {
        let filtered = savgol_states(&motion)?;
        let states = States {
            t: motion.t.clone(),
            q: motion.q.clone(),
            v: filtered.v.clone(),
            u: motion.u.clone(),
            ..States::default()
        };
        let states = focus.machine.at_rest(&states, values);
        let read = focus.sensors.read(&states, &filtered.a, values);
        for i in 0..motion.q.len() {
            let beyond: Vec<f64> = read.v[i]
                .iter()
                .zip(&states.v[i])
                .map(|(read, v)| read - v)
                .collect();
            // A step towards the motion that is read as it was logged.
            let step = |logged: &[f64], motion: &mut [f64], beyond: &[f64]| {
                let shown: Vec<f64> = motion.iter().zip(beyond).map(|(x, b)| x + b).collect();
                let miss: Vec<f64> = logged.iter().zip(shown).map(|(y, x)| y - x).collect();
                let step = divided(&miss, &read.slope[i]);
                motion.iter_mut().zip(step).for_each(|(x, step)| *x += step);
            };
            if let (Some(logged), Some(a)) = (&record.ddq[i], &mut motion.ddq[i]) {
                step(logged, a, &derivative(&motion.t, &beyond));
            }
            if let (Some(logged), Some(v)) = (&record.dq[i], &mut motion.dq[i]) {
                step(logged, v, &beyond);
            }
            let beyond: Vec<f64> = read.q[i]
                .iter()
                .zip(&states.q[i])
                .map(|(read, q)| read - q)
                .collect();
            step(&record.q[i], &mut motion.q[i], &beyond);
        }
    }
    Ok(motion)
}
