//! What a generated model is to everything else: [`System`].

use nalgebra::{SMatrix, SVector};

use crate::{Pose, Scalar};

/// Where a model is evaluated: time, positions, velocities, inputs, internal states.
///
/// There are as many positions as velocities, `Q = N`, unless bodies float by their twists
/// ([`Pose`]): of these each has one position more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T, const N: usize, const U: usize, const Z: usize, const Q: usize = N> {
    /// Time `t`, s.
    pub t: T,
    /// Positions `q`, m or rad: the generalised coordinates, and poses of floating bodies.
    pub q: [T; Q],
    /// Generalised velocities `v`, m/s or rad/s: `dq/dt`, and twists of floating bodies.
    pub v: [T; N],
    /// Inputs `u`, in the unit the model declares; behind them what a generated model adds:
    /// delayed inputs, and the multipliers that its forces depend on.
    pub u: [T; U],
    /// Internal first-order states `z` (friction bristles, actuator lags, …).
    pub z: [T; Z],
}

impl<T: Scalar, const N: usize, const U: usize, const Z: usize, const Q: usize>
    Point<T, N, U, Z, Q>
{
    /// The origin: everything 0.
    pub fn zero() -> Self {
        let zero = T::zero();
        Self {
            t: zero,
            q: [zero; Q],
            v: [zero; N],
            u: [zero; U],
            z: [zero; Z],
        }
    }
}

/// All constraints of a model at one point, on acceleration level: `A a = b`
/// (thesis 3.28–3.30).
///
/// For a holonomic row, `c(q,t) = 0`: `A = ∂c/∂q` and `b = A a − c̈`. For a
/// nonholonomic row, `c(q,v,t) = 0`: `A = ∂c/∂v` and `b = A a − ċ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint<T, const N: usize, const M: usize> {
    /// `A`, m×n.
    pub a: SMatrix<T, M, N>,
    /// `b`, without stabilisation.
    pub b: SVector<T, M>,
    /// Violation: `c(q,t)` of a holonomic row, `c(q,v,t)` of a nonholonomic one.
    pub c: SVector<T, M>,
    /// `ċ = dc/dt` of a holonomic row; of a nonholonomic row not used (leave 0).
    pub c_dot: SVector<T, M>,
    /// Whether row i is holonomic.
    pub holonomic: [bool; M],
}

impl<T: Scalar, const N: usize> Constraint<T, N, 0> {
    /// No constraint.
    pub fn none() -> Self {
        let empty = SVector::from_fn(|_, _| T::zero());
        Self {
            a: SMatrix::from_fn(|_, _| T::zero()),
            b: empty,
            c: empty,
            c_dot: empty,
            holonomic: [],
        }
    }
}

/// All terms of the equation of motion at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equation<T, const N: usize, const M: usize> {
    /// Generalised inertia, N×N.
    pub mass_matrix: SMatrix<T, N, N>,
    /// Generalised force `Qbar`, N.
    pub force: SVector<T, N>,
    /// The constraint rows.
    pub constraint: Constraint<T, N, M>,
}

/// A mechanical system `M a = Qbar + Aᵀ λ`, `A a = b` (thesis 3.17, 3.38) with `N`
/// velocities, `U` inputs, `M` constraint rows, `Z` internal states and `Q` positions: `N` of
/// these, and one more for each of its [`poses`](Self::poses).
///
/// Implemented by generated code for every [`Scalar`]; parameters live in `self`.
pub trait System<
    T: Scalar,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const Q: usize = N,
>
{
    /// Generalised inertia `M(q)`, N×N, symmetric.
    fn mass_matrix(&self, x: &Point<T, N, U, Z, Q>) -> SMatrix<T, N, N>;

    /// Generalised force `Qbar = Q_C + Q_D + Q_u + Q_z`: bias (fictitious and
    /// conservative), dissipative, actuation, non-ideal constraint forces.
    fn force(&self, x: &Point<T, N, U, Z, Q>) -> SVector<T, N>;

    /// The constraint rows.
    fn constraint(&self, x: &Point<T, N, U, Z, Q>) -> Constraint<T, N, M>;

    /// Where the poses of bodies stand that float by their twists, in order; everything else
    /// has one position for one velocity.
    fn poses(&self) -> &'static [Pose] {
        &[]
    }

    /// Where in `u` the forces read the constraints' multipliers, if they do (contact
    /// friction): the first of `M` places. Whoever solves the equation of motion fills
    /// them in.
    fn multipliers_at(&self) -> Option<usize> {
        None
    }

    /// Rates `dz/dt` of the internal states.
    fn state_rate(&self, x: &Point<T, N, U, Z, Q>) -> [T; Z];

    /// Everything at once. Generated code computes what the terms share, such as
    /// sines and cosines, a single time.
    fn equation(&self, x: &Point<T, N, U, Z, Q>) -> Equation<T, N, M> {
        Equation {
            mass_matrix: self.mass_matrix(x),
            force: self.force(x),
            constraint: self.constraint(x),
        }
    }
}
