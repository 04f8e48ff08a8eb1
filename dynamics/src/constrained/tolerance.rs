//! When a number counts as zero in the rank-revealing solve.

use crate::Real;

/// Thresholds of [`RankRevealing`](super::RankRevealing).
///
/// Defaults, with ε the machine epsilon: `rank` ε^(3/4) (1.8e-12 for `f64`, 6.4e-6 for
/// `f32`), `mass` the same, `consistency` √ε (1.5e-8, 3.5e-4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<T> {
    /// A singular value of `A` (its rows scaled to unit length first, so that units do
    /// not matter) below `rank` times the largest counts as zero. Raise it to the
    /// drift of the constraint when redundant rows hold only on the constraint
    /// manifold and the state drifts off it.
    pub rank: T,
    /// `M` counts as singular when a pivot is below `mass` times its diagonal element,
    /// as indefinite when `M + mass · max(diag M) · I` is not positive definite, and as
    /// unsymmetric when mirrored elements differ by more than `√mass · max |M|`.
    pub mass: T,
    /// `b` counts as inconsistent when its part outside `R(A)` exceeds
    /// `consistency · (1 + |b|)` (Euclidean length, in the units of `b`).
    pub consistency: T,
}

impl<T: Real> Default for Tolerance<T> {
    fn default() -> Self {
        let consistency = T::epsilon().sqrt();
        let rank = consistency * consistency.sqrt();
        Self {
            rank,
            mass: rank,
            consistency,
        }
    }
}
