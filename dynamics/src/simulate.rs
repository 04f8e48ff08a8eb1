//! Motion of a [`System`]: acceleration at a point, and integration over time.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use crate::constrained::{
    Baumgarte, FullRank, Solution, SolveError, Tolerance, settle, settle_full_rank, solve,
};
use crate::integrate::{
    DormandPrince, Events, IntegrationError, Segment, State, StateVector, Statistics, rk4_step,
};
use crate::pose::{moved, steady_rate};
use crate::{Constraint, Equation, Point, Real, Scalar, System};

/// Acceleration and multipliers of `system` at `x`, all cases, checked.
///
/// # Errors
///
/// [`SolveError`].
pub fn acceleration<
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
    baumgarte: Option<&Baumgarte<T>>,
    tolerance: &Tolerance<T>,
) -> Result<Solution<T, N, M>, SolveError>
where
    T: Real,
    S: System<T, N, U, M, Z, Q> + ?Sized,
{
    let Equation {
        mass_matrix,
        force,
        constraint,
    } = system.equation(x);
    let b = right_hand_side(&constraint, baumgarte);
    match system.multipliers_at() {
        Some(first) => settle(system, x, first, &b, tolerance),
        None => solve(&mass_matrix, &force, &constraint.a, &b, tolerance),
    }
}

/// Acceleration and multipliers for any scalar (dual numbers, SIMD lanes), unchecked:
/// demands as [`FullRank`]. Forces that depend on multipliers settle in a fixed number of
/// rounds.
pub fn acceleration_full_rank<
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
    baumgarte: Option<&Baumgarte<T>>,
) -> Solution<T, N, M>
where
    T: Scalar,
    S: System<T, N, U, M, Z, Q> + ?Sized,
{
    let Equation {
        mass_matrix,
        force,
        constraint,
    } = system.equation(x);
    let b = right_hand_side(&constraint, baumgarte);
    if let Some(first) = system.multipliers_at() {
        return settle_full_rank(system, x, first, &mass_matrix, &constraint.a, &b);
    }
    FullRank::new(&mass_matrix, &constraint.a).solve(&force, &b)
}

fn right_hand_side<T: Scalar, const N: usize, const M: usize>(
    constraint: &Constraint<T, N, M>,
    baumgarte: Option<&Baumgarte<T>>,
) -> nalgebra::SVector<T, M> {
    baumgarte.map_or(constraint.b, |stabilisation| {
        stabilisation.stabilise(constraint)
    })
}

/// A [`System`] to be moved through time under an input.
///
/// The input is a function of time and state, `[T; U]`; it should be smooth inside one
/// step. Split the run at the instants where it jumps.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Simulation<
    's,
    S: ?Sized,
    T,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
    const Q: usize = N,
> {
    system: &'s S,
    /// Constraint stabilisation, if any.
    pub baumgarte: Option<Baumgarte<T>>,
    /// Thresholds of the rank-revealing solve.
    pub tolerance: Tolerance<T>,
    sizes: PhantomData<([T; M], [T; Q])>,
}

impl<'s, S, T, const N: usize, const U: usize, const M: usize, const Z: usize, const Q: usize>
    Simulation<'s, S, T, N, U, M, Z, Q>
