//! A log as faultless sensors would have written it.

use super::focus::Focus;
use crate::log::{Record, longest_step};
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
            // What is logged beside what would be read of the smooth motion, added to it where
            // it belongs: the noise of the log stays what it is, and so does motion that is too
            // fast for the filter.
            let beside = |logged: &[f64], shown: &[f64], smooth: &[f64]| -> Vec<f64> {
                let miss: Vec<f64> = logged.iter().zip(shown).map(|(y, r)| y - r).collect();
                let miss = at_its_time(&record.t, &miss, &read.ahead[i]);
                let miss = divided(&miss, &read.slope[i]);
                smooth.iter().zip(miss).map(|(x, miss)| x + miss).collect()
            };
            motion.q[i] = beside(&record.q[i], &read.q[i], &states.q[i]);
            if let Some(logged) = &record.dq[i] {
                motion.dq[i] = Some(beside(logged, &read.v[i], &states.v[i]));
            }
            if let Some(logged) = &record.ddq[i] {
                // Of the motion as it is smooth, and as that is read.
                let smooth = derivative(&motion.t, &states.v[i]);
                let shown = derivative(&motion.t, &read.v[i]);
                motion.ddq[i] = Some(beside(logged, &shown, &smooth));
            }
        }
    }
    Ok(motion)
}

/// What is logged at `t` belongs to the motion `ahead` seconds later: by the cubic through four
/// samples, beside gaps and ends that of the nearest.
pub(super) fn at_its_time(t: &[f64], logged: &[f64], ahead: &[f64]) -> Vec<f64> {
    if ahead.is_empty() {
        return logged.to_vec();
    }
    let longest = longest_step(t);
    let at = |(&t_k, &ahead): (&f64, &f64)| {
        let when = t_k - ahead;
        let after = t.partition_point(|&stamp| stamp <= when).min(t.len() - 1);
        let first = after.saturating_sub(2);
        let nodes = first..(first + 4).min(t.len());
        let stamps = &t[nodes.clone()];
        let joined = stamps.windows(2).all(|pair| pair[1] - pair[0] <= longest);
        if !joined || nodes.len() < 4 || when < stamps[0] || when > stamps[3] {
            let before = after.saturating_sub(1);
            let is_later = t[after] - when < when - t[before];
            return logged[if is_later { after } else { before }];
        }
        let weight = |i: usize| -> f64 {
            let others = (0..4).filter(|&j| j != i);
            let factors = others.map(|j| (when - stamps[j]) / (stamps[i] - stamps[j]));
            factors.product()
        };
        nodes
            .clone()
            .enumerate()
            .map(|(i, k)| weight(i) * logged[k])
            .sum()
    };
    t.iter().zip(ahead).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_go_to_the_time_they_are_of() {
        let t: Vec<f64> = (0..200).map(|k| 0.005 * f64::from(k)).collect();
        let motion = |t: f64| (20.0 * t).sin();
        for late in [0.0123, -0.0071] {
            let logged: Vec<f64> = t.iter().map(|t| motion(t - late)).collect();
            let found = at_its_time(&t, &logged, &vec![-late; t.len()]);
            for k in 5..195 {
                assert!((found[k] - motion(t[k])).abs() < 2e-5, "{k}: {}", found[k]);
            }
        }
    }

    /// Beside a gap no curve is drawn.
    #[test]
    fn nothing_is_read_across_a_gap() {
        let t = [0.0, 0.01, 0.02, 0.03, 1.03, 1.04, 1.05, 1.06];
        let logged = [1.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0];
        let found = at_its_time(&t, &logged, &[-0.004; 8]);
        let apart = found.iter().zip(&logged).map(|(x, y)| (x - y).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-12, "{found:?}");
    }
}
