//! The constrained equation of motion (Udwadia–Kalaba, thesis 3.38–3.54).
//!
//! Given inertia `M` (n×n), force `Qbar` (n) and constraint `A a = b` (m×n), find the
//! acceleration `a` and the multipliers `λ` with
//!
//! ```text
//! M a = Qbar + Aᵀ λ,   A a = b        i.e.   K [a; −λ] = [Qbar; b],  K = [[M, Aᵀ], [A, 0]]
//! ```
//!
//! | path | numbers | demands | checks |
//! |---|---|---|---|
//! | [`FullRank`] | any [`Scalar`]: dual, SIMD | `M` positive definite, `A` of full row rank | none: else infinite or NaN |
//! | [`Branched`] | any [`Scalar`] | as [`FullRank`]; `M` with the zeros of a tree | none |
//! | [`RankRevealing`] | `f32`, `f64` | `M ≥ 0`, `rank [M; A] = n`, `b ∈ R(A)` | all, each an error |
//! | [`solve`] | `f32`, `f64` | as `RankRevealing` | takes the first where it is safe, else the second |
//!
//! Conventions (they overrule the thesis where it contradicts itself): the constraint
//! force is `Q_I = +Aᵀ λ`; `S = Tᵀ`.

mod baumgarte;
mod branched;
mod contact;
mod error;
mod full_rank;
mod projectors;
mod rank_revealing;
mod tolerance;

pub use baumgarte::Baumgarte;
pub use branched::Branched;
pub(crate) use contact::{settle, settle_full_rank};
pub use error::{Quantity, SolveError};
pub use full_rank::FullRank;
pub use projectors::Projectors;
pub use rank_revealing::RankRevealing;
pub use tolerance::Tolerance;

use nalgebra::{SMatrix, SVector};

use crate::linalg::{from_rows, transpose_mul};
use crate::{Real, Scalar};

/// Motion of a constrained system at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T, const N: usize, const M: usize> {
    /// Acceleration `a = L b + P Qbar` (3.39).
    pub a: SVector<T, N>,
    /// Multipliers `λ = G⁺ (b − A M⁻¹ Qbar)`; of redundant constraints the shortest.
    pub lambda: SVector<T, M>,
    /// Force of the constraints on the coordinates, `Q_I = Aᵀ λ`.
    pub constraint_force: SVector<T, N>,
}

impl<T: Scalar, const N: usize, const M: usize> Solution<T, N, M> {
    /// Completes `(a, λ)` by the constraint force.
    #[inline]
    pub(crate) fn new(
        constraint: &SMatrix<T, M, N>,
        a: SVector<T, N>,
        lambda: SVector<T, M>,
    ) -> Self {
        Self {
            a,
            lambda,
            constraint_force: transpose_mul(constraint, &lambda),
        }
    }
}

/// Solves for acceleration and multipliers, real numbers, all cases.
///
/// The fast factorisation is used when its pivots show that it is accurate (every
/// pivot of `M` and of `G = A M⁻¹ Aᵀ` above ε^(3/8) of its diagonal element, 1.3e-6
/// for `f64`); otherwise the rank-revealing one with `tolerance`.
///
/// # Errors
///
/// [`SolveError`]: a number that is not finite, `M` not symmetric or not positive
/// semidefinite, `rank [M; A] < n`, constraints that contradict each other.
///
/// ```
/// use dynamics::constrained::{Tolerance, solve};
/// use nalgebra::{SMatrix, SVector};
///
/// // A unit mass in the plane under gravity, held on the line x = y, said twice.
/// let mass = SMatrix::<f64, 2, 2>::identity();
/// let force = SVector::from([0.0, -9.81]);
/// let a = SMatrix::<f64, 2, 2>::new(1.0, -1.0, 2.0, -2.0);
/// let b = SVector::from([0.0, 0.0]);
/// let x = solve(&mass, &force, &a, &b, &Tolerance::default()).unwrap();
/// assert!((x.a[0] + 4.905).abs() < 1e-14 && (x.a[1] + 4.905).abs() < 1e-14);
/// ```
pub fn solve<T: Real, const N: usize, const M: usize>(
    mass: &SMatrix<T, N, N>,
    force: &SVector<T, N>,
    a: &SMatrix<T, M, N>,
    b: &SVector<T, M>,
    tolerance: &Tolerance<T>,
) -> Result<Solution<T, N, M>, SolveError> {
    rank_revealing::check_symmetric(mass, tolerance)?;
    error::finite(Quantity::Constraint, a)?;
    error::finite(Quantity::Force, force)?;
    error::finite(Quantity::ConstraintRate, b)?;
    let fast = FullRank::new(mass, a);
    if fast.is_well_conditioned(mass) {
        let solution = fast.solve(force, b);
        error::finite(Quantity::Acceleration, &solution.a)?;
        error::finite(Quantity::Multiplier, &solution.lambda)?;
        return Ok(solution);
    }
    RankRevealing::new(mass, a, tolerance)?.solve(force, b)
}

/// [`solve`] over plain arrays (rows first), default tolerance: `(a, λ)`.
///
/// # Errors
///
/// As [`solve`].
///
/// ```
/// let (a, lambda) =
///     dynamics::constrained::solve_arrays(&[[2.0]], &[6.0], &[[1.0]], &[0.0]).unwrap();
/// assert_eq!((a, lambda), ([0.0], [-6.0]));
/// ```
pub fn solve_arrays<T: Real, const N: usize, const M: usize>(
    mass: &[[T; N]; N],
    force: &[T; N],
    a: &[[T; N]; M],
    b: &[T; M],
) -> Result<([T; N], [T; M]), SolveError> {
    let (force, b) = (
        SVector::from_fn(|i, _| force[i]),
        SVector::from_fn(|i, _| b[i]),
    );
    let x = solve(
        &from_rows(mass),
        &force,
        &from_rows(a),
        &b,
        &Tolerance::default(),
    )?;
    Ok((
        core::array::from_fn(|i| x.a[i]),
        core::array::from_fn(|i| x.lambda[i]),
    ))
}

/// The full-rank path over plain arrays (rows first), any [`Scalar`]: `(a, λ)`.
/// Demands as [`FullRank`]; nothing is checked.
pub fn solve_full_rank_arrays<T: Scalar, const N: usize, const M: usize>(
    mass: &[[T; N]; N],
    force: &[T; N],
    a: &[[T; N]; M],
    b: &[T; M],
) -> ([T; N], [T; M]) {
    let (force, b) = (
        SVector::from_fn(|i, _| force[i]),
        SVector::from_fn(|i, _| b[i]),
    );
    let x = FullRank::new(&from_rows(mass), &from_rows(a)).solve(&force, &b);
    (
        core::array::from_fn(|i| x.a[i]),
        core::array::from_fn(|i| x.lambda[i]),
    )
}

#[cfg(test)]
mod tests;
