//! How a departure and the forces that nothing explains move on over an interval.

use nalgebra::{DMatrix, DVector};

/// `Φ = exp(hJ)` with `J = [[0, I, 0], [F, P], [0, 0, −1/τ]]` at the middle.
pub(super) fn transition(
    slope: &DMatrix<f64>,
    mobility: &DMatrix<f64>,
    h: f64,
    correlation: &DVector<f64>,
) -> DMatrix<f64> {
    let n = slope.nrows();
    let motion = motion(slope, h);
    // The force, falling off, through half of the way on average.
    let mut whole = DMatrix::identity(3 * n, 3 * n);
    let pushed = (motion.view((n, n), (n, n)) + DMatrix::identity(n, n)) * mobility;
    for (i, &tau) in correlation.iter().enumerate() {
        let decay = decay(h, tau);
        let mean = tau * (1.0 - decay);
        let moved = mobility.column(i) * (0.5 * h * mean);
        whole.view_mut((0, 2 * n + i), (n, 1)).copy_from(&moved);
        let pushed = pushed.column(i) * (0.5 * mean);
        whole.view_mut((n, 2 * n + i), (n, 1)).copy_from(&pushed);
        whole[(2 * n + i, 2 * n + i)] = decay;
    }
    whole.view_mut((0, 0), (2 * n, 2 * n)).copy_from(&motion);
    whole
}

/// `exp(hJ)` with `J = [[0, I], [F]]` and `F` the `slope`, by its series `Σ Tₖ`, `Tₖ₊₁ = h/(k+1) J Tₖ`: the upper
/// half of each term is the lower half of the one before it. Where that has not converged after a few terms, by
/// the library's Padé approximation.
fn motion(slope: &DMatrix<f64>, h: f64) -> DMatrix<f64> {
    let n = slope.nrows();
    let mut step = DMatrix::zeros(2 * n, 2 * n);
    step.view_mut((0, n), (n, n)).fill_diagonal(h);
    step.rows_mut(n, n).copy_from(&(slope * h));
    let mut sum = DMatrix::identity(2 * n, 2 * n) + &step;
    let (mut term, mut next) = (step.clone(), DMatrix::zeros(2 * n, 2 * n));
    for order in 2..=MOST_TERMS {
        let share = h / f64::from(order);
        let mut lower = next.rows_mut(n, n);
        lower.gemm(share, slope, &term, 0.0);
        let mut upper = next.rows_mut(0, n);
        upper.copy_from(&term.rows(n, n));
        upper *= share;
        std::mem::swap(&mut term, &mut next);
        sum += &term;
        if term.amax() < CONVERGED {
            return sum;
        }
    }
    step.exp()
}

/// What is left of an unexplained force after `h` seconds.
pub(super) fn decay(h: f64, tau: f64) -> f64 {
    (-h / tau).exp()
}

/// The last term of the series of an exponential, at most; where a machine is stiff, more would be needed.
const MOST_TERMS: u32 = 8;
/// A term is the last one whose entries are smaller.
const CONVERGED: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    /// Slow and stiff steps, against the library's approximation.
    #[test]
    fn the_series_is_the_exponential() {
        let slope = DMatrix::from_fn(2, 4, |i, j| {
            let entry = (1.0 + 3.0 * i as f64 + j as f64).sin();
            if i + 2 == j { -1.0 } else { 0.2 * entry }
        });
        let mut whole = DMatrix::zeros(4, 4);
        whole.view_mut((0, 2), (2, 2)).fill_with_identity();
        whole.rows_mut(2, 2).copy_from(&slope);
        for h in [1e-4, 0.05, 0.3, 3.0, 30.0] {
            let exact = (&whole * h).exp();
            let apart = (motion(&slope, h) - &exact).amax();
            assert!(apart < 1e-9 * exact.amax().max(1.0), "{h}: {apart}");
        }
    }
}
