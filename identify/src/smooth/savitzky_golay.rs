//! Savitzky–Golay smoothing: least-squares polynomials in a moving window.
//!
//! Source: A. Savitzky, M. J. E. Golay, *Analytical Chemistry* 36 (1964);
//! weights by discrete orthogonal polynomials (G. E. Forsythe, *J. SIAM* 5,
//! 1957), which need no linear solve and take nodes at any times.

use super::{Channels, SmoothError};
use crate::log::Record;

/// Polynomial order of the reference pipeline.
const REFERENCE_ORDER: usize = 4;

/// Window of the reference pipeline \[s\].
const REFERENCE_WINDOW: f64 = 0.15;

/// How far a step taken from stamps may be off, a share of it: 37.499999 samples are 37.5.
const STAMPS: f64 = 1e-6;

/// Fewest samples in that window.
const REFERENCE_SAMPLES: usize = 7;

/// Relative deviation of a step from the mean up to which nodes count as
/// evenly spaced.
const EVEN: f64 = 0.01;

/// A Savitzky–Golay filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SavitzkyGolay {
    /// Order p of the polynomial.
    pub order: usize,
    /// Samples in the window, odd.
    pub window: usize,
}

impl SavitzkyGolay {
    /// The filter of order `order` whose window lasts `seconds` at a sampling
    /// step of `step` seconds: `round(seconds/step)` samples, one more when
    /// that is even, at least `fewest` and at least `order + 1`. Halves go up, also where a
    /// step taken from stamps is a little above the true one.
    pub fn with_duration(order: usize, seconds: f64, step: f64, fewest: usize) -> Self {
        let whole = (seconds / step * (1.0 + STAMPS)).round();
        // The cast saturates; a step of zero cannot ask for more than fits.
        let samples = whole.clamp(0.0, 1e6) as usize;
        let window = samples.max(fewest).max(order + 1) | 1;
        SavitzkyGolay { order, window }
    }

    /// The reference pipeline's filter: order 4 over 0.15 s, at least 7 samples.
    pub fn reference(step: f64) -> Self {
        Self::with_duration(REFERENCE_ORDER, REFERENCE_WINDOW, step, REFERENCE_SAMPLES)
    }

    /// The `derivative`-th derivative (0 value, 1, 2, …) of the fitted
    /// polynomials at every sample.
    ///
    /// `values[k]` is the sample at `t[k]` seconds; result in units of the
    /// values per second to the power of `derivative`. The first and last half
    /// window are evaluated on the polynomial of the first and last full
    /// window (`mode="interp"` in SciPy). Where steps deviate more than 1 %
    /// from their mean, each window is fitted at its own times. With fewer
    /// samples than the window, the window and where necessary the order
    /// shrink; a derivative above the order is zero.
    pub fn apply(&self, t: &[f64], values: &[f64], derivative: usize) -> Vec<f64> {
        let n = t.len().min(values.len());
        let (t, values) = (&t[..n], &values[..n]);
        if n == 0 {
            return Vec::new();
        }
        let largest = if n % 2 == 1 { n } else { n - 1 };
        let window = (self.window | 1).min(largest);
        let order = self.order.min(window - 1);
        match even_step(t) {
            Some(step) => evenly(values, step, order, window, derivative),
            None => unevenly(t, values, order, window, derivative),
        }
    }
}

/// The mean step when all steps are close to it.
fn even_step(t: &[f64]) -> Option<f64> {
    let pairs = t.len().checked_sub(1)?;
    let mean = (t[pairs] - t[0]) / pairs.max(1) as f64;
    let close = |pair: &[f64]| (pair[1] - pair[0] - mean).abs() <= EVEN * mean;
    (mean > 0.0 && t.windows(2).all(close)).then_some(mean)
}

