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
        let states = States::filtered(&motion, &filtered);
        let states = focus.machine.at_rest(&states, values);
        let read = focus.sensors.read(&states, &filtered.a, values);
        for i in 0..motion.q.len() {
            // What is logged beside what would be read of the smooth motion, added to it: the
            // noise of the log stays what it is.
            let beside = |logged: &[f64], shown: &[f64], smooth: &[f64]| -> Vec<f64> {
                let miss: Vec<f64> = logged.iter().zip(shown).map(|(y, r)| y - r).collect();
                let miss = divided(&miss, &read.slope[i]);
                smooth.iter().zip(miss).map(|(x, miss)| x + miss).collect()
            };
            motion.q[i] = beside(&record.q[i], &read.q[i], &states.q[i]);
            if let Some(logged) = &record.dq[i] {
                motion.dq[i] = Some(beside(logged, &read.v[i], &states.v[i]));
            }
            if let Some(logged) = &record.ddq[i] {
                let beyond = read.v[i].iter().zip(&states.v[i]).map(|(read, v)| read - v);
                let beyond = derivative(&motion.t, &beyond.collect::<Vec<f64>>());
                let shown: Vec<f64> = filtered.a[i]
                    .iter()
                    .zip(beyond)
                    .map(|(a, b)| a + b)
                    .collect();
                motion.ddq[i] = Some(beside(logged, &shown, &filtered.a[i]));
            }
        }
    }
    Ok(motion)
}
