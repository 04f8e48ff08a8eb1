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
    let mut step = DMatrix::zeros(2 * n, 2 * n);
    step.view_mut((0, n), (n, n)).fill_diagonal(h);
    step.view_mut((n, 0), (n, 2 * n)).copy_from(&(slope * h));
    let motion = exponential(&step);
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

/// `exp S` by its series; where that has not converged after a few terms, by the library's Padé approximation.
fn exponential(step: &DMatrix<f64>) -> DMatrix<f64> {
    let size = step.nrows();
    let mut term = step.clone();
    let mut sum = DMatrix::identity(size, size) + step;
    for order in 2..=MOST_TERMS {
        term = &term * step / f64::from(order);
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
        for size in [1e-4, 0.05, 0.3, 3.0, 30.0] {
            let step = DMatrix::from_fn(4, 4, |i, j| {
                let entry = (1.0 + 3.0 * i as f64 + j as f64).sin();
                if i == j { -size } else { 0.2 * size * entry }
            });
            let exact = step.exp();
            let apart = (exponential(&step) - &exact).amax();
            assert!(apart < 1e-9 * exact.amax().max(1.0), "{size}: {apart}");
        }
    }
}
