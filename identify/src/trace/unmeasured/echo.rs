//! What noise of the sensors makes of estimates: errors that follow one another, as smoothing
//! leaves them.

use super::super::dictionary::Dictionary;
use super::super::linearised::smooth;
use super::super::refine::Explanation;
use crate::log::{Reading, Record};
use crate::machine::SolveError;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Changes of the position and of the velocity of each coordinate, sample by sample; null where it
/// is measured.
pub(in super::super) type Echo = Vec<[Vec<f64>; 2]>;

/// By how much estimates change if the sensors are as noisy once more. Nothing where everything is
/// measured.
///
/// # Errors
/// If the equation of motion cannot be solved along the changed curve.
pub(in super::super) fn echo(
    dictionary: &Dictionary,
    accepted: &[usize],
    explanation: &Explanation,
    seed: u64,
) -> Result<Echo, SolveError> {
    let known = &explanation.observed;
    let mut observed = known.clone();
    if known.record.is_wholly_measured() {
        return Ok(Vec::new());
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(1);
    let sensed = observed.record.sensed.iter_mut();
    for Reading { values, sd, .. } in sensed.flat_map(|sensed| &mut sensed.readings) {
        for value in values {
            let draw: f64 = StandardNormal.sample(&mut random);
            *value += *sd * draw;
        }
    }
    let there = smooth(dictionary, accepted, observed, &explanation.values)?.observed;
    let change = |record: &Record, i: usize, now: &[f64], then: &[f64]| -> Vec<f64> {
        let each = now.iter().zip(then);
        each.map(|(now, then)| {
            if record.is_measured(i) {
                0.0
            } else {
                then - now
            }
        })
        .collect()
    };
    let (now, then) = (&known.curve, &there.curve);
    let of = |i: usize| {
        let pairs = [(&now.q[i], &then.q[i]), (&now.v[i], &then.v[i])];
        pairs.map(|(now, then)| change(&known.record, i, now, then))
    };
    Ok((0..now.q.len()).map(of).collect())
}
