//! Derivatives of the constrained motion, by the implicit function theorem.
//!
//! `a` and `λ` solve `K [a; −λ] = [Qbar; b]`, so for any variable `s`
//!
//! ```text
//! K ∂[a; −λ]/∂s = −∂[R; S]/∂s,   R = M a − Qbar − Aᵀ λ,   S = A a − b,
//! ```
//!
//! with `R` and `S` differentiated at fixed `a, λ`: first derivatives only, which generated
//! code computes; `K` is factorised once for the motion and all its derivatives.

use nalgebra::{SMatrix, SVector};

use crate::constrained::{FullRank, RankRevealing, Solution, SolveError, Tolerance};
use crate::{Point, Real, Scalar, System};

/// `∂R/∂s` and `∂S/∂s` at stated `a, λ`, one column per variable `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualDerivatives<T, const N: usize, const U: usize, const M: usize> {
    /// `∂R/∂q`, N×N.
    pub force_by_position: SMatrix<T, N, N>,
    /// `∂R/∂v`, N×N.
    pub force_by_velocity: SMatrix<T, N, N>,
    /// `∂R/∂u`, N×U. (`S` does not depend on the inputs.)
    pub force_by_input: SMatrix<T, N, U>,
    /// `∂R/∂t`, N.
    pub force_by_time: SVector<T, N>,
    /// `∂S/∂q`, M×N.
    pub acceleration_by_position: SMatrix<T, M, N>,
    /// `∂S/∂v`, M×N.
    pub acceleration_by_velocity: SMatrix<T, M, N>,
    /// `∂S/∂t`, M.
    pub acceleration_by_time: SVector<T, M>,
}

/// A system whose residuals can be differentiated. Generated with the function
/// `residual_derivatives`.
pub trait Differentiable<
    T: Scalar,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const Q: usize = N,
>: System<T, N, U, M, Z, Q>
{
    /// The residuals' derivatives at acceleration `a` and multipliers `lambda`.
    fn residual_derivatives(
        &self,
        x: &Point<T, N, U, Z, Q>,
        a: &[T; N],
        lambda: &[T; M],
    ) -> ResidualDerivatives<T, N, U, M>;
}

/// A system whose residuals can be differentiated by its `P` parameters. Generated with
/// the function `residual_by_parameters`.
pub trait ParameterDerivatives<
    T: Scalar,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const P: usize,
    const Q: usize = N,
>: System<T, N, U, M, Z, Q>
{
    /// `∂R/∂p` (N×P) and `∂S/∂p` (M×P) at acceleration `a` and multipliers `lambda`.
    fn residual_by_parameters(
        &self,
        x: &Point<T, N, U, Z, Q>,
        a: &[T; N],
        lambda: &[T; M],
    ) -> (SMatrix<T, N, P>, SMatrix<T, M, P>);
}

/// The motion at one point with its derivatives; per pair, `∂a/∂s` then `∂λ/∂s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionDerivatives<T, const N: usize, const U: usize, const M: usize> {
    /// `a`, `λ` and the constraint force.
    pub motion: Solution<T, N, M>,
    /// By `q`.
    pub by_position: (SMatrix<T, N, N>, SMatrix<T, M, N>),
    /// By `v`.
    pub by_velocity: (SMatrix<T, N, N>, SMatrix<T, M, N>),
    /// By `u`.
    pub by_input: (SMatrix<T, N, U>, SMatrix<T, M, U>),
    /// By `t`.
    pub by_time: (SVector<T, N>, SVector<T, M>),
}

