//! Dormand & Prince's embedded Runge–Kutta pair of orders 5 and 4.

use core::ops::ControlFlow;

use super::control::{StepControl, error_norm, first_step};
use super::{IntegrationError, Segment, StateVector};
use crate::Real;

/// Nodes of stages 2 … 6 (Dormand & Prince 1980); stage 7 is the end of the step.
const NODES: [f64; 5] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];

/// Weights of the earlier stages in stages 2 … 6.
const STAGES: [&[f64]; 5] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[
        19_372.0 / 6_561.0,
        -25_360.0 / 2_187.0,
        64_448.0 / 6_561.0,
        -212.0 / 729.0,
    ],
    &[
        9_017.0 / 3_168.0,
        -355.0 / 33.0,
        46_732.0 / 5_247.0,
        49.0 / 176.0,
        -5_103.0 / 18_656.0,
    ],
];

/// Weights of the fifth-order result.
const RESULT: [f64; 6] = [
    35.0 / 384.0,
    0.0,
    500.0 / 1_113.0,
    125.0 / 192.0,
    -2_187.0 / 6_784.0,
    11.0 / 84.0,
];

/// Fifth-order minus fourth-order weights.
const ERROR: [f64; 7] = [
    71.0 / 57_600.0,
    0.0,
    -71.0 / 16_695.0,
    71.0 / 1_920.0,
    -17_253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// The rates of the seven stages.
pub(super) type Stages<Y> = [Y; 7];

/// Adaptive integrator: Dormand–Prince 5(4), proportional–integral step control, dense
/// output of fourth order, first-same-as-last.
///
/// A step is accepted when the root mean square over the components of
/// `error_k / (absolute + relative |y_k|)` is at most 1. The error of the whole
/// integration is usually some ten times larger than the tolerance; for long, lightly
/// damped motion more. Jumps of the right-hand side cost many rejected steps: integrate
/// up to the jump and start anew behind it.
///
/// ```
/// use core::convert::Infallible;
/// use dynamics::integrate::DormandPrince;
///
/// let swing = |_t: f64, y: &[f64; 2]| Ok::<_, Infallible>([y[1], -y[0]]);
/// let solver = DormandPrince { relative: 1e-10, absolute: 1e-10, ..Default::default() };
/// let mut largest: f64 = 0.0;
/// solver
///     .sample(swing, 0.0, &[1.0, 0.0], 10.0, 0.1, |t, y| largest = largest.max((y[0] - t.cos()).abs()))
///     .unwrap();
/// assert!(largest < 1e-8);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DormandPrince<T> {
    /// Tolerated error relative to each component, above 0 or, with `absolute` above 0, 0.
    pub relative: T,
    /// Tolerated absolute error of each component, in its unit; as `relative`.
    pub absolute: T,
    /// Length of the first step, s; chosen from the right-hand side if `None`.
    pub first_step: Option<T>,
    /// Longest step, s; the whole interval if `None`.
    pub max_step: Option<T>,
    /// Limit of accepted and rejected steps together.
    pub max_steps: usize,
}

impl<T: Real> Default for DormandPrince<T> {
    /// Tolerances √ε (1.5e-8 for `f64`, 3.5e-4 for `f32`), a million steps.
    fn default() -> Self {
        let tolerance = T::epsilon().sqrt();
        Self {
            relative: tolerance,
            absolute: tolerance,
            first_step: None,
            max_step: None,
            max_steps: 1_000_000,
        }
    }
}

/// What an integration cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Statistics {
    /// Accepted steps.
    pub accepted: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Evaluations of the right-hand side.
    pub evaluations: usize,
}

impl<T: Real> DormandPrince<T> {
    /// Integrates `dy/dt = f(t, y)` from `(t0, y0)` to `t1` (forwards or backwards).
    ///
    /// `sink` is given every accepted step with its dense output and may stop the
    /// integration by `ControlFlow::Break`. Returns the time and the state reached.
    ///
    /// # Errors
    ///
    /// [`IntegrationError`]: the error of `f`; a tolerance, step or time out of range;
    /// a state that is not finite; a step that underflows; too many steps.
    pub fn integrate<Y: StateVector<T>, E>(
        &self,
        mut f: impl FnMut(T, &Y) -> Result<Y, E>,
        t0: T,
        y0: &Y,
        t1: T,
        mut sink: impl FnMut(&Segment<T, Y>) -> ControlFlow<()>,
    ) -> Result<(T, Y, Statistics), IntegrationError<E>> {
        self.check(t0, t1)?;
        let mut count = Statistics::default();
        let mut rate = |t: T, y: &Y| {
            count.evaluations += 1;
            f(t, y).map_err(|source| IntegrationError::Rate {
                t: t.to_f64(),
                source,
            })
        };
        let (mut t, mut y) = (t0, *y0);
        let mut first = rate(t, &y)?;
        if !finite(&y) || !finite(&first) {
            return Err(IntegrationError::NotFinite { t: t.to_f64() });
        }
        let direction = if t1 < t0 { -T::one() } else { T::one() };
        let longest = self
            .max_step
            .map_or((t1 - t0).abs(), |h| h.min((t1 - t0).abs()));
        let mut h = match self.first_step {
            Some(h) => h.min(longest),
            None if longest > T::zero() => {
                first_step(&y, &first, (self.absolute, self.relative), longest, |h| {
                    let h = h * direction;
                    rate(t + h, &y.add_scaled(h, &first))
                })?
            }
            None => longest,
        };
        let mut control = StepControl::new();
        let (mut accepted, mut rejected) = (0, 0);
        let mut trial_was_finite = true;
        while (t1 - t) * direction > T::zero() {
            if accepted + rejected >= self.max_steps {
                return Err(IntegrationError::TooManySteps {
                    t: t.to_f64(),
                    limit: self.max_steps,
                });
            }
            let remaining = (t1 - t).abs();
            // The last step ends on t1 exactly; a sliver of a step is not left over.
            let last = h >= remaining * T::from_f64(1.0 - 1e-6);
            let step = if last { t1 - t } else { h * direction };
            let next_t = if last { t1 } else { t + step };
            if next_t == t || step.abs() < T::epsilon() * t.abs() {
                return Err(underflow(t, step, trial_was_finite));
            }
            let (stages, next, error) = try_step(&mut rate, t, next_t, &y, &first, step)?;
            let e = error_norm(&error, &y, &next, self.absolute, self.relative);
            trial_was_finite = finite(&next) && finite(&stages[6]);
            if e <= T::one() && trial_was_finite {
                accepted += 1;
                let segment = Segment::new((t, &y), (next_t, &next), &stages);
                (t, y, first) = (next_t, next, stages[6]);
                h = (step.abs() * control.accept(e)).min(longest);
                if sink(&segment).is_break() {
                    break;
                }
            } else {
                rejected += 1;
                h = step.abs() * control.reject(e);
            }
        }
        (count.accepted, count.rejected) = (accepted, rejected);
        Ok((t, y, count))
    }

