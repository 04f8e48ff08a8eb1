//! What an unknown force may depend on: positions, velocities, inputs and the past.

use super::super::remembered::past;

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
    /// Where it has come from lately, forgotten over a way `r`: `ṗ = v − |v| p/r`. A force
    /// that remembers its past, as hysteresis does at any speed, is a function of it.
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

/// The past is forgotten over these shares of the way that the coordinate usually makes.
const MEMORIES: [f64; 4] = [0.03, 0.1, 0.3, 1.0];

/// The variables that may matter along a motion. Over which way the past is forgotten is
/// taken from it; `ways` are further ones, by coordinate.
pub(super) fn kinds(motion: &Motion<'_>, ways: &[(usize, f64)]) -> Vec<Feature> {
    let n = motion.q.len();
    let pasts = |i: usize| {
        let spread = deviation(&motion.q[i]);
        MEMORIES.map(|share| Feature::Past(i, share * spread))
    };
    (0..n)
        .map(Feature::Position)
        .chain((0..n).map(Feature::Velocity))
        .chain((0..n).flat_map(pasts))
        .chain(ways.iter().map(|&(i, way)| Feature::Past(i, way)))
        .chain((0..motion.u.len()).map(Feature::Input))
        .collect()
}

impl Features {
    /// The variables `kinds` along a motion.
    pub fn new(kinds: &[Feature], motion: &Motion<'_>) -> Self {
        let column = |kind: &Feature| match *kind {
            Feature::Position(i) => motion.q[i].clone(),
            Feature::Velocity(i) => motion.v[i].clone(),
            Feature::Past(i, way) => past(motion.t, &motion.v[i], way),
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

/// Standard deviation.
pub(super) fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}
