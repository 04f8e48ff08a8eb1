//! Kalman filter over one stretch without gaps, and its likelihood.

use super::Channels;
use super::wiener::Wiener;
use nalgebra::{SMatrix, SVector};
use std::ops::Range;

/// Relative deviation from the median step within which the likelihood takes
/// the covariances of the median step; means use the true step.
const REGULAR: f64 = 0.01;

/// Relative change of a variance below which it counts as stationary.
const STATIONARY: f64 = 1e-8;

/// One scalar measurement taken in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Update<const N: usize> {
    /// Component of the state that was measured.
    pub component: usize,
    /// Measured minus predicted.
    pub innovation: f64,
    /// Variance of the innovation.
    pub variance: f64,
    /// Kalman gain.
    pub gain: SVector<f64, N>,
}

/// The filter after one sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step<const N: usize> {
    /// Mean given the samples so far.
    pub mean: SVector<f64, N>,
    /// Covariance given the samples so far.
    pub covariance: SMatrix<f64, N, N>,
    /// The measurements taken in, in order.
    pub updates: [Option<Update<N>>; 3],
}

impl<const N: usize> Wiener<N> {
    fn initial(&self, channels: &Channels, first: usize) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
        let mut mean = SVector::zeros();
        mean[0] = channels.q[first];
        (mean, SMatrix::from_diagonal(&self.prior))
    }

    /// Gain and innovation variance for a measurement of component `i`, and
    /// the covariance after it. Row and column `i` are formed as
    /// `P_ij R/S`, which does not cancel.
    fn take_in(p: &mut SMatrix<f64, N, N>, i: usize, noise: f64) -> (SVector<f64, N>, f64) {
        let variance = p[(i, i)] + noise;
        let column: SVector<f64, N> = p.column(i).into_owned();
        let gain = column / variance;
        let kept = noise / variance;
        for a in 0..N {
            for b in 0..N {
                if a == i || b == i {
                    p[(a, b)] *= kept;
                } else {
                    p[(a, b)] -= gain[a] * column[b];
                }
            }
        }
        (gain, variance)
    }

    fn predict(&self, p: &SMatrix<f64, N, N>, step: f64) -> SMatrix<f64, N, N> {
        let f = self.transition(step);
        let next = f * p * f.transpose() + self.diffusion(step);
        0.5 * (next + next.transpose())
    }

    /// Filters the samples of a range; exact at every step.
    pub(super) fn filter(&self, channels: &Channels, range: Range<usize>) -> Vec<Step<N>> {
        let mut steps = Vec::with_capacity(range.len());
        let (mut mean, mut covariance) = self.initial(channels, range.start);
        for k in range.clone() {
            if k > range.start {
                let step = channels.t[k] - channels.t[k - 1];
                mean = self.advance(&mean, step);
                covariance = self.predict(&covariance, step);
            }
            let mut updates = [None; 3];
            for (i, update) in updates.iter_mut().enumerate() {
                let (Some(noise), Some(values)) = (self.noise[i], channels.derivative(i)) else {
                    continue;
                };
                if !channels.is_measured(i, k) {
                    continue;
                }
                let innovation = values[k] / self.si(i) - mean[i];
                let (gain, variance) = Self::take_in(&mut covariance, i, noise);
                mean += gain * innovation;
                *update = Some(Update {
                    component: i,
                    innovation,
                    variance,
                    gain,
                });
            }
            steps.push(Step {
                mean,
                covariance,
                updates,
            });
        }
        steps
    }

    /// Log-likelihood of the samples of a range in SI units. Once the
    /// covariance is stationary on regular steps, gains are reused and a
    /// sample costs a few multiplications.
    pub(super) fn log_likelihood(
        &self,
        channels: &Channels,
        range: Range<usize>,
        median_step: f64,
    ) -> f64 {
        let used: Vec<Used> = (0..3).filter_map(|i| self.used(channels, i)).collect();
        // Densities are per scaled unit of dq and ddq: back to SI by τ^i.
        let jacobian: f64 = used
            .iter()
            .map(|u| u.component as f64 * self.unit.ln())
            .sum();
        let mut sum = jacobian * range.len() as f64;
        let (mut mean, mut covariance) = self.initial(channels, range.start);
        let mut gains = [(SVector::<f64, N>::zeros(), 1.0, 0.0); 3];
        let mut stationary = false;
        for k in range.clone() {
            let is_whole = used.iter().all(|u| channels.is_measured(u.component, k));
            stationary &= is_whole;
            if k > range.start {
                let step = channels.t[k] - channels.t[k - 1];
                mean = self.advance(&mean, step);
                let regular = (step - median_step).abs() <= REGULAR * median_step;
                if !(regular && stationary) {
                    let step = if regular { median_step } else { step };
                    covariance = self.predict(&covariance, step);
                    stationary = false;
                }
            }
            if !stationary {
                let before = gains;
                for (used, gain) in used.iter().zip(&mut gains) {
                    if !channels.is_measured(used.component, k) {
                        *gain = (
                            SVector::zeros(),
                            0.0,
                            2.0 * used.component as f64 * self.unit.ln(),
                        );
                        continue;
                    }
                    let (k, variance) = Self::take_in(&mut covariance, used.component, used.noise);
                    *gain = (k, 1.0 / variance, (std::f64::consts::TAU * variance).ln());
                }
                stationary = is_whole && settled(&before, &gains[..used.len()]);
            }
            for (used, (gain, precision, log)) in used.iter().zip(&gains) {
                let innovation = used.values[k] * used.scale - mean[used.component];
                mean += gain * innovation;
                sum -= 0.5 * (log + innovation * innovation * precision);
            }
        }
        sum
    }
}

/// A measured channel in scaled units.
struct Used<'a> {
    component: usize,
    noise: f64,
    values: &'a [f64],
    scale: f64,
}

impl<const N: usize> Wiener<N> {
    fn used<'a>(&self, channels: &Channels<'a>, component: usize) -> Option<Used<'a>> {
        Some(Used {
            component,
            noise: self.noise[component]?,
            values: channels.derivative(component)?,
            scale: 1.0 / self.si(component),
        })
    }
}

/// Gain, `1/S` and `log 2πS` for the innovation variance S.
type Gain<const N: usize> = (SVector<f64, N>, f64, f64);

/// Whether gains and innovation variances have stopped changing.
fn settled<const N: usize>(before: &[Gain<N>], after: &[Gain<N>]) -> bool {
    before.iter().zip(after).all(|(old, new)| {
        let gain = (old.0 - new.0).amax() <= STATIONARY * new.0.amax();
        gain && (old.1 - new.1).abs() <= STATIONARY * new.1
    })
}
