//! What an unknown force may depend on: positions, velocities, inputs and the past.

use crate::log::segments;

/// Candidate variables along a motion, one column each.
#[derive(Debug, Clone)]
pub(super) struct Features {
    /// What each is.
    pub kinds: Vec<Feature>,
    /// Its values, one per sample.
    pub columns: Vec<Vec<f64>>,
}

/// One variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Feature {
    /// The position of a coordinate.
    Position(usize),
    /// Its velocity.
    Velocity(usize),
    /// Where it has come from lately: `ṗ = v − p/T`. A force that remembers its past, as
    /// hysteresis does, is a function of it.
    Past(usize, f64),
    /// An input.
    Input(usize),
}

/// A motion as columns: stamps, positions, velocities, inputs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion<'a> {
    pub t: &'a [f64],
    pub q: &'a [Vec<f64>],
    pub v: &'a [Vec<f64>],
    pub u: &'a [Vec<f64>],
}

/// The past is forgotten in one of these many times that the coordinate takes to cross its
/// range once at its usual speed.
const MEMORIES: [f64; 3] = [0.1, 0.3, 1.0];

/// The variables that may matter along a motion. How long the past lasts is taken from it.
pub(super) fn kinds(motion: &Motion<'_>) -> Vec<Feature> {
    let n = motion.q.len();
    let pasts = |i: usize| {
        let spread = deviation(&motion.q[i]) / deviation(&motion.v[i]).max(f64::MIN_POSITIVE);
        MEMORIES.map(|share| Feature::Past(i, share * spread))
    };
    (0..n)
        .map(Feature::Position)
        .chain((0..n).map(Feature::Velocity))
        .chain((0..n).flat_map(pasts))
        .chain((0..motion.u.len()).map(Feature::Input))
        .collect()
}

impl Features {
    /// The variables `kinds` along a motion.
    pub fn new(kinds: &[Feature], motion: &Motion<'_>) -> Self {
        let column = |kind: &Feature| match *kind {
            Feature::Position(i) => motion.q[i].clone(),
            Feature::Velocity(i) => motion.v[i].clone(),
            Feature::Past(i, time) => past(motion.t, &motion.v[i], time),
            Feature::Input(i) => motion.u[i].clone(),
        };
        Self {
            kinds: kinds.to_vec(),
            columns: kinds.iter().map(column).collect(),
        }
    }

    /// The values at one sample of those variables.
    pub fn at(&self, sample: usize, wanted: &[usize]) -> Vec<f64> {
        wanted.iter().map(|&w| self.columns[w][sample]).collect()
    }
}

/// `ṗ = v − p/T` from nothing on, exactly for a velocity that stays; anew after each gap.
fn past(t: &[f64], v: &[f64], time: f64) -> Vec<f64> {
    let mut past = vec![0.0; v.len()];
    for range in segments(t) {
        for k in range.clone().skip(1) {
            let decay = (-(t[k] - t[k - 1]) / time).exp();
            past[k] = past[k - 1] * decay + v[k - 1] * time * (1.0 - decay);
        }
    }
    past
}

/// Standard deviation.
pub(super) fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_past_of_a_steady_motion_settles() {
        let t: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let v = vec![2.0; t.len()];
        let past = past(&t, &v, 0.5);
        assert_eq!(past[0], 0.0);
        assert!((past[999] - 1.0).abs() < 1e-6, "v T");
    }
}
