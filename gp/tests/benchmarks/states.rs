//! States of the unicycle, and what a quantity of its dynamics is at them.

use crate::systems;
use gp::{Functionals, GaussPoint, Layout, Quantity};
use rand::{RngExt, SeedableRng};

/// Rolling states `[v1, v2, q3, v3, u1, u2]` under a constant input.
pub fn states(count: usize, seed: u64, input: [f64; 2]) -> Vec<Vec<f64>> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| {
            let (speed, q3) = (rng.random_range(0.0..1.0f64), rng.random_range(0.0..6.2f64));
            vec![
                speed * q3.cos(),
                speed * q3.sin(),
                q3,
                rng.random_range(-0.5..0.5),
                input[0],
                input[1],
            ]
        })
        .collect()
}

/// A quantity at these states.
pub fn functionals(x: &[Vec<f64>], quantity: Quantity, layout: Layout) -> Functionals {
    let mut out = Functionals::new(6, layout.n_latent(3));
    for x in x {
        let s = systems::unicycle(x, &[0.05, 0.02]);
        let r = GaussPoint::new(&s.mass, &s.a, &s.b, &s.known)
            .unwrap()
            .rows(quantity, layout)
            .unwrap();
        out.push(x, &r.h, &r.mean).unwrap();
    }
    out
}
