//! Poles of a closed loop from sample to sample.

use super::plane::Plane;
use nalgebra::{Complex, DMatrix};

/// The poles under `u = +K x`, which arrives `delay` samples late, the largest first.
///
/// Commands on their way are states: `(x, u₁, …, u_d)₊ = (A x + B u₁, u₂, …, K x)`.
pub fn poles(plane: &Plane, gain: &[f64; 4], delay: usize) -> Vec<Complex<f64>> {
    let size = 4 + delay;
    let mut closed = DMatrix::zeros(size, size);
    closed.view_mut((0, 0), (4, 4)).copy_from(&plane.a);
    for k in 0..4 {
        if delay == 0 {
            for i in 0..4 {
                closed[(i, k)] += plane.b[i] * gain[k];
            }
        } else {
            closed[(k, 4)] = plane.b[k];
            closed[(size - 1, k)] = gain[k];
        }
    }
    for later in 5..size {
        closed[(later - 1, later)] = 1.0;
    }
    let mut poles: Vec<Complex<f64>> = closed.complex_eigenvalues().iter().copied().collect();
    poles.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    poles
}