/// Motion and derivatives at `x`, all cases, checked: the fast factorisation where it is
/// accurate, else the rank-revealing one, as [`constrained::solve`](crate::constrained::solve).
///
/// With redundant constraints the derivatives are those along which the rank stays, and
/// `∂λ` is the shortest that fits.
///
/// # Errors
///
/// [`SolveError`].
///
/// ```
/// use dynamics::constrained::Tolerance;
/// use dynamics::nalgebra::{SMatrix, SVector};
/// use dynamics::{
///     Constraint, Differentiable, Point, ResidualDerivatives, Scalar, System, motion_derivatives,
/// };
///
/// /// A pendulum of unit length and mass: a = −g sin q + u. Generated code looks like this.
/// struct Pendulum;
/// # const G: f64 = 9.81;
///
/// impl<T: Scalar> System<T, 1, 1, 0, 0> for Pendulum {
///     fn mass_matrix(&self, _: &Point<T, 1, 1, 0>) -> SMatrix<T, 1, 1> {
///         SMatrix::from([[T::one()]])
///     }
///     fn force(&self, x: &Point<T, 1, 1, 0>) -> SVector<T, 1> {
///         SVector::from([x.u[0] - T::from_f64(G) * x.q[0].sin()])
///     }
///     fn constraint(&self, _: &Point<T, 1, 1, 0>) -> Constraint<T, 1, 0> {
///         Constraint::none()
///     }
///     fn state_rate(&self, _: &Point<T, 1, 1, 0>) -> [T; 0] {
///         []
///     }
/// }
///
/// impl<T: Scalar> Differentiable<T, 1, 1, 0, 0> for Pendulum {
///     fn residual_derivatives(
///         &self,
///         x: &Point<T, 1, 1, 0>,
///         _a: &[T; 1],
///         _lambda: &[T; 0],
///     ) -> ResidualDerivatives<T, 1, 1, 0> {
///         ResidualDerivatives {
///             force_by_position: SMatrix::from([[T::from_f64(G) * x.q[0].cos()]]),
///             force_by_input: SMatrix::from([[-T::one()]]),
///             ..ResidualDerivatives::zero()
///         }
///     }
/// }
///
/// let x = Point { q: [0.5], ..Point::zero() };
/// let slopes = motion_derivatives(&Pendulum, &x, &Tolerance::default()).unwrap();
/// assert_eq!(slopes.by_position.0[(0, 0)], -G * 0.5_f64.cos());
/// assert_eq!(slopes.by_input.0[(0, 0)], 1.0);
/// ```
pub fn motion_derivatives<
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
    tolerance: &Tolerance<T>,
) -> Result<MotionDerivatives<T, N, U, M>, SolveError>
where
    T: Real,
    S: Differentiable<T, N, U, M, Z, Q> + ?Sized,
{
    let (factors, motion) = checked(system, x, tolerance)?;
    let residuals = residuals(system, x, &motion);
    Ok(assemble(motion, residuals, &factors))
}

/// As [`motion_derivatives`], for any scalar (dual numbers, SIMD lanes), unchecked:
/// demands as [`FullRank`].
pub fn motion_derivatives_full_rank<
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
) -> MotionDerivatives<T, N, U, M>
where
    T: Scalar,
    S: Differentiable<T, N, U, M, Z, Q> + ?Sized,
{
    let equation = system.equation(x);
    let factors = FullRank::new(&equation.mass_matrix, &equation.constraint.a);
    let motion = factors.solve(&equation.force, &equation.constraint.b);
    let residuals = residuals(system, x, &motion);
    assemble(motion, residuals, &factors)
}

/// The motion at `x` with `∂a/∂p` (N×P) and `∂λ/∂p` (M×P), all cases, checked.
///
/// # Errors
///
/// [`SolveError`].
#[expect(clippy::type_complexity, reason = "a motion and a pair of matrices")]
pub fn motion_by_parameters<
    T,
    S,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const P: usize,
    const Q: usize,
>(
    system: &S,
    x: &Point<T, N, U, Z, Q>,
    tolerance: &Tolerance<T>,
) -> Result<(Solution<T, N, M>, (SMatrix<T, N, P>, SMatrix<T, M, P>)), SolveError>
where
    T: Real,
    S: ParameterDerivatives<T, N, U, M, Z, P, Q> + ?Sized,
{
    let (factors, motion) = checked(system, x, tolerance)?;
    let (a, lambda) = (array(&motion.a), array(&motion.lambda));
    let (dr, ds) = system.residual_by_parameters(x, &a, &lambda);
    Ok((motion, factors.derivatives(&dr, &ds)))
}

impl<T: Scalar, const N: usize, const U: usize, const M: usize> ResidualDerivatives<T, N, U, M> {
    /// All zero.
    pub fn zero() -> Self {
        use crate::linalg::zeros;
        Self {
            force_by_position: zeros(),
            force_by_velocity: zeros(),
            force_by_input: zeros(),
            force_by_time: zeros(),
            acceleration_by_position: zeros(),
            acceleration_by_velocity: zeros(),
            acceleration_by_time: zeros(),
        }
    }
}

