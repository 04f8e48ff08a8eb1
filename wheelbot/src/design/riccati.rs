//! The discrete algebraic Riccati equation by structure-preserving doubling.

use nalgebra::{Matrix4, Vector4};

/// Doublings at most: `2⁴⁰` samples are a year of the slowest plant.
const MOST: usize = 40;

/// The stabilising solution `P` of
///
/// ```text
/// P = Aᵀ P A − Aᵀ P B (R + Bᵀ P B)⁻¹ Bᵀ P A + Q
/// ```
///
/// by the doubling of Chu, Fan, Lin and Wang (2004): from `A₀ = A`, `G₀ = B R⁻¹ Bᵀ`, `H₀ = Q`,
///
/// ```text
/// W = 1 + Gₖ Hₖ
/// Aₖ₊₁ = Aₖ W⁻¹ Aₖ      Gₖ₊₁ = Gₖ + Aₖ W⁻¹ Gₖ Aₖᵀ      Hₖ₊₁ = Hₖ + Aₖᵀ Hₖ W⁻¹ Aₖ
/// ```
///
/// where `Hₖ → P` and `Aₖ` is the closed loop's `2ᵏ`-th power. `None` if it does not settle, as
/// where no control stabilises the plant.
pub fn solve(a: &Matrix4<f64>, b: &Vector4<f64>, q: &Matrix4<f64>, r: f64) -> Option<Matrix4<f64>> {
    let (mut ak, mut gk, mut hk) = (*a, b * b.transpose() / r, *q);
    for _ in 0..MOST {
        let inverse = (Matrix4::identity() + gk * hk).try_inverse()?;
        let step = ak.transpose() * hk * inverse * ak;
        gk += ak * inverse * gk * ak.transpose();
        ak = ak * inverse * ak;
        hk += step;
        hk = (hk + hk.transpose()) / 2.0;
        if !hk.iter().all(|x| x.is_finite()) {
            return None;
        }
        if step.amax() <= 1e-15 * hk.amax() {
            return Some(hk);
        }
    }
    None
}

/// `K` of the regulator `u = −K x` that belongs to `P`: `(R + Bᵀ P B)⁻¹ Bᵀ P A`.
pub fn gain(a: &Matrix4<f64>, b: &Vector4<f64>, p: &Matrix4<f64>, r: f64) -> [f64; 4] {
    let row = b.transpose() * p * a / (r + (b.transpose() * p * b)[0]);
    core::array::from_fn(|k| row[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::planes;
    use crate::design::weights::WEIGHTS;
    use wheelbot_firmware::INTERVAL;

    /// By how much the equation is missed, as a share of `P`'s largest entry.
    fn residual(
        a: &Matrix4<f64>,
        b: &Vector4<f64>,
        (q, r): (&Matrix4<f64>, f64),
        p: &Matrix4<f64>,
    ) -> f64 {
        let k = Vector4::from(gain(a, b, p, r));
        let closed = a - b * k.transpose();
        // Joseph's form, in which nothing large cancels.
        let again = closed.transpose() * p * closed + q + k * k.transpose() * r;
        (again - p).amax() / p.amax()
    }

    #[test]
    fn the_equation_holds() {
        for (plane, weights) in planes(Some(INTERVAL)).unwrap().iter().zip(&WEIGHTS) {
            let q = Matrix4::from_diagonal(&Vector4::from(weights.state));
            let p = solve(&plane.a, &plane.b, &q, weights.torque).unwrap();
            let missed = residual(&plane.a, &plane.b, (&q, weights.torque), &p);
            assert!(missed < 1e-9, "{missed}");
        }
    }

    /// Of an unstable plant that no torque reaches.
    #[test]
    fn what_cannot_be_stabilised_has_no_solution() {
        let a = Matrix4::from_diagonal(&Vector4::new(1.1, 0.5, 0.5, 0.5));
        let b = Vector4::new(0.0, 1.0, 0.0, 0.0);
        assert_eq!(solve(&a, &b, &Matrix4::identity(), 1.0), None);
    }
}
