//! Forces that depend on multipliers: contact friction.
//!
//! `M a = Q(λ) + Aᵀλ`, `A a = b` is a nonlinear equation for `λ`. It is solved by a fixed
//! point: `Q` is evaluated at the last `λ`, and the equation of motion is solved again,
//!
//! ```text
//! λ₀ = 0,   G λₖ₊₁ = b − A M⁻¹ Q(λₖ),   G = A M⁻¹ Aᵀ
//! ```
//!
//! Friction along the contact of a body whose centre is in the contact leaves `λ` as it is:
//! one round. In general the rounds converge where `‖G⁻¹ A M⁻¹ ∂Q/∂λ‖ < 1`: what the
//! friction changes in the contact force is less than what made the friction. Past that a
//! contact jams or has several motions (Painlevé); that is an error, not a number.

use nalgebra::{SMatrix, SVector};

use super::{FullRank, Solution, SolveError, Tolerance, solve};
use crate::{Equation, Point, Real, Scalar, System};

/// Rounds at most.
const ROUNDS: usize = 60;
/// Rounds where no comparison can be made: friction that couples back by a tenth is then
/// right to nine digits.
const BLIND_ROUNDS: usize = 8;

/// Puts multipliers where the system's forces read them.
fn with_multipliers<
    T: Scalar,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const Q: usize,
>(
    x: &Point<T, N, U, Z, Q>,
    first: usize,
    lambda: &SVector<T, M>,
) -> Point<T, N, U, Z, Q> {
    let mut x = *x;
    for (place, &value) in x.u.iter_mut().skip(first).zip(lambda.iter()) {
        *place = value;
    }
    x
}

/// Solves for acceleration and multipliers where the forces read multipliers from
/// `u[first..]`.
pub(crate) fn settle<
    T,
    S,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const Q: usize,
>(
    system: &S,
    x: &Point<T, N, U, Z, Q>,
    first: usize,
    b: &SVector<T, M>,
    tolerance: &Tolerance<T>,
) -> Result<Solution<T, N, M>, SolveError>
where
    T: Real,
    S: System<T, N, U, M, Z, Q> + ?Sized,
{
    let mut lambda = SVector::<T, M>::from_fn(|_, _| T::zero());
    let Equation {
        mass_matrix,
        constraint,
        ..
    } = system.equation(&with_multipliers(x, first, &lambda));
    let mut worst = 0;
    for _ in 0..ROUNDS {
        let force = system.force(&with_multipliers(x, first, &lambda));
        let solution = solve(&mass_matrix, &force, &constraint.a, b, tolerance)?;
        let mut settled = true;
        for row in 0..M {
            let (new, old) = (solution.lambda[row], lambda[row]);
            let small = T::epsilon() * T::from_f64(64.0) * (T::one() + new.abs());
            if (new - old).abs() > small {
                (settled, worst) = (false, row);
            }
        }
        lambda = solution.lambda;
        if settled {
            return Ok(solution);
        }
    }
    Err(SolveError::Unsettled { row: worst })
}

/// The same for any scalar, unchecked: a fixed number of rounds, demands as [`FullRank`].
pub(crate) fn settle_full_rank<
    T,
    S,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const Q: usize,
>(
    system: &S,
    x: &Point<T, N, U, Z, Q>,
    first: usize,
    mass: &SMatrix<T, N, N>,
    a: &SMatrix<T, M, N>,
    b: &SVector<T, M>,
) -> Solution<T, N, M>
where
    T: Scalar,
    S: System<T, N, U, M, Z, Q> + ?Sized,
{
    let factored = FullRank::new(mass, a);
    let nothing = SVector::<T, M>::from_fn(|_, _| T::zero());
    let mut solution = factored.solve(&system.force(&with_multipliers(x, first, &nothing)), b);
    for _ in 0..BLIND_ROUNDS {
        let force = system.force(&with_multipliers(x, first, &solution.lambda));
        solution = factored.solve(&force, b);
    }
    solution
}
