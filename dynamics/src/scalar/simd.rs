//! [`Scalar`] for the SIMD lanes of `wide`: every lane is one state.
//!
//! Without `-C target-cpu` only the baseline of the target (SSE2 on x86-64) is
//! used; results differ between instruction sets by round-off where fused
//! multiply-add exists. Accuracy for `f64`, measured against the standard library:
//! `sin_cos`, `exp`, `ln`, `atan`, `atan2`, `asin`, `acos` within 2 units in the last
//! place, `tanh` within 4; `exp` flushes subnormal results to 0. `powf` is the scalar
//! function lane by lane.

use wide::{f32x8, f32x16, f64x4, f64x8};

use super::{Scalar, simd_trig};

/// The function of `wide`.
macro_rules! wide_functions {
    ($lanes:ident: $($name:ident($($arg:ident)?)),*) => {$(
        #[inline]
        fn $name(self $(, $arg: Self)?) -> Self {
            $lanes::$name(self $(, $arg)?)
        }
    )*};
}

/// The scalar function, lane by lane.
macro_rules! lanewise {
    ($lanes:ident, $element:ident: $name:ident($arg:ident)) => {
        #[inline]
        fn $name(self, $arg: Self) -> Self {
            let mut x = self.to_array();
            let $arg = $arg.to_array();
            for i in 0..x.len() {
                x[i] = <$element as Scalar>::$name(x[i], $arg[i]);
            }
            $lanes::from(x)
        }
    };
}

/// [`Scalar`] for one type of lanes.
macro_rules! implement {
    ($lanes:ident, $element:ident, $sin_cos:path) => {
        impl Scalar for $lanes {
            #[inline]
            fn from_f64(x: f64) -> Self {
                $lanes::splat(x as $element)
            }

            #[inline]
            fn sqrt(self) -> Self {
                $lanes::sqrt(self)
            }

            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                $sin_cos(self)
            }

            wide_functions!($lanes: asin(), acos(), atan(), atan2(x), exp(), ln(), tanh());
            lanewise!($lanes, $element: powf(y));

            #[inline]
            fn abs(self) -> Self {
                $lanes::abs(self)
            }

            #[inline]
            fn sign(self) -> Self {
                let zero = Self::zero();
                let negative = self.simd_lt(zero).select(-Self::one(), self);
                self.simd_gt(zero).select(Self::one(), negative)
            }

            #[inline]
            fn min(self, other: Self) -> Self {
                let smaller = self.simd_lt(other).select(self, other);
                self.is_nan().select(self, smaller)
            }

            #[inline]
            fn max(self, other: Self) -> Self {
                let larger = self.simd_gt(other).select(self, other);
                self.is_nan().select(self, larger)
            }

            #[inline]
            fn select_positive(self, if_positive: Self, otherwise: Self) -> Self {
                self.simd_gt(Self::zero()).select(if_positive, otherwise)
            }

            #[inline]
            fn step(self) -> Self {
                let zero = Self::zero();
                let low = self.simd_le(zero).select(zero, self);
                self.simd_gt(zero).select(Self::one(), low)
            }

            #[inline]
            fn mul_add(self, a: Self, b: Self) -> Self {
                $lanes::mul_add(self, a, b)
            }

            #[inline]
            fn mul_sub(self, a: Self, b: Self) -> Self {
                $lanes::mul_sub(self, a, b)
            }

            #[inline]
            fn neg_mul_add(self, a: Self, b: Self) -> Self {
                $lanes::mul_neg_add(self, a, b)
            }
        }
    };
}

/// `(sin x, cos x)` of several angles, a set of lanes at a time.
macro_rules! sin_cos_each {
    ($name:ident, $element:ident, $lanes:ident) => {
        #[inline]
        pub(super) fn $name<const K: usize>(angles: [$element; K]) -> [($element, $element); K] {
            use super::Lanes;
            let mut results = [(0.0, 0.0); K];
            let blocks = results.chunks_mut($lanes::LANES);
            for (block, angles) in blocks.zip(angles.chunks($lanes::LANES)) {
                let mut padded = [0.0; $lanes::LANES];
                for (lane, &angle) in padded.iter_mut().zip(angles) {
                    *lane = angle;
                }
                let (sines, cosines) = $lanes::from(padded).sin_cos();
                let values = sines.to_array().into_iter().zip(cosines.to_array());
                for (result, value) in block.iter_mut().zip(values) {
                    *result = value;
                }
            }
            results
        }
    };
}

sin_cos_each!(sin_cos_each_f64, f64, f64x8);
sin_cos_each!(sin_cos_each_f32, f32, f32x8);

implement!(f64x4, f64, simd_trig::sin_cos_f64x4);
implement!(f64x8, f64, simd_trig::sin_cos_f64x8);
implement!(f32x8, f32, simd_trig::sin_cos_f32x8);
implement!(f32x16, f32, simd_trig::sin_cos_f32x16);
