//! Sine and cosine of all lanes at once, to about 1 unit in the last place.
//!
//! Method: `n = round(2x/π)` by adding and subtracting 1.5·2^p (the low bits of the
//! sum are `n mod 4`); Cody–Waite reduction `r = x − n π/2` with π/2 in three (f32:
//! four) parts, all but the last short enough that `n` times them is exact; minimax
//! polynomials on [−π/4, π/4]; then swap and signs by quadrant with bit masks. Within
//! 1 unit on ±10 rad and 2 on ±10⁶ (f32: 1.5 and 2 on ±4000), measured. Arguments beyond the
//! limit of the exact products, infinities and NaN take the scalar function lane by
//! lane. Constants: π/2 split and polynomials as published with Sun's fdlibm
//! (`e_rem_pio2.c`, `k_sin.c`, `k_cos.c`) for f64 and Moshier's Cephes (`sinf.c`) for f32.

use wide::{f32x8, f32x16, f64x4, f64x8};

use super::Scalar;

/// Beyond this the multiples of π/2 exceed 2²⁰ and their products round.
const LIMIT_F64: f64 = 1.0e6;
/// Beyond this the multiples of π/2 exceed 2¹² and their products round.
const LIMIT_F32: f32 = 4000.0;

/// The scalar function in every lane, for the arguments the fast path excludes: apart, so
/// that the code of those who call many sines stays small. It takes arrays because vectors
/// are passed through memory, and what has an address is kept there by the fast path too.
#[cold]
#[inline(never)]
fn far<T: Scalar, const K: usize>(x: [T; K]) -> ([T; K], [T; K]) {
    let (mut sines, mut cosines) = (x, x);
    for i in 0..K {
        (sines[i], cosines[i]) = x[i].sin_cos();
    }
    (sines, cosines)
}

/// Swaps and signs `(s, c)` by the quadrant in the two low bits of `shifted`.
macro_rules! by_quadrant {
    ($shifted:ident, $s:ident, $c:ident, $lanes:ident, $element:ident) => {{
        // Bit k of the mantissa, or'ed into 1.0, makes a number above 1.
        let one = $lanes::splat(1.0);
        let bit = |k| {
            let bit = $lanes::splat($element::from_bits(k));
            ((($shifted & bit) | one).simd_gt(one), $lanes::splat(-0.0))
        };
        let (odd, sign_bit) = bit(1);
        let (upper, _) = bit(2);
        let sine = odd.select($c, $s) ^ (upper & sign_bit);
        let cosine = odd.select($s, $c) ^ ((odd ^ upper) & sign_bit);
        (sine, cosine)
    }};
}

/// `c0 + x (c1 + x (c2 + …))`.
macro_rules! polynomial {
    ($lanes:ident, $x:expr; $last:expr) => { $lanes::splat($last) };
    ($lanes:ident, $x:expr; $first:expr, $($rest:expr),+) => {
        polynomial!($lanes, $x; $($rest),+).mul_add($x, $lanes::splat($first))
    };
}

macro_rules! sin_cos_f64 {
    ($name:ident, $near:ident, $lanes:ident) => {
        /// `(sin x, cos x)` in every lane, x in radians.
        #[inline]
        pub(super) fn $name(x: $lanes) -> ($lanes, $lanes) {
            if !x.abs().simd_le($lanes::splat(LIMIT_F64)).all() {
                let (sines, cosines) = far(x.to_array());
                return ($lanes::from(sines), $lanes::from(cosines));
            }
            $near(x)
        }

        /// The same for arguments within the limit.
        #[inline]
        fn $near(x: $lanes) -> ($lanes, $lanes) {
            let magic = $lanes::splat(6_755_399_441_055_744.0); // 1.5 · 2^52
            let shifted = x.mul_add($lanes::splat(core::f64::consts::FRAC_2_PI), magic);
            let n = shifted - magic;
            let r = n.mul_neg_add($lanes::splat(f64::from_bits(0x3FF9_21FB_5440_0000)), x);
            let r = n.mul_neg_add($lanes::splat(f64::from_bits(0x3DD0_B461_1A60_0000)), r);
            let r = n.mul_neg_add($lanes::splat(f64::from_bits(0x3BA3_198A_2E03_7073)), r);
            let z = r * r;
            let sine = polynomial!($lanes, z;
                -1.666_666_666_666_663_2e-1, 8.333_333_333_322_49e-3,
                -1.984_126_982_985_795e-4, 2.755_731_370_707_006_8e-6,
                -2.505_076_025_340_686_3e-8, 1.589_690_995_211_55e-10);
            let cosine = polynomial!($lanes, z;
                4.166_666_666_666_66e-2, -1.388_888_888_887_411e-3,
                2.480_158_728_947_673e-5, -2.755_731_435_139_066_3e-7,
                2.087_572_321_298_175e-9, -1.135_964_755_778_819_5e-11);
            let s = (z * r).mul_add(sine, r);
            // 1 − z/2 loses up to half a unit; what it lost is added back.
            let half = $lanes::splat(0.5);
            let w = z.mul_neg_add(half, $lanes::splat(1.0));
            let lost = z.mul_neg_add(half, $lanes::splat(1.0) - w);
            let c = w + (z * z).mul_add(cosine, lost);
            by_quadrant!(shifted, s, c, $lanes, f64)
        }
    };
}

