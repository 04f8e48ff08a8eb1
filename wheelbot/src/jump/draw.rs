//! Robots and floors drawn at random.

use super::floor::Conditions;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Friction from here
pub const LEAST_FRICTION: f64 = 0.4;
/// to here.
pub const MOST_FRICTION: f64 = 0.9;
/// Every mass is off by so much at most, as a share.
pub const MOST_MASS: f64 = 0.05;
/// The robot is held so far from flat, rad, and drops.
const TILT: std::ops::Range<f64> = 0.01..0.05;
/// Its wheels turn with so much at most, rad/s.
const MOST_RATE: f64 = 5.0;

/// Some robots: either side, even over all ranges.
pub fn conditions(count: usize, seed: u64) -> Vec<Conditions> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn = || Conditions {
        positive: random.random_bool(0.5),
        friction: random.random_range(LEAST_FRICTION..MOST_FRICTION),
        masses: std::array::from_fn(|_| 1.0 + random.random_range(-MOST_MASS..MOST_MASS)),
        tilt: random.random_range(TILT),
        rates: std::array::from_fn(|_| random.random_range(-MOST_RATE..MOST_RATE)),
    };
    (0..count).map(|_| drawn()).collect()
}
