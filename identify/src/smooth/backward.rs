//! Fixed-interval smoothing: the backward pass.
//!
//! Modified Bryson–Fraser form of the Rauch–Tung–Striebel smoother (G. J.
//! Bierman, *Fixed interval smoothing with discrete measurements*, Int. J.
//! Control 18, 1973): the same posterior, but no covariance is inverted.

use super::filter::{Step, Update};
use super::wiener::Wiener;
use nalgebra::{SMatrix, SVector};

/// Mean and variances of the state given all samples of a stretch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Posterior<const N: usize> {
    /// Mean.
    pub mean: SVector<f64, N>,
    /// Variances, the diagonal of the covariance.
    pub variance: SVector<f64, N>,
}

impl<const N: usize> Wiener<N> {
    /// The posterior at every step of a filtered stretch, stamped `t`.
    pub(super) fn backward(&self, steps: &[Step<N>], t: &[f64]) -> Vec<Posterior<N>> {
        let mut posteriors = Vec::with_capacity(steps.len());
        let mut lambda = SVector::<f64, N>::zeros();
        let mut information = SMatrix::<f64, N, N>::zeros();
        for (k, step) in steps.iter().enumerate().rev() {
            let p = &step.covariance;
            let reduction = p * information * p;
            posteriors.push(Posterior {
                mean: step.mean - p * lambda,
                // Negative only by rounding, where the posterior variance is
                // below 1e-16 of the filtered one.
                variance: (p.diagonal() - reduction.diagonal()).map(|variance| variance.max(0.0)),
            });
            for update in step.updates.iter().rev().flatten() {
                undo(update, &mut lambda, &mut information);
            }
            if k > 0 {
                let f = self.transition(t[k] - t[k - 1]);
                lambda = f.transpose() * lambda;
                information = f.transpose() * information * f;
                information = 0.5 * (information + information.transpose());
            }
        }
        posteriors.reverse();
        posteriors
    }
}

/// Passes a measurement backwards: with `C = I - K eᵢᵀ`,
/// `λ ← Cᵀ λ - eᵢ ν/S`, `Λ ← Cᵀ Λ C + eᵢ eᵢᵀ/S`.
fn undo<const N: usize>(
    update: &Update<N>,
    lambda: &mut SVector<f64, N>,
    information: &mut SMatrix<f64, N, N>,
) {
    let i = update.component;
    lambda[i] -= update.gain.dot(lambda) + update.innovation / update.variance;
    let g = *information * update.gain;
    let s = update.gain.dot(&g);
    for a in 0..N {
        information[(a, i)] -= g[a];
        information[(i, a)] -= g[a];
    }
    information[(i, i)] += s + 1.0 / update.variance;
}
