//! Choice of the step length.

use super::StateVector;
use crate::Real;

/// Proportional–integral controller of the step (Hairer & Wanner, *Solving Ordinary
/// Differential Equations II*, section IV.2): `h⁺ = h · 0.9 e^(−0.17) e₋₁^0.04`, where
/// `e` is the error in units of the tolerance, limited to 0.2 … 10 times `h`.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepControl<T> {
    previous_error: T,
    rejected: bool,
}

/// Exponent of the integral part.
const BETA: f64 = 0.04;
/// Exponent of the proportional part.
const ALPHA: f64 = 0.2 - 0.75 * BETA;

impl<T: Real> StepControl<T> {
    pub(super) fn new() -> Self {
        Self {
            previous_error: T::from_f64(1e-4),
            rejected: false,
        }
    }

    /// Factor of the next step after an accepted one with error `e ≤ 1`. Never above 1
    /// right after a rejection.
    pub(super) fn accept(&mut self, e: T) -> T {
        let e = e.max(T::from_f64(1e-10));
        let raw = T::from_f64(0.9)
            * e.powf(T::from_f64(-ALPHA))
            * self.previous_error.powf(T::from_f64(BETA));
        let limit = if self.rejected { 1.0 } else { 10.0 };
        self.previous_error = e.max(T::from_f64(1e-4));
        self.rejected = false;
        raw.max(T::from_f64(0.2)).min(T::from_f64(limit))
    }

    /// Factor after a rejected step with error `e > 1` (0.2 where it is not finite).
    pub(super) fn reject(&mut self, e: T) -> T {
        self.rejected = true;
        let least = T::from_f64(0.2);
        if e.is_finite() {
            let raw = T::from_f64(0.9) * e.powf(T::from_f64(-ALPHA));
            raw.max(least)
        } else {
            least
        }
    }
}

/// Root mean square of `error_k / (absolute + relative · max(|y_k|, |y⁺_k|))`.
pub(super) fn error_norm<T: Real, Y: StateVector<T>>(
    error: &Y,
    y: &Y,
    next: &Y,
    absolute: T,
    relative: T,
) -> T {
    if Y::LEN == 0 {
        return T::zero();
    }
    let scale = y.zip_map(next, |a, b| {
        relative.mul_add(a.abs().max(b.abs()), absolute)
    });
    let sum = error.zip_fold(&scale, T::zero(), |sum, e, s| {
        let ratio = e / s;
        sum + ratio * ratio
    });
    (sum / T::from_f64(Y::LEN as f64)).sqrt()
}

/// A first step (the same book, part I, section II.4): the length over which the state
/// changes by a hundredth of itself, then corrected by the second derivative. `probe`
/// is the rate after an Euler step of the given length.
pub(super) fn first_step<T: Real, Y: StateVector<T>, E>(
    y: &Y,
    rate: &Y,
    (absolute, relative): (T, T),
    longest: T,
    probe: impl FnOnce(T) -> Result<Y, E>,
) -> Result<T, E> {
    let norm = |x: &Y| error_norm(x, y, y, absolute, relative);
    let (size, speed) = (norm(y), norm(rate));
    let tiny = T::from_f64(1e-5);
    let euler = if size < tiny || speed < tiny {
        T::from_f64(1e-6)
    } else {
        T::from_f64(0.01) * size / speed
    };
    let euler = euler.min(longest);
    let probed = probe(euler)?;
    let bend = norm(&probed.add_scaled(-T::one(), rate)) / euler;
    let largest = speed.max(bend);
    let corrected = if largest > T::from_f64(1e-15) {
        (T::from_f64(0.01) / largest).powf(T::from_f64(0.2))
    } else {
        (euler * T::from_f64(1e-3)).max(T::from_f64(1e-6))
    };
    let step = corrected.min(T::from_f64(100.0) * euler).min(longest);
    Ok(if step.is_finite() && step > T::zero() {
        step
    } else {
        euler
    })
}
