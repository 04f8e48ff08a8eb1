//! The laws of one contact as a fixed point: impulses `p` with `p = g(p − u/ρ)`, for any `ρ > 0`.

use super::cone;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// A law of contacts, in the order tangent, tangent, normal.
#[derive(Clone, Copy, Debug)]
pub(super) enum Law {
    /// Coulomb's: the normal part onto what presses, then the tangent onto the disc of `μ` times that.
    Coulomb,
    /// The associated one: the nearest point of the friction cone.
    Associated,
}

impl Law {
    /// `g(z)`.
    pub fn goal(self, z: &Vector3<f64>, mu: f64) -> Vector3<f64> {
        match self {
            Law::Associated => cone::onto(z, mu),
            Law::Coulomb => {
                let pressing = z.z.max(0.0);
                let (size, most) = (z.xy().norm(), mu * pressing);
                let share = if size > most { most / size } else { 1.0 };
                Vector3::new(share * z.x, share * z.y, pressing)
            }
        }
    }

    /// `∂g/∂z`; on an edge, that of one side.
    pub fn slope(self, z: &Vector3<f64>, mu: f64) -> Matrix3<f64> {
        let along = z.xy();
        let size = along.norm();
        match self {
            Law::Coulomb => {
                let presses = if z.z > 0.0 { 1.0 } else { 0.0 };
                let most = mu * z.z.max(0.0);
                if size > most {
                    let to = along / size;
                    join(
                        turn(&to) * (most / size),
                        to * mu * presses,
                        Vector2::zeros(),
                        presses,
                    )
                } else {
                    Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, presses))
                }
            }
            Law::Associated if size <= mu * z.z => Matrix3::identity(),
            Law::Associated if mu * size <= -z.z => Matrix3::zeros(),
            Law::Associated => {
                // Outside of the cone: `gₙ = (zₙ + μ |zₜ|)/(1 + μ²)`, `gₜ = μ gₙ zₜ/|zₜ|`.
                let to = along / size;
                let share = 1.0 / (1.0 + mu * mu);
                let normal = (z.z + mu * size) * share;
                let tangent = to * to.transpose() * (mu * mu * share);
                let around = turn(&to) * (mu * normal / size);
                let across = to * (mu * share);
                join(tangent + around, across, across, share)
            }
        }
    }
}

/// What is across `to` in the plane.
fn turn(to: &Vector2<f64>) -> Matrix2<f64> {
    Matrix2::identity() - to * to.transpose()
}

/// `[tangent, of_normal; on_normalᵀ, normal]`.
fn join(
    tangent: Matrix2<f64>,
    of_normal: Vector2<f64>,
    on_normal: Vector2<f64>,
    normal: f64,
) -> Matrix3<f64> {
    let mut all = Matrix3::zeros();
    all.fixed_view_mut::<2, 2>(0, 0).copy_from(&tangent);
    all.fixed_view_mut::<2, 1>(0, 2).copy_from(&of_normal);
    all.fixed_view_mut::<1, 2>(2, 0)
        .copy_from(&on_normal.transpose());
    all[(2, 2)] = normal;
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Slopes are those of differences, on every piece.
        #[test]
        fn slopes_are_those_of_differences(
            z in prop::array::uniform3(-2.0..2.0_f64),
            mu in 0.05..1.5_f64,
        ) {
            let (z, step) = (Vector3::from(z), 1e-6);
            for law in [Law::Coulomb, Law::Associated] {
                let edges = [z.xy().norm() - mu * z.z, mu * z.xy().norm() + z.z, z.z, z.xy().norm()];
                prop_assume!(edges.iter().all(|edge| edge.abs() > 1e-3));
                let slope = law.slope(&z, mu);
                for k in 0..3 {
                    let way = Vector3::ith(k, step);
                    let ahead = law.goal(&(z + way), mu) - law.goal(&(z - way), mu);
                    let off = (ahead / (2.0 * step) - slope.column(k)).amax();
                    prop_assert!(off < 1e-6, "{law:?} misses by {off}");
                }
            }
        }
    }
}
