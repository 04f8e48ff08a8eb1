//! [`Scalar`] and [`Real`] for `f32` and `f64`: through `libm` (and [`single`]), or through the
//! standard library with the feature `std`.

#[cfg(not(feature = "std"))]
use super::single;
use super::{Real, Scalar};
#[cfg(not(feature = "std"))]
use libm as double;

#[cfg(feature = "std")]
extern crate std;

/// `self * a + b`, fused where `$fused` computes it in one instruction.
macro_rules! fused_mul_add {
    ($x:ident, $a:ident, $b:ident, $float:ident, $libm:path) => {{
        #[cfg(all(feature = "std", any(target_feature = "fma", target_arch = "aarch64")))]
        {
            $float::mul_add($x, $a, $b)
        }
        #[cfg(all(not(feature = "std"), target_arch = "aarch64"))]
        {
            $libm($x, $a, $b)
        }
        #[cfg(not(any(all(feature = "std", target_feature = "fma"), target_arch = "aarch64")))]
        {
            $x * $a + $b
        }
    }};
}

/// One elementary function: the standard library's with `std`, else that of `$library`.
macro_rules! elementary {
    ($float:ident, $library:ident: $($name:ident($($arg:ident),*) = $libm:ident;)*) => {$(
        #[inline]
        fn $name(self $(, $arg: Self)*) -> Self {
            #[cfg(feature = "std")]
            {
                $float::$name(self $(, $arg)*)
            }
            #[cfg(not(feature = "std"))]
            {
                $library::$libm(self $(, $arg)*)
            }
        }
    )*};
}

/// Everything that is the same text for both widths.
macro_rules! implement {
    ($float:ident, $library:ident, $sincos:ident, $four:ident, $fma:ident, {$($functions:tt)*}) => {
        impl Scalar for $float {
            #[inline]
            fn from_f64(x: f64) -> Self {
                x as $float
            }

            elementary!($float, $library: $($functions)*);

            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                #[cfg(feature = "std")]
                {
                    $float::sin_cos(self)
                }
                #[cfg(not(feature = "std"))]
                {
                    $library::$sincos(self)
                }
            }

            #[cfg(feature = "simd")]
            #[inline]
            fn sin_cos_2(a: Self, b: Self) -> [(Self, Self); 2] {
                let [a, b, ..] = super::simd_trig::$four([a, b, 0.0, 0.0]);
                [a, b]
            }

            #[cfg(feature = "simd")]
            #[inline]
            fn sin_cos_3(a: Self, b: Self, c: Self) -> [(Self, Self); 3] {
                let [a, b, c, _] = super::simd_trig::$four([a, b, c, 0.0]);
                [a, b, c]
            }

            #[cfg(feature = "simd")]
            #[inline]
            fn sin_cos_4(a: Self, b: Self, c: Self, d: Self) -> [(Self, Self); 4] {
                super::simd_trig::$four([a, b, c, d])
            }

            #[inline]
            fn abs(self) -> Self {
                $float::abs(self)
            }

            #[inline]
            fn sign(self) -> Self {
                if self > 0.0 {
                    1.0
                } else if self < 0.0 {
                    -1.0
                } else {
                    self
                }
            }

            #[inline]
            fn min(self, other: Self) -> Self {
                if self < other || self.is_nan() { self } else { other }
            }

            #[inline]
            fn max(self, other: Self) -> Self {
                if self > other || self.is_nan() { self } else { other }
            }

            #[inline]
            fn select_positive(self, if_positive: Self, otherwise: Self) -> Self {
                if self > 0.0 { if_positive } else { otherwise }
            }

            #[inline]
            fn step(self) -> Self {
                if self > 0.0 {
                    1.0
                } else if self <= 0.0 {
                    0.0
                } else {
                    self
                }
            }

            #[inline]
            fn mul_add(self, a: Self, b: Self) -> Self {
                fused_mul_add!(self, a, b, $float, libm::$fma)
            }
        }

        impl Real for $float {
            #[inline]
            fn epsilon() -> Self {
                $float::EPSILON
            }

            #[inline]
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }

            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }
    };
}

implement!(f32, single, sincosf, sin_cos_4_f32, fmaf, {
    sqrt() = sqrtf;
    sin() = sinf;
    cos() = cosf;
    tan() = tanf;
    asin() = asinf;
    acos() = acosf;
    atan() = atanf;
    atan2(x) = atan2f;
    exp() = expf;
    ln() = logf;
    powf(y) = powf;
    tanh() = tanhf;
});

implement!(f64, double, sincos, sin_cos_4_f64, fma, {
    sqrt() = sqrt;
    sin() = sin;
    cos() = cos;
    tan() = tan;
    asin() = asin;
    acos() = acos;
    atan() = atan;
    atan2(x) = atan2;
    exp() = exp;
    ln() = log;
    powf(y) = pow;
    tanh() = tanh;
});
