//! Random states and parameters of a model, the same on every run.

use dynamics_codegen::{Model, emit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A source of random numbers.
pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Values for `emit::arguments`: time, positions, velocities, inputs, states, parameters.
/// Parameters lie within 40 % of their nominal values and inside their bounds.
pub fn arguments(model: &Model, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut values = vec![rng.random_range(0.0..2.0)];
    let states = 2 * model.coordinates.len();
    values.extend((0..states).map(|_| rng.random_range(-1.5..1.5)));
    let inputs = emit::arguments(model).len() - 1 - states - model.parameters.len();
    values.extend((0..inputs).map(|_| rng.random_range(-2.0..2.0)));
    for p in &model.parameters {
        let scale = if p.nominal == 0.0 { 1.0 } else { p.nominal };
        let value = p.nominal + scale * rng.random_range(-0.4..0.4);
        values.push(value.clamp(p.lower, p.upper));
    }
    values
}