where
    T: Real,
    S: System<T, N, U, M, Z, Q> + ?Sized,
{
    /// Without stabilisation, default tolerance.
    pub fn new(system: &'s S) -> Self {
        Self {
            system,
            baumgarte: None,
            tolerance: Tolerance::default(),
            sizes: PhantomData,
        }
    }

    /// With stabilisation.
    #[must_use]
    pub fn with_baumgarte(mut self, baumgarte: Baumgarte<T>) -> Self {
        self.baumgarte = Some(baumgarte);
        self
    }

    /// Acceleration and multipliers in state `y` under input `u`.
    ///
    /// # Errors
    ///
    /// [`SolveError`].
    pub fn acceleration(
        &self,
        t: T,
        y: &State<T, N, Z, Q>,
        u: [T; U],
    ) -> Result<Solution<T, N, M>, SolveError> {
        let x = Point {
            t,
            q: y.q,
            v: y.v,
            u,
            z: y.z,
        };
        acceleration(self.system, &x, self.baumgarte.as_ref(), &self.tolerance)
    }

    /// Rate of the state, `(dq/dt, a, dz/dt)`; of a pose ([`Pose`](crate::Pose)) with a pull
    /// that keeps its quaternion a unit.
    ///
    /// # Errors
    ///
    /// [`SolveError`].
    pub fn rate(
        &self,
        t: T,
        y: &State<T, N, Z, Q>,
        u: [T; U],
    ) -> Result<State<T, N, Z, Q>, SolveError> {
        let x = Point {
            t,
            q: y.q,
            v: y.v,
            u,
            z: y.z,
        };
        let solution = acceleration(self.system, &x, self.baumgarte.as_ref(), &self.tolerance)?;
        let a = core::array::from_fn(|i| solution.a[i]);
        Ok(State {
            q: steady_rate(self.system.poses(), &y.q, &y.v),
            v: a,
            z: self.system.state_rate(&x),
        })
    }

    /// One Runge–Kutta step of fourth order, [`rk4_step`].
    ///
    /// # Errors
    ///
    /// [`SolveError`].
    pub fn rk4_step(
        &self,
        t: T,
        y: &State<T, N, Z, Q>,
        h: T,
        mut input: impl FnMut(T, &State<T, N, Z, Q>) -> [T; U],
    ) -> Result<State<T, N, Z, Q>, SolveError> {
        rk4_step(|t, y| self.rate(t, y, input(t, y)), t, y, h)
    }

    /// One semi-implicit Euler step, [`crate::integrate::symplectic_euler_step`]; a pose moves along the
    /// exponential map, [`moved`](crate::moved).
    ///
    /// # Errors
    ///
    /// [`SolveError`].
    pub fn symplectic_euler_step(
        &self,
        t: T,
        y: &State<T, N, Z, Q>,
        h: T,
        mut input: impl FnMut(T, &State<T, N, Z, Q>) -> [T; U],
    ) -> Result<State<T, N, Z, Q>, SolveError> {
        let rate = self.rate(t, y, input(t, y))?;
        let v = y.v.add_scaled(h, &rate.v);
        Ok(State {
            q: moved(self.system.poses(), &y.q, &v, h),
            v,
            z: y.z.add_scaled(h, &rate.z),
        })
    }

    /// Adaptive integration; `sink` is given every accepted step,
    /// [`DormandPrince::integrate`].
    ///
    /// # Errors
    ///
    /// [`IntegrationError`], with the [`SolveError`] and its time inside.
    pub fn integrate(
        &self,
        solver: &DormandPrince<T>,
        (t0, y0): (T, &State<T, N, Z, Q>),
        t1: T,
        mut input: impl FnMut(T, &State<T, N, Z, Q>) -> [T; U],
        sink: impl FnMut(&Segment<T, State<T, N, Z, Q>>) -> ControlFlow<()>,
    ) -> Result<(T, State<T, N, Z, Q>, Statistics), IntegrationError<SolveError>> {
        solver.integrate(|t, y| self.rate(t, y, input(t, y)), t0, y0, t1, sink)
    }

    /// Adaptive integration that stops at events, [`DormandPrince::integrate_with_events`].
    ///
    /// # Errors
    ///
    /// [`IntegrationError`], with the [`SolveError`] and its time inside.
    pub fn integrate_with_events<G, A, const K: usize>(
        &self,
        solver: &DormandPrince<T>,
        start: (T, &State<T, N, Z, Q>),
        t1: T,
        mut input: impl FnMut(T, &State<T, N, Z, Q>) -> [T; U],
        events: Events<G, A, K>,
        sink: impl FnMut(&Segment<T, State<T, N, Z, Q>>) -> ControlFlow<()>,
    ) -> Result<(T, State<T, N, Z, Q>, Statistics), IntegrationError<SolveError>>
    where
        G: FnMut(T, &State<T, N, Z, Q>) -> [T; K],
        A: FnMut(usize, T, &mut State<T, N, Z, Q>) -> ControlFlow<()>,
    {
        let rate = |t, y: &State<T, N, Z, Q>| self.rate(t, y, input(t, y));
        solver.integrate_with_events(rate, start, t1, events, sink)
    }

    /// Adaptive integration; `sink` is given the state at equal intervals,
    /// [`DormandPrince::sample`].
    ///
    /// # Errors
    ///
    /// [`IntegrationError`], with the [`SolveError`] and its time inside.
    pub fn sample(
        &self,
        solver: &DormandPrince<T>,
        (t0, y0): (T, &State<T, N, Z, Q>),
        (t1, interval): (T, T),
        mut input: impl FnMut(T, &State<T, N, Z, Q>) -> [T; U],
        sink: impl FnMut(T, &State<T, N, Z, Q>),
    ) -> Result<(State<T, N, Z, Q>, Statistics), IntegrationError<SolveError>> {
        solver.sample(
            |t, y| self.rate(t, y, input(t, y)),
            t0,
            y0,
            t1,
            interval,
            sink,
        )
    }
}
