//! What [`Scalar`]s of several lanes are made of.

use wide::{f32x8, f32x16, f64x4, f64x8};

use super::{Real, Scalar};

/// A [`Scalar`] of several lanes, each of which is one state.
pub trait Lanes: Scalar {
    /// The number in a lane.
    type Element: Real;

    /// How many there are.
    const LANES: usize;

    /// Takes the lanes from the front of a slice; as [`load_padded`](Self::load_padded) if it
    /// is shorter.
    fn load(from: &[Self::Element]) -> Self;

    /// Takes what a shorter slice has; its last number (0 if there is none) fills the other
    /// lanes.
    fn load_padded(from: &[Self::Element]) -> Self;

    /// Writes the lanes to the front of a slice; as [`store_part`](Self::store_part) if it is
    /// shorter.
    fn store(self, to: &mut [Self::Element]);

    /// Writes the first lanes to a shorter slice.
    fn store_part(self, to: &mut [Self::Element]);
}

macro_rules! implement {
    ($lanes:ident, $element:ident, $count:literal) => {
        impl Lanes for $lanes {
            type Element = $element;

            const LANES: usize = $count;

            #[inline]
            fn load(from: &[$element]) -> Self {
                match from.first_chunk::<$count>() {
                    Some(array) => $lanes::from(*array),
                    None => Self::load_padded(from),
                }
            }

            fn load_padded(from: &[$element]) -> Self {
                let last = from.last().copied().unwrap_or(0.0);
                let mut array = [last; $count];
                for (lane, &value) in array.iter_mut().zip(from) {
                    *lane = value;
                }
                $lanes::from(array)
            }

            #[inline]
            fn store(self, to: &mut [$element]) {
                match to.first_chunk_mut::<$count>() {
                    Some(array) => *array = self.to_array(),
                    None => self.store_part(to),
                }
            }

            fn store_part(self, to: &mut [$element]) {
                for (place, lane) in to.iter_mut().zip(self.to_array()) {
                    *place = lane;
                }
            }
        }
    };
}

implement!(f64x4, f64, 4);
implement!(f64x8, f64, 8);
implement!(f32x8, f32, 8);
implement!(f32x16, f32, 16);

/// The `f64` lanes that fit this compilation's target: eight with AVX-512, else four.
#[cfg(target_feature = "avx512f")]
pub type WideF64 = f64x8;
/// The `f64` lanes that fit this compilation's target: eight with AVX-512, else four.
#[cfg(not(target_feature = "avx512f"))]
pub type WideF64 = f64x4;

/// The `f32` lanes that fit this compilation's target: sixteen with AVX-512, else eight.
#[cfg(target_feature = "avx512f")]
pub type WideF32 = f32x16;
/// The `f32` lanes that fit this compilation's target: sixteen with AVX-512, else eight.
#[cfg(not(target_feature = "avx512f"))]
pub type WideF32 = f32x8;