fn evenly(values: &[f64], step: f64, order: usize, window: usize, derivative: usize) -> Vec<f64> {
    let n = values.len();
    let half = window / 2;
    let nodes: Vec<f64> = (0..window)
        .map(|i| (i as f64 - half as f64) * step)
        .collect();
    let interior = weights(&nodes, order, 0.0, derivative);
    (0..n)
        .map(|k| {
            let start = k.saturating_sub(half).min(n - window);
            let samples = &values[start..start + window];
            if start + half == k {
                dot(&interior, samples)
            } else {
                dot(
                    &weights(&nodes, order, nodes[k - start], derivative),
                    samples,
                )
            }
        })
        .collect()
}

fn unevenly(t: &[f64], values: &[f64], order: usize, window: usize, derivative: usize) -> Vec<f64> {
    let n = values.len();
    (0..n)
        .map(|k| {
            let start = k.saturating_sub(window / 2).min(n - window);
            let range = start..start + window;
            let nodes: Vec<f64> = t[range.clone()].iter().map(|stamp| stamp - t[k]).collect();
            dot(&weights(&nodes, order, 0.0, derivative), &values[range])
        })
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Weights `c` such that `Σ c_i y_i` is the `derivative`-th derivative at `at`
/// of the polynomial of degree `order` fitted to `y_i` at `nodes`:
///
/// `c_i = Σ_k p_k⁽ᵈ⁾(at) p_k(x_i) / Σ_j p_k(x_j)²`
///
/// with the polynomials `p_k` orthogonal on the nodes,
/// `p_{k+1} = (x - α_k) p_k - β_k p_{k-1}`.
fn weights(nodes: &[f64], order: usize, at: f64, derivative: usize) -> Vec<f64> {
    let span = nodes
        .iter()
        .fold(0.0_f64, |most, node| most.max(node.abs()));
    let unit = if span > 0.0 { span } else { 1.0 };
    let x: Vec<f64> = nodes.iter().map(|node| node / unit).collect();
    let at = at / unit;
    let mut current = vec![1.0; x.len()];
    let mut previous = vec![0.0; x.len()];
    // Derivatives 0 … d of p_k and p_{k-1} at the point.
    let mut here = vec![0.0; derivative + 1];
    let mut before = here.clone();
    here[0] = 1.0;
    let mut norm_before = 1.0;
    let mut result = vec![0.0; x.len()];
    for k in 0..=order {
        let norm = dot(&current, &current);
        for (weight, value) in result.iter_mut().zip(&current) {
            *weight += here[derivative] * value / norm;
        }
        let moment: f64 = x.iter().zip(&current).map(|(x, p)| x * p * p).sum();
        let alpha = moment / norm;
        let beta = if k == 0 { 0.0 } else { norm / norm_before };
        for i in 0..x.len() {
            let next = (x[i] - alpha) * current[i] - beta * previous[i];
            previous[i] = std::mem::replace(&mut current[i], next);
        }
        let next: Vec<f64> = (0..=derivative)
            .map(|d| {
                let product_rule = if d > 0 { d as f64 * here[d - 1] } else { 0.0 };
                product_rule + (at - alpha) * here[d] - beta * before[d]
            })
            .collect();
        before = std::mem::replace(&mut here, next);
        norm_before = norm;
    }
    let scale = unit.powi(-(derivative as i32));
    result.iter_mut().for_each(|weight| *weight *= scale);
    result
}

/// States and measured accelerations by the reference pipeline (m × n each).
#[derive(Debug, Clone, PartialEq)]
pub struct SgStates {
    /// Smoothed positions.
    pub q: Vec<Vec<f64>>,
    /// Velocities.
    pub v: Vec<Vec<f64>>,
    /// Accelerations.
    pub a: Vec<Vec<f64>>,
    /// The filter used.
    pub filter: SavitzkyGolay,
}

/// The reference pipeline, by which acceleration errors are reported.
///
/// `q`: order 4 over 0.15 s (at least 7 samples). `v`: the same filter on the
/// logged velocity, else the first derivative of `q`. `a`: the logged
/// acceleration as it is, else the first derivative of the logged velocity,
/// else the second derivative of `q`. Stretches between gaps are filtered
/// apart. Positions and velocities that no column shows are taken as they were estimated.
///
/// # Errors
///
/// [`SmoothError`] when the record's channels differ in length, are not
/// finite, or time does not increase.
pub fn savgol_states(record: &Record) -> Result<SgStates, SmoothError> {
    let filter = SavitzkyGolay::reference(record.step());
    let segments = record.segments();
    let mut states = SgStates {
        q: Vec::new(),
        v: Vec::new(),
        a: Vec::new(),
        filter,
    };
    for i in 0..record.q.len() {
        let channels = Channels::of(record, i)?;
        let apply = |values: &[f64], derivative: usize| -> Vec<f64> {
            let parts = segments.iter().map(|range| {
                filter.apply(
                    &channels.t[range.clone()],
                    &values[range.clone()],
                    derivative,
                )
            });
            parts.flatten().collect()
        };
        let smoothed = |values: &[f64]| match record.is_measured(i) {
            true => apply(values, 0),
            // An estimate is smooth already, and another filter would blunt it.
            false => values.to_vec(),
        };
        states.q.push(smoothed(channels.q));
        states.v.push(match channels.dq {
            Some(dq) => smoothed(dq),
            None => apply(channels.q, 1),
        });
        states.a.push(match (channels.ddq, channels.dq) {
            (Some(ddq), _) => ddq.to_vec(),
            (None, Some(dq)) => apply(dq, 1),
            (None, None) => apply(channels.q, 2),
        });
    }
    Ok(states)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_odd_and_long_enough() {
        let samples = |rate: f64| SavitzkyGolay::reference(1.0 / rate).window;
        assert_eq!(
            [samples(200.0), samples(250.0), samples(1000.0)],
            [31, 39, 151]
        );
        assert_eq!(samples(20.0), 7);
        // A step as the difference of two stamps gives it.
        assert_eq!(SavitzkyGolay::reference(1.004 - 1.0).window, 39);
    }

    /// A polynomial of the filter's order passes unchanged, at uneven times,
    /// up to both ends.
    #[test]
    fn polynomials_pass_at_uneven_times() {
        let filter = SavitzkyGolay {
            order: 4,
            window: 9,
        };
        let t: Vec<f64> = (0..40)
            .map(|k| 0.1 * f64::from(k) + 0.03 * (1.7 * f64::from(k)).sin())
            .collect();
        let x: Vec<f64> = t
            .iter()
            .map(|t| 1.0 - t + 0.5 * t.powi(2) - 0.2 * t.powi(4))
            .collect();
        let dx = |t: f64| -1.0 + t - 0.8 * t.powi(3);
        let ddx = |t: f64| 1.0 - 2.4 * t * t;
        for k in 0..40 {
            assert!((filter.apply(&t, &x, 0)[k] - x[k]).abs() < 1e-11);
            assert!((filter.apply(&t, &x, 1)[k] - dx(t[k])).abs() < 1e-10);
            assert!((filter.apply(&t, &x, 2)[k] - ddx(t[k])).abs() < 1e-8);
        }
    }

    #[test]
    fn short_signals_use_what_there_is() {
        let filter = SavitzkyGolay {
            order: 4,
            window: 31,
        };
        assert_eq!(filter.apply(&[], &[], 0), Vec::<f64>::new());
        assert_eq!(filter.apply(&[1.0], &[5.0], 0), [5.0]);
        assert_eq!(filter.apply(&[1.0], &[5.0], 1), [0.0]);
        let line = filter.apply(&[0.0, 1.0, 2.0, 3.0], &[0.0, 2.0, 4.0, 6.0], 1);
        assert!(
            line.iter().all(|slope| (slope - 2.0).abs() < 1e-12),
            "{line:?}"
        );
    }
}