macro_rules! sin_cos_f32 {
    ($name:ident, $near:ident, $lanes:ident) => {
        /// `(sin x, cos x)` in every lane, x in radians.
        #[inline]
        pub(super) fn $name(x: $lanes) -> ($lanes, $lanes) {
            if !x.abs().simd_le($lanes::splat(LIMIT_F32)).all() {
                let (sines, cosines) = far(x.to_array());
                return ($lanes::from(sines), $lanes::from(cosines));
            }
            $near(x)
        }

        /// The same for arguments within the limit.
        #[inline]
        fn $near(x: $lanes) -> ($lanes, $lanes) {
            let magic = $lanes::splat(12_582_912.0); // 1.5 · 2^23
            let shifted = x.mul_add($lanes::splat(core::f32::consts::FRAC_2_PI), magic);
            let n = shifted - magic;
            // π/2 in parts of at most 11 bits, so that n below 2^12 keeps products exact.
            let r = n.mul_neg_add($lanes::splat(f32::from_bits(0x3FC9_0000)), x);
            let r = n.mul_neg_add($lanes::splat(f32::from_bits(0x39FD_A000)), r);
            let r = n.mul_neg_add($lanes::splat(f32::from_bits(0x33A2_2000)), r);
            let r = n.mul_neg_add($lanes::splat(f32::from_bits(0x2C34_611A)), r);
            let z = r * r;
            let sine = polynomial!($lanes, z;
                -1.666_665_5e-1, 8.332_161e-3, -1.951_529_6e-4);
            let cosine = polynomial!($lanes, z;
                4.166_664_6e-2, -1.388_731_6e-3, 2.443_315_7e-5);
            let s = (z * r).mul_add(sine, r);
            let half = $lanes::splat(0.5);
            let w = z.mul_neg_add(half, $lanes::splat(1.0));
            let lost = z.mul_neg_add(half, $lanes::splat(1.0) - w);
            let c = w + (z * z).mul_add(cosine, lost);
            by_quadrant!(shifted, s, c, $lanes, f32)
        }
    };
}

sin_cos_f64!(sin_cos_f64x4, near_f64x4, f64x4);
sin_cos_f64!(sin_cos_f64x8, near_f64x8, f64x8);
sin_cos_f32!(sin_cos_f32x8, near_f32x8, f32x8);
sin_cos_f32!(sin_cos_f32x16, near_f32x16, f32x16);

/// `(sin x, cos x)` of four single numbers side by side.
macro_rules! sin_cos_4 {
    ($name:ident, $near:ident, $element:ident, $lanes:ident, $limit:ident, $($padding:literal),*) => {
        #[inline]
        pub(super) fn $name([a, b, c, d]: [$element; 4]) -> [($element, $element); 4] {
            // The other path is written out here: handed to a function, the angles would
            // have an address, and vectors be put together in memory.
            let near = |x: $element| x.abs() <= $limit;
            if !(near(a) & near(b) & near(c) & near(d)) {
                cold();
                return [a, b, c, d].map(Scalar::sin_cos);
            }
            let (s, c) = $near($lanes::new([a, b, c, d, $($padding),*]));
            let (s, c) = (s.to_array(), c.to_array());
            [(s[0], c[0]), (s[1], c[1]), (s[2], c[2]), (s[3], c[3])]
        }
    };
}

// Not the widest vectors: while the full width of AVX-512 is at work, a core computes
// single numbers at half its rate.
sin_cos_4!(sin_cos_4_f64, near_f64x4, f64, f64x4, LIMIT_F64,);
sin_cos_4!(
    sin_cos_4_f32,
    near_f32x8,
    f32,
    f32x8,
    LIMIT_F32,
    0.0,
    0.0,
    0.0,
    0.0
);

/// Marks a path as unlikely.
#[cold]
fn cold() {}
