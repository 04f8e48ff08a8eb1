//! Elementary functions of `f32`: those of `libm`, but for sine and cosine, which `libm` computes in
//! `f64`. On a processor with single precision alone that costs a thousand instructions.

pub(super) use libm::{acosf, asinf, atan2f, atanf, expf, logf, powf, sqrtf, tanf, tanhf};

/// Up to here in radians the reduction by quarter turns loses nothing.
const LIMIT: f32 = 4000.0;

/// Sine and cosine within 2 units of the last place.
pub(super) fn sincosf(x: f32) -> (f32, f32) {
    if !(-LIMIT..=LIMIT).contains(&x) {
        return libm::sincosf(x);
    }
    // In the last bits of the sum stands the number of quarter turns, rounded.
    let magic = 12_582_912.0; // 1.5 · 2^23
    let shifted = x * core::f32::consts::FRAC_2_PI + magic;
    let n = shifted - magic;
    // π/2 in parts of at most 11 bits, so that n below 2^12 keeps products exact.
    let r = x - n * f32::from_bits(0x3FC9_0000);
    let r = r - n * f32::from_bits(0x39FD_A000);
    let r = r - n * f32::from_bits(0x33A2_2000);
    let r = r - n * f32::from_bits(0x2C34_611A);
    let z = r * r;
    let sine = -1.666_665_5e-1 + z * (8.332_161e-3 + z * -1.951_529_6e-4);
    let cosine = 4.166_664_6e-2 + z * (-1.388_731_6e-3 + z * 2.443_315_7e-5);
    let s = (z * r) * sine + r;
    // 1 − z/2 loses up to half a unit; what it lost is added back.
    let w = 1.0 - z * 0.5;
    let lost = (1.0 - w) - z * 0.5;
    let c = w + ((z * z) * cosine + lost);
    match shifted.to_bits() & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// As [`sincosf`].
pub(super) fn sinf(x: f32) -> f32 {
    sincosf(x).0
}

/// As [`sincosf`].
pub(super) fn cosf(x: f32) -> f32 {
    sincosf(x).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn units(found: f32, exact: f64) -> f64 {
        let exponent = libm::floor(libm::log2(exact.abs().max(1e-30)));
        (f64::from(found) - exact).abs() / libm::exp2(exponent - 23.0)
    }

    #[test]
    fn sine_and_cosine_are_those_of_double_precision() {
        let mut worst: f64 = 0.0;
        let mut check = |x: f32| {
            let (s, c) = sincosf(x);
            let (es, ec) = libm::sincos(f64::from(x));
            worst = worst.max(units(s, es)).max(units(c, ec));
        };
        for k in -200_000..=200_000 {
            check(k as f32 * 1.7e-5);
            check(k as f32 * 0.019_99);
        }
        for k in -2500..=2500 {
            check(k as f32 * core::f32::consts::FRAC_PI_2);
        }
        assert!(worst < 2.0, "{worst}");
        assert_eq!(sincosf(0.0), (0.0, 1.0));
        assert_eq!(sincosf(5000.0), libm::sincosf(5000.0));
        assert!(sincosf(f32::NAN).0.is_nan() && sincosf(f32::INFINITY).1.is_nan());
    }
}