/// Factors of `K`, of either kind.
trait Factors<T: Scalar, const N: usize, const M: usize> {
    fn derivatives<const C: usize>(
        &self,
        dr: &SMatrix<T, N, C>,
        ds: &SMatrix<T, M, C>,
    ) -> (SMatrix<T, N, C>, SMatrix<T, M, C>);
}

impl<T: Scalar, const N: usize, const M: usize> Factors<T, N, M> for FullRank<T, N, M> {
    fn derivatives<const C: usize>(
        &self,
        dr: &SMatrix<T, N, C>,
        ds: &SMatrix<T, M, C>,
    ) -> (SMatrix<T, N, C>, SMatrix<T, M, C>) {
        FullRank::derivatives(self, dr, ds)
    }
}

/// Whichever factors are accurate.
enum Checked<T: Real, const N: usize, const M: usize> {
    Fast(FullRank<T, N, M>),
    Safe(RankRevealing<T, N, M>),
}

impl<T: Real, const N: usize, const M: usize> Factors<T, N, M> for Checked<T, N, M> {
    fn derivatives<const C: usize>(
        &self,
        dr: &SMatrix<T, N, C>,
        ds: &SMatrix<T, M, C>,
    ) -> (SMatrix<T, N, C>, SMatrix<T, M, C>) {
        match self {
            Self::Fast(factors) => factors.derivatives(dr, ds),
            Self::Safe(factors) => factors.derivatives(dr, ds),
        }
    }
}

type CheckedMotion<T, const N: usize, const M: usize> = (Checked<T, N, M>, Solution<T, N, M>);

/// The motion at `x`, and the factors it was found with.
fn checked<T, S, const N: usize, const U: usize, const M: usize, const Z: usize, const Q: usize>(
    system: &S,
    x: &Point<T, N, U, Z, Q>,
    tolerance: &Tolerance<T>,
) -> Result<CheckedMotion<T, N, M>, SolveError>
where
    T: Real,
    S: System<T, N, U, M, Z, Q> + ?Sized,
{
    let equation = system.equation(x);
    let (mass, a) = (&equation.mass_matrix, &equation.constraint.a);
    let (force, b) = (&equation.force, &equation.constraint.b);
    // Refuses what is not finite or not symmetric, whichever factors are taken.
    let motion = crate::constrained::solve(mass, force, a, b, tolerance)?;
    let fast = FullRank::new(mass, a);
    let factors = if fast.is_well_conditioned(mass) {
        Checked::Fast(fast)
    } else {
        Checked::Safe(RankRevealing::new(mass, a, tolerance)?)
    };
    Ok((factors, motion))
}

fn residuals<T, S, const N: usize, const U: usize, const M: usize, const Z: usize, const Q: usize>(
    system: &S,
    x: &Point<T, N, U, Z, Q>,
    motion: &Solution<T, N, M>,
) -> ResidualDerivatives<T, N, U, M>
where
    T: Scalar,
    S: Differentiable<T, N, U, M, Z, Q> + ?Sized,
{
    system.residual_derivatives(x, &array(&motion.a), &array(&motion.lambda))
}

fn assemble<T: Scalar, const N: usize, const U: usize, const M: usize>(
    motion: Solution<T, N, M>,
    r: ResidualDerivatives<T, N, U, M>,
    factors: &impl Factors<T, N, M>,
) -> MotionDerivatives<T, N, U, M> {
    let none = crate::linalg::zeros();
    MotionDerivatives {
        motion,
        by_position: factors.derivatives(&r.force_by_position, &r.acceleration_by_position),
        by_velocity: factors.derivatives(&r.force_by_velocity, &r.acceleration_by_velocity),
        by_input: factors.derivatives(&r.force_by_input, &none),
        by_time: factors.derivatives(&r.force_by_time, &r.acceleration_by_time),
    }
}

fn array<T: Scalar, const K: usize>(vector: &SVector<T, K>) -> [T; K] {
    core::array::from_fn(|i| vector[i])
}
