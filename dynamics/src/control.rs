//! Feedback in the loop: a controller with a rate, a delay and limits of its own.

use core::ops::ControlFlow;

use crate::constrained::SolveError;
use crate::integrate::{DormandPrince, IntegrationError, Segment, State, Statistics};
use crate::{Real, Simulation, System};

/// A sampled controller around a law `u = law(t, y)`: it samples every `interval` seconds, its
/// command arrives `D` samples later, within limits, and is held until the next one arrives.
///
/// ```
/// use dynamics::Control;
///
/// // 1 kHz, at most 2 N·m, one sample of delay; nothing is commanded before the first sample.
/// let mut control = Control::new(1e-3, |_t: f64, y: &[f64; 2]| [-40.0 * y[0] - 3.0 * y[1]])
///     .with_delay([[0.0]])
///     .with_limits([-2.0], [2.0]);
/// assert_eq!(control.sample(0.0, &[0.01, 0.0]), [0.0]);
/// assert_eq!(control.sample(1e-3, &[0.02, 0.0]), [-0.4]);
/// assert_eq!(control.sample(2e-3, &[0.02, 0.0]), [-0.8]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Control<T, L, const U: usize, const D: usize> {
    interval: T,
    law: L,
    lower: Option<[T; U]>,
    upper: Option<[T; U]>,
    /// Commands on their way, the next to arrive first.
    pending: [[T; U]; D],
}

impl<T: Real, L, const U: usize> Control<T, L, U, 0> {
    /// A controller that samples every `interval` seconds, without delay or limits. `law` is
    /// a function of the time and of what is sampled.
    pub fn new(interval: T, law: L) -> Self {
        Self {
            interval,
            law,
            lower: None,
            upper: None,
            pending: [],
        }
    }

    /// With `D` samples between a sample and the arrival of its command. What arrives before
    /// the first of them is `first`, in the order of arrival.
    #[must_use]
    pub fn with_delay<const D: usize>(self, first: [[T; U]; D]) -> Control<T, L, U, D> {
        Control {
            interval: self.interval,
            law: self.law,
            lower: self.lower,
            upper: self.upper,
            pending: first,
        }
    }
}

impl<T: Real, L, const U: usize, const D: usize> Control<T, L, U, D> {
    /// With commands between `lower` and `upper`.
    #[must_use]
    pub fn with_limits(mut self, lower: [T; U], upper: [T; U]) -> Self {
        (self.lower, self.upper) = (Some(lower), Some(upper));
        self
    }

    /// Samples `y` at time `t`: the command that acts from now to the next sample.
    pub fn sample<Y>(&mut self, t: T, y: &Y) -> [T; U]
    where
        L: FnMut(T, &Y) -> [T; U],
    {
        let mut command = (self.law)(t, y);
        if let Some(lower) = &self.lower {
            command = core::array::from_fn(|k| command[k].max(lower[k]));
        }
        if let Some(upper) = &self.upper {
            command = core::array::from_fn(|k| command[k].min(upper[k]));
        }
        if D == 0 {
            return command;
        }
        let arrives = self.pending[0];
        self.pending.rotate_left(1);
        self.pending[D - 1] = command;
        arrives
    }
}

impl<S, T, const N: usize, const U: usize, const M: usize, const Z: usize, const Q: usize>
    Simulation<'_, S, T, N, U, M, Z, Q>
where
    T: Real,
    S: System<T, N, U, M, Z, Q> + ?Sized,
{
    /// Adaptive integration under sampled feedback, [`Control`]. The first sample is taken at
    /// `t0`. `sink` is given every accepted step with the command that acted in it.
    ///
    /// # Errors
    ///
    /// As [`Simulation::integrate`]; also an interval that is not above 0, and a `t1` before `t0`.
    pub fn integrate_controlled<L, const D: usize>(
        &self,
        solver: &DormandPrince<T>,
        (t0, y0): (T, &State<T, N, Z, Q>),
        t1: T,
        control: &mut Control<T, L, U, D>,
        mut sink: impl FnMut(&Segment<T, State<T, N, Z, Q>>, &[T; U]) -> ControlFlow<()>,
    ) -> Result<(T, State<T, N, Z, Q>, Statistics), IntegrationError<SolveError>>
    where
        L: FnMut(T, &State<T, N, Z, Q>) -> [T; U],
    {
        let interval = control.interval;
        if !(interval > T::zero() && interval.is_finite()) {
            return Err(out_of_range(
                "interval",
                "a finite number above 0",
                interval,
            ));
        }
        if t1 < t0 {
            return Err(out_of_range("end time", "at or behind the start time", t1));
        }
        let (mut t, mut y) = (t0, *y0);
        let mut total = Statistics::default();
        let mut ticks: u64 = 0;
        loop {
            let command = control.sample(t, &y);
            ticks += 1;
            let next = T::from_f64(ticks as f64).mul_add(interval, t0);
            // A sliver of an interval in front of the end is not left over.
            let last = next >= t1 - interval * T::epsilon().sqrt();
            let mut stopped = false;
            let (end, state, cost) = self.integrate(
                solver,
                (t, &y),
                if last { t1 } else { next },
                |_, _| command,
                |segment| {
                    let flow = sink(segment, &command);
                    stopped = flow.is_break();
                    flow
                },
            )?;
            (t, y) = (end, state);
            total.accepted += cost.accepted;
            total.rejected += cost.rejected;
            total.evaluations += cost.evaluations;
            if last || stopped {
                return Ok((t, y, total));
            }
        }
    }
}

fn out_of_range<T: Real, E>(
    name: &'static str,
    expected: &'static str,
    value: T,
) -> IntegrationError<E> {
    IntegrationError::Argument {
        name,
        expected,
        value: value.to_f64(),
    }
}
