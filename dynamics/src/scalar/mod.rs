//! The number type of generated code: [`Scalar`], and [`Real`] where a decision is needed.
//!
//! Generated functions are straight lines of `let` bindings over `T: Scalar`. The
//! same text then runs on `f32`, `f64`, dual numbers ([`crate::Dual`], exact
//! derivatives) and, with the feature `simd`, on SIMD lanes (many states at once).
//! Nothing in [`Scalar`] compares two numbers and branches: a choice is made by a
//! *select* ([`Scalar::select_positive`], [`Scalar::step`]), lane by lane.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

mod float;
#[cfg(feature = "simd")]
mod lanes;
#[cfg(feature = "simd")]
mod simd;
#[cfg(feature = "simd")]
mod simd_trig;
#[cfg(any(not(feature = "std"), test))]
#[cfg_attr(
    feature = "std",
    allow(dead_code, unused_imports, reason = "tested whatever the features are")
)]
mod single;

#[cfg(feature = "simd")]
pub use lanes::{Lanes, WideF32, WideF64};

/// A number that generated code can compute with.
///
/// Angles are in radians. Functions outside their domain return NaN, as the
/// standard library does; none panics. `min`, `max`, `sign` and `step` hand a NaN on.
///
/// ```
/// use dynamics::Scalar;
///
/// fn torque<T: Scalar>(q: T, v: T) -> T {
///     let (s, _c) = q.sin_cos();
///     T::from_f64(-9.81) * s - T::from_f64(0.1) * v
/// }
/// assert_eq!(torque(0.0_f64, 1.0), -0.1);
/// assert_eq!(torque(0.0_f32, 1.0), -0.1);
/// ```
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
{
    /// The constant `x`, rounded to this type and the same in every lane.
    fn from_f64(x: f64) -> Self;

    /// 0.
    #[inline]
    fn zero() -> Self {
        Self::from_f64(0.0)
    }

    /// 1.
    #[inline]
    fn one() -> Self {
        Self::from_f64(1.0)
    }

    /// Square root.
    fn sqrt(self) -> Self;
    /// `(sin x, cos x)`.
    fn sin_cos(self) -> (Self, Self);

    /// Sine.
    #[inline]
    fn sin(self) -> Self {
        self.sin_cos().0
    }

    /// Cosine.
    #[inline]
    fn cos(self) -> Self {
        self.sin_cos().1
    }

    /// Tangent.
    #[inline]
    fn tan(self) -> Self {
        let (s, c) = self.sin_cos();
        s / c
    }

    /// Arc sine, in [−π/2, π/2].
    fn asin(self) -> Self;
    /// Arc cosine, in [0, π].
    fn acos(self) -> Self;
    /// Arc tangent, in (−π/2, π/2).
    fn atan(self) -> Self;
    /// Angle of the point (`x`, `self`), in [−π, π].
    fn atan2(self, x: Self) -> Self;
    /// Exponential function.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// `self` to the power `y`.
    fn powf(self, y: Self) -> Self;

    /// `self` to an integer power, by repeated squaring.
    #[inline]
    fn powi(self, n: i32) -> Self {
        power_by_squaring(self, n)
    }

    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Absolute value. Its derivative at 0 is taken as 0.
    fn abs(self) -> Self;
    /// −1, 0 or 1 (0 at 0, NaN at NaN). Its derivative is 0.
    fn sign(self) -> Self;
    /// The smaller of two; NaN if either is.
    fn min(self, other: Self) -> Self;
    /// The larger of two; NaN if either is.
    fn max(self, other: Self) -> Self;

    /// `if_positive` where `self > 0`, else `otherwise` (also where `self` is NaN).
    fn select_positive(self, if_positive: Self, otherwise: Self) -> Self;

    /// Heaviside step: 1 where `self > 0`, 0 where `self <= 0`, NaN at NaN.
    fn step(self) -> Self;

    /// `self * a + b`, rounded once where that is one instruction of the target
    /// (feature `std` with `target_feature = "fma"`, or AArch64), else rounded twice.
    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }

    /// `self * a - b`, rounded as [`mul_add`](Self::mul_add).
    #[inline]
    fn mul_sub(self, a: Self, b: Self) -> Self {
        self.mul_add(a, -b)
    }

    /// `b - self * a`, rounded as [`mul_add`](Self::mul_add).
    #[inline]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        (-self).mul_add(a, b)
    }

    /// `(sin x, cos x)` of two angles; see [`sin_cos_4`](Self::sin_cos_4).
    #[inline]
    fn sin_cos_2(a: Self, b: Self) -> [(Self, Self); 2] {
        [a.sin_cos(), b.sin_cos()]
    }

    /// `(sin x, cos x)` of three angles; see [`sin_cos_4`](Self::sin_cos_4).
    #[inline]
    fn sin_cos_3(a: Self, b: Self, c: Self) -> [(Self, Self); 3] {
        [a.sin_cos(), b.sin_cos(), c.sin_cos()]
    }

    /// `(sin x, cos x)` of four angles. With the feature `simd`, `f32` and `f64` compute them
    /// side by side, to the accuracy of lanes (1 unit in the last place on ±10 rad).
    #[inline]
    fn sin_cos_4(a: Self, b: Self, c: Self, d: Self) -> [(Self, Self); 4] {
        [a.sin_cos(), b.sin_cos(), c.sin_cos(), d.sin_cos()]
    }

    /// `1 / self`.
    #[inline]
    fn recip(self) -> Self {
        Self::one() / self
    }
}

/// A [`Scalar`] that is one real number, so that algorithms may compare and branch:
/// `f32` and `f64`.
pub trait Real: Scalar + PartialOrd {
    /// Distance from 1 to the next larger number: 2⁻²³ or 2⁻⁵².
    fn epsilon() -> Self;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// The value as `f64`, exact.
    fn to_f64(self) -> f64;
}

/// xⁿ by repeated squaring; x⁰ = 1.
#[inline]
fn power_by_squaring<T: Scalar>(x: T, n: i32) -> T {
    let mut exponent = n.unsigned_abs();
    let mut square = x;
    let mut power = T::one();
    while exponent > 0 {
        if exponent & 1 == 1 {
            power *= square;
        }
        exponent >>= 1;
        if exponent > 0 {
            square *= square;
        }
    }
    if n < 0 { power.recip() } else { power }
}

#[cfg(test)]
mod tests;