    /// Integrates and hands `sink` the state at `t0`, `t0 + interval`, `t0 + 2 interval`,
    /// … up to `t1`. Returns the state at `t1`.
    ///
    /// # Errors
    ///
    /// As [`DormandPrince::integrate`]; also an `interval` that is not above 0.
    pub fn sample<Y: StateVector<T>, E>(
        &self,
        f: impl FnMut(T, &Y) -> Result<Y, E>,
        t0: T,
        y0: &Y,
        t1: T,
        interval: T,
        mut sink: impl FnMut(T, &Y),
    ) -> Result<(Y, Statistics), IntegrationError<E>> {
        positive("interval", interval)?;
        let signed = if t1 < t0 { -interval } else { interval };
        // A sample that round-off puts a hair behind t1 still counts.
        let slack = interval * T::epsilon().sqrt();
        let sample_time = |k: u64| T::from_f64(k as f64).mul_add(signed, t0);
        let mut k: u64 = 1;
        sink(t0, y0);
        let (_, y, statistics) = self.integrate(f, t0, y0, t1, |segment| {
            let at_end = segment.end_time() == t1;
            loop {
                let t = sample_time(k);
                let beyond = (t - segment.end_time()) * signed.sign();
                if beyond > if at_end { slack } else { T::zero() } {
                    return ControlFlow::Continue(());
                }
                if beyond >= T::zero() {
                    sink(t, segment.end());
                } else {
                    sink(t, &segment.at(t));
                }
                k += 1;
            }
        })?;
        Ok((y, statistics))
    }

    /// Every number in its range.
    fn check<E>(&self, t0: T, t1: T) -> Result<(), IntegrationError<E>> {
        for (name, t) in [("start time", t0), ("end time", t1)] {
            if !t.is_finite() {
                return Err(argument(name, "a finite number of seconds", t));
            }
        }
        for (name, x) in [
            ("relative tolerance", self.relative),
            ("absolute tolerance", self.absolute),
        ] {
            if !x.is_finite() || x < T::zero() {
                return Err(argument(name, "a finite number, at least 0", x));
            }
        }
        if self.relative + self.absolute <= T::zero() {
            return Err(argument(
                "relative tolerance",
                "above 0 where the absolute one is 0",
                self.relative,
            ));
        }
        if let Some(h) = self.first_step {
            positive("first step", h)?;
        }
        self.max_step
            .map_or(Ok(()), |h| positive("longest step", h))
    }
}

/// One trial step: its stages, its end, its error estimate.
pub(super) fn try_step<T: Real, Y: StateVector<T>, E>(
    rate: &mut impl FnMut(T, &Y) -> Result<Y, E>,
    t: T,
    end: T,
    y: &Y,
    first: &Y,
    h: T,
) -> Result<(Stages<Y>, Y, Y), E> {
    let mut k: Stages<Y> = [*first; 7];
    for i in 0..NODES.len() {
        let at = T::from_f64(NODES[i]).mul_add(h, t);
        k[i + 1] = rate(at, &combine(y, h, STAGES[i], &k))?;
    }
    let next = combine(y, h, &RESULT, &k);
    k[6] = rate(end, &next)?;
    let error = combine(&y.scaled(T::zero()), h, &ERROR, &k);
    Ok((k, next, error))
}

/// `y + h Σ weights_i k_i`.
#[inline]
fn combine<T: Real, Y: StateVector<T>>(y: &Y, h: T, weights: &[f64], k: &Stages<Y>) -> Y {
    weights
        .iter()
        .zip(k)
        .filter(|(w, _)| **w != 0.0)
        .fold(*y, |sum, (w, k)| sum.add_scaled(h * T::from_f64(*w), k))
}

fn finite<T: Real, Y: StateVector<T>>(y: &Y) -> bool {
    y.zip_fold(y, true, |all, x, _| all && x.is_finite())
}

fn underflow<T: Real, E>(t: T, step: T, trial_was_finite: bool) -> IntegrationError<E> {
    if trial_was_finite {
        IntegrationError::StepUnderflow {
            t: t.to_f64(),
            step: step.abs().to_f64(),
        }
    } else {
        IntegrationError::NotFinite { t: t.to_f64() }
    }
}

fn positive<T: Real, E>(name: &'static str, x: T) -> Result<(), IntegrationError<E>> {
    if x.is_finite() && x > T::zero() {
        Ok(())
    } else {
        Err(argument(name, "a finite number above 0", x))
    }
}

fn argument<T: Real, E>(
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
