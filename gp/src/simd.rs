//! Inner loops: written as plain Rust over slices, compiled for the widest
//! vector unit found at run time.
//!
//! No fused multiply-add is used, so results do not depend on the machine.

use faer::traits::pulp::Arch;

/// Points handled at once by the kernels; small enough for stack buffers.
pub(crate) const TILE: usize = 128;

const LANES: usize = 8;

/// Run `f` compiled for the best instruction set of this machine.
#[inline(always)]
pub(crate) fn dispatch<R>(f: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(f)
}

/// `exp(x)` for `x <= 709`, accurate to about one unit in the last place;
/// results below the normal range are 0.
///
/// `x = k ln 2 + r`, `|r| <= ln 2 / 2`, Taylor polynomial of degree 13 in `r`
/// (remainder below 5e-18).
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    const LN2_HI: f64 = 6.931_471_803_691_238e-1;
    const LN2_LO: f64 = 1.908_214_929_270_587_7e-10;
    let clamped = if x < -708.0 { -708.0 } else { x };
    let shifted = clamped * std::f64::consts::LOG2_E + MAGIC;
    let k = shifted - MAGIC;
    let r = (clamped - k * LN2_HI) - k * LN2_LO;
    let mut p = 1.0 / 6_227_020_800.0;
    p = p * r + 1.0 / 479_001_600.0;
    p = p * r + 1.0 / 39_916_800.0;
    p = p * r + 1.0 / 3_628_800.0;
    p = p * r + 1.0 / 362_880.0;
    p = p * r + 1.0 / 40_320.0;
    p = p * r + 1.0 / 5_040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    p = p * r + 1.0;
    p = p * r + 1.0;
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
    if x < -708.0 { 0.0 } else { p * scale }
}

/// `y += a x`.
#[inline(always)]
pub(crate) fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `z += x ∘ y` (elementwise).
#[inline(always)]
pub(crate) fn fused(x: &[f64], y: &[f64], z: &mut [f64]) {
    for ((z, x), y) in z.iter_mut().zip(x).zip(y) {
        *z += x * y;
    }
}

/// `Σ x`.
#[inline(always)]
pub(crate) fn sum(x: &[f64]) -> f64 {
    let mut acc = [0.0; LANES];
    let chunks = x.chunks_exact(LANES);
    let rest: f64 = chunks.remainder().iter().sum();
    for c in chunks {
        for l in 0..LANES {
            acc[l] += c[l];
        }
    }
    acc.iter().sum::<f64>() + rest
}

/// `Σ x_j y_j`.
#[inline(always)]
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len().min(y.len());
    let (x, y) = (&x[..n], &y[..n]);
    let mut acc = [0.0; LANES];
    let (cx, cy) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let rest: f64 = cx
        .remainder()
        .iter()
        .zip(cy.remainder())
        .map(|(a, b)| a * b)
        .sum();
    for (a, b) in cx.zip(cy) {
        for l in 0..LANES {
            acc[l] += a[l] * b[l];
        }
    }
    acc.iter().sum::<f64>() + rest
}

/// `Σ w_j ((x_j - c) s)²`.
#[inline(always)]
pub(crate) fn weighted_square(w: &[f64], x: &[f64], c: f64, s: f64) -> f64 {
    let n = x.len().min(w.len());
    let (x, w) = (&x[..n], &w[..n]);
    let term = |w: f64, x: f64| {
        let t = (x - c) * s;
        w * (t * t)
    };
    let mut acc = [0.0; LANES];
    let (cw, cx) = (w.chunks_exact(LANES), x.chunks_exact(LANES));
    let rest: f64 = cw
        .remainder()
        .iter()
        .zip(cx.remainder())
        .map(|(&w, &x)| term(w, x))
        .sum();
    for (a, b) in cw.zip(cx) {
        for l in 0..LANES {
            acc[l] += term(a[l], b[l]);
        }
    }
    acc.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_agrees_with_the_standard_library() {
        let mut x = -707.9;
        while x < 700.0 {
            let (got, want) = (exp(x), x.exp());
            assert!(
                (got - want).abs() <= 4.5e-16 * want,
                "exp({x}) = {got}, not {want}"
            );
            x += 0.0937;
        }
        assert_eq!(exp(-1e4), 0.0);
        assert_eq!(exp(0.0), 1.0);
        assert!(exp(f64::NAN).is_nan());
    }

    #[test]
    fn sums_agree_with_plain_loops() {
        let x: Vec<f64> = (0..37).map(|i| (i as f64 * 0.7).sin()).collect();
        let y: Vec<f64> = (0..37).map(|i| (i as f64 * 0.3).cos()).collect();
        let plain: f64 = x.iter().zip(&y).map(|(a, b)| a * b).sum();
        assert!((dot(&x, &y) - plain).abs() < 1e-14);
        assert!((sum(&x) - x.iter().sum::<f64>()).abs() < 1e-14);
        let plain: f64 = x
            .iter()
            .zip(&y)
            .map(|(w, x)| w * ((x - 0.2) * 1.5).powi(2))
            .sum();
        assert!((weighted_square(&x, &y, 0.2, 1.5) - plain).abs() < 1e-14);
    }
}
