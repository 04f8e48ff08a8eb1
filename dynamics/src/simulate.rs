//! Motion of a [`System`]: acceleration at a point, and integration over time.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use crate::constrained::{
    Baumgarte, FullRank, Solution, SolveError, Tolerance, settle, settle_full_rank, solve,
};
use crate::integrate::{
    DormandPrince, Events, IntegrationError, Segment, State, Statistics, rk4_step,
    symplectic_euler_step,
};
use crate::{Constraint, Equation, Point, Real, Scalar, System};

/// Acceleration and multipliers of `system` at `x`, all cases, checked.
///
/// # Errors
///
/// [`SolveError`].
pub fn acceleration<T, S, const N: usize, const U: usize, const M: usize, const Z: usize>(
    system: &S,
    x: &Point<T, N, U, Z>,
    baumgarte: Option<&Baumgarte<T>>,
    tolerance: &Tolerance<T>,
) -> Result<Solution<T, N, M>, SolveError>
where
    T: Real,
    S: System<T, N, U, M, Z> + ?Sized,
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
>(
    system: &S,
    x: &Point<T, N, U, Z>,
    baumgarte: Option<&Baumgarte<T>>,
) -> Solution<T, N, M>
where
    T: Scalar,
    S: System<T, N, U, M, Z> + ?Sized,
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
pub struct Simulation<
    's,
    S: ?Sized,
    T,
    const N: usize,
    const U: usize,
    const M: usize,
    const Z: usize,
> {
    system: &'s S,
    /// Constraint stabilisation, if any.
    pub baumgarte: Option<Baumgarte<T>>,
    /// Thresholds of the rank-revealing solve.
    pub tolerance: Tolerance<T>,
    sizes: PhantomData<[T; M]>,
}

impl<'s, S, T, const N: usize, const U: usize, const M: usize, const Z: usize>
    Simulation<'s, S, T, N, U, M, Z>
where
    T: Real,
    S: System<T, N, U, M, Z> + ?Sized,
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
        y: &State<T, N, Z>,
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

    /// Rate of the state, `(v, a, dz/dt)`.
    ///
    /// # Errors
    ///
    /// [`SolveError`].
    pub fn rate(&self, t: T, y: &State<T, N, Z>, u: [T; U]) -> Result<State<T, N, Z>, SolveError> {
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
            q: y.v,
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
        y: &State<T, N, Z>,
        h: T,
        mut input: impl FnMut(T, &State<T, N, Z>) -> [T; U],
    ) -> Result<State<T, N, Z>, SolveError> {
        rk4_step(|t, y| self.rate(t, y, input(t, y)), t, y, h)
    }

    /// One semi-implicit Euler step, [`symplectic_euler_step`].
    ///
    /// # Errors
    ///
    /// [`SolveError`].
    pub fn symplectic_euler_step(
        &self,
        t: T,
        y: &State<T, N, Z>,
        h: T,
        mut input: impl FnMut(T, &State<T, N, Z>) -> [T; U],
    ) -> Result<State<T, N, Z>, SolveError> {
        symplectic_euler_step(|t, y| self.rate(t, y, input(t, y)), t, y, h)
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
        (t0, y0): (T, &State<T, N, Z>),
        t1: T,
        mut input: impl FnMut(T, &State<T, N, Z>) -> [T; U],
        sink: impl FnMut(&Segment<T, State<T, N, Z>>) -> ControlFlow<()>,
    ) -> Result<(T, State<T, N, Z>, Statistics), IntegrationError<SolveError>> {
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
        start: (T, &State<T, N, Z>),
        t1: T,
        mut input: impl FnMut(T, &State<T, N, Z>) -> [T; U],
        events: Events<G, A, K>,
        sink: impl FnMut(&Segment<T, State<T, N, Z>>) -> ControlFlow<()>,
    ) -> Result<(T, State<T, N, Z>, Statistics), IntegrationError<SolveError>>
    where
        G: FnMut(T, &State<T, N, Z>) -> [T; K],
        A: FnMut(usize, T, &mut State<T, N, Z>) -> ControlFlow<()>,
    {
        let rate = |t, y: &State<T, N, Z>| self.rate(t, y, input(t, y));
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
        (t0, y0): (T, &State<T, N, Z>),
        (t1, interval): (T, T),
        mut input: impl FnMut(T, &State<T, N, Z>) -> [T; U],
        sink: impl FnMut(T, &State<T, N, Z>),
    ) -> Result<(State<T, N, Z>, Statistics), IntegrationError<SolveError>> {
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
