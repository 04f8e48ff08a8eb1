//! One contact by itself: Signorini's condition and Coulomb's law, solved exactly.
//!
//! With `u = W p + q`, `W` positive definite, in the order tangent, tangent, normal:
//!
//! ```text
//! lifting   p = 0,                 uₙ ≥ 0
//! sticking  u = 0,                 |pₜ| ≤ μ pₙ
//! sliding   uₙ = 0, uₜ = −σ pₜ,    |pₜ| = μ pₙ,   σ > 0
//! ```
//!
//! Of sliding, `σ` is the only unknown: `pₜ(σ)` solves two linear equations, and
//! `f(σ) = |pₜ| − μ pₙ` falls from above zero (no sticking) to below it.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Halvings of the interval that `σ` lies in, at most.
const HALVINGS: usize = 200;
/// What is none: of that interval relative to its end, of `f` relative to the impulse.
const NARROW: f64 = 1e-15;

/// The impulse on a contact with mobility `w`, velocity `q` without it and friction `mu`.
pub(super) fn impulse(w: &Matrix3<f64>, q: &Vector3<f64>, mu: f64) -> Vector3<f64> {
    if q.z >= 0.0 {
        return Vector3::zeros();
    }
    if mu == 0.0 {
        return Vector3::new(0.0, 0.0, -q.z / w.m33);
    }
    let sticks = w.cholesky().map(|factor| -factor.solve(q));
    match sticks {
        Some(p) if p.xy().norm() <= mu * p.z => p,
        _ => sliding(w, q, mu),
    }
}

/// The nearest impulse within the friction cone.
pub(super) fn onto(p: &Vector3<f64>, mu: f64) -> Vector3<f64> {
    let size = p.xy().norm();
    if size <= mu * p.z {
        return *p;
    }
    if mu * size <= -p.z {
        return Vector3::zeros();
    }
    let normal = (p.z + mu * size) / (1.0 + mu * mu);
    let onto = if size > 0.0 { mu * normal / size } else { 0.0 };
    Vector3::new(onto * p.x, onto * p.y, normal)
}

/// `pₜ(σ)` and `pₙ(σ)` with the normal component eliminated: `(S + σ) pₜ = −r`.
struct Sliding {
    /// Eigenvalues of `S = Wₜₜ − wₜₙ wₜₙᵀ/wₙₙ`.
    stiffness: Vector2<f64>,
    axes: Matrix2<f64>,
    /// `r` along the axes.
    push: Vector2<f64>,
    coupling: Vector2<f64>,
    normal: f64,
    pressing: f64,
}

impl Sliding {
    fn new(w: &Matrix3<f64>, q: &Vector3<f64>) -> Self {
        let coupling = Vector2::new(w.m13, w.m23);
        let normal = w.m33;
        let block: Matrix2<f64> = w.fixed_view::<2, 2>(0, 0).into_owned();
        let eigen = (block - coupling * coupling.transpose() / normal).symmetric_eigen();
        Self {
            push: eigen.eigenvectors.transpose() * (q.xy() - coupling * (q.z / normal)),
            stiffness: eigen.eigenvalues.map(|value| value.max(0.0)),
            axes: eigen.eigenvectors,
            coupling,
            normal,
            pressing: -q.z,
        }
    }

    fn at(&self, sigma: f64) -> Vector3<f64> {
        let along = self.push.zip_map(&self.stiffness, |r, s| -r / (s + sigma));
        let tangent = self.axes * along;
        let normal = (self.pressing - self.coupling.dot(&tangent)) / self.normal;
        Vector3::new(tangent.x, tangent.y, normal)
    }
}

fn sliding(w: &Matrix3<f64>, q: &Vector3<f64>, mu: f64) -> Vector3<f64> {
    let law = Sliding::new(w, q);
    let excess = |sigma: f64| {
        let p = law.at(sigma);
        p.xy().norm() - mu * p.z
    };
    let (mut low, mut high) = (0.0, law.stiffness.max().max(law.normal));
    while excess(high) > 0.0 && high.is_finite() {
        (low, high) = (high, 4.0 * high);
    }
    let (mut at_low, mut at_high) = (excess(low), excess(high));
    // False position; an end that stays twice counts half (Illinois), so that both ends move.
    let mut above = false;
    for _ in 0..HALVINGS {
        if high - low <= NARROW * high {
            break;
        }
        let share = at_low / (at_low - at_high);
        let share = if share.is_finite() { share } else { 0.5 };
        let middle = low + share.clamp(1e-3, 1.0 - 1e-3) * (high - low);
        let found = excess(middle);
        let retained = (found > 0.0) == above;
        above = found > 0.0;
        if found.abs() <= NARROW * law.pressing / law.normal {
            (low, high) = (middle, middle);
        } else if above {
            (low, at_low) = (middle, found);
            at_high /= if retained { 2.0 } else { 1.0 };
        } else {
            (high, at_high) = (middle, found);
            at_low /= if retained { 2.0 } else { 1.0 };
        }
    }
    let p = law.at((low + high) / 2.0);
    let size = p.xy().norm();
    // On the cone, not beside it by rounding.
    let onto = if size > 0.0 { mu * p.z / size } else { 0.0 };
    Vector3::new(onto * p.x, onto * p.y, p.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A positive definite mobility from nine numbers.
    fn mobility(entries: [f64; 9]) -> Matrix3<f64> {
        let root = Matrix3::from_row_slice(&entries);
        root * root.transpose() + Matrix3::identity() * 0.05
    }

    proptest! {
        /// Every answer fulfils the law it was made for.
        #[test]
        fn the_law_holds(
            entries in prop::array::uniform9(-2.0..2.0_f64),
            q in prop::array::uniform3(-3.0..3.0_f64),
            mu in 0.0..3.0_f64,
        ) {
            let (w, q) = (mobility(entries), Vector3::from(q));
            let p = impulse(&w, &q, mu);
            let u = w * p + q;
            let (slip, friction) = (u.xy(), p.xy());
            prop_assert!(p.z >= 0.0 && u.z >= -1e-9, "presses {p}, moves {u}");
            prop_assert!((p.z * u.z).abs() < 1e-9);
            prop_assert!(friction.norm() <= mu * p.z + 1e-12);
            // Friction opposes slip, with all it has.
            let power = slip.dot(&friction) + mu * p.z * slip.norm();
            prop_assert!(power.abs() < 1e-7 * (1.0 + p.norm()), "slips {slip} under {friction}");
        }
    }
}
