//! Noise levels and the intensity of motion by maximum likelihood.

use super::channels::NAMES;
use super::savitzky_golay::SavitzkyGolay;
use super::wiener::{Hyper, Wiener};
use super::{Channels, SmoothError};
use crate::log::{mad_sd, median_step, quantisation_step, segments};
use basin::{CostFunction, Executor, NelderMead};
use std::convert::Infallible;
use std::ops::Range;

/// Fewest samples from which hyper-parameters are estimated.
pub(super) const MINIMUM: usize = 20;

/// Samples used for the estimate when sampling is irregular and every step
/// costs a full covariance update.
const IRREGULAR_SAMPLES: usize = 6000;

/// Response times tried as a start, in median steps.
const RESPONSES: [f64; 9] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// Iterations of the simplex method; it stops on its own after about a
/// hundred.
const ITERATIONS: u64 = 600;

/// The best hyper-parameters found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub hyper: Hyper,
    pub log_likelihood: f64,
    pub converged: bool,
}

/// What does not depend on the order of the model.
pub(super) struct Task<'a> {
    channels: Channels<'a>,
    /// Segments over which the likelihood is taken.
    training: Vec<Range<usize>>,
    step: f64,
    duration: f64,
    /// Start values of the noise, by robust differences.
    start: [Option<f64>; 3],
    /// Lower bounds of the noise, from the quantisation.
    floor: [f64; 3],
    /// Upper bounds of the noise.
    ceiling: [f64; 3],
    prior_sd: [f64; 4],
}

impl<'a> Task<'a> {
    pub fn new(channels: Channels<'a>) -> Result<Self, SmoothError> {
        let t = channels.t;
        if t.len() < MINIMUM {
            return Err(SmoothError::TooShort {
                found: t.len(),
                minimum: MINIMUM,
            });
        }
        let step = median_step(t);
        let segments = segments(t);
        let prior_sd = prior(&channels, step, &segments);
        let (mut start, mut floor, mut ceiling) = ([None; 3], [0.0; 3], [0.0; 3]);
        for i in 0..NAMES.len() {
            let Some(values) = channels.derivative(i) else {
                continue;
            };
            let range = range_of(values).max(prior_sd[i]);
            let rounding = quantisation_step(values).unwrap_or(0.0) / 12_f64.sqrt();
            floor[i] = rounding.max(1e-9 * range);
            ceiling[i] = range.max(10.0 * floor[i]);
            start[i] = Some(high_frequency(values).clamp(1.2 * floor[i], ceiling[i]));
        }
        Ok(Task {
            training: training(t, step, &segments),
            duration: t[t.len() - 1] - t[0],
            channels,
            step,
            start,
            floor,
            ceiling,
            prior_sd,
        })
    }

    /// Hyper-parameters from the search variables: logarithms of the noise
    /// levels of the channels there are, then `ln(density)/2N`.
    fn hyper<const N: usize>(&self, x: &[f64]) -> Hyper {
        let mut sd = [None; 3];
        let mut logs = x.iter();
        for (sd, start) in sd.iter_mut().zip(&self.start) {
            if start.is_some() {
                *sd = logs.next().map(|log| log.exp());
            }
        }
        let density = logs.next().map_or(1.0, |log| (2.0 * N as f64 * log).exp());
        Hyper {
            density,
            sd,
            prior_sd: self.prior_sd,
        }
    }

    /// Negative log-likelihood; infinite outside the bounds.
    fn cost<const N: usize>(&self, x: &[f64]) -> f64 {
        let hyper = self.hyper::<N>(x);
        for (i, sd) in hyper.sd.iter().enumerate() {
            if sd.is_some_and(|sd| sd < self.floor[i] || sd > self.ceiling[i]) {
                return f64::INFINITY;
            }
        }
        let sd_q = hyper.sd[0].unwrap_or(1.0);
        let response = (sd_q * sd_q * self.step / hyper.density).powf(0.5 / N as f64);
        if !(1e-3 * self.step..=10.0 * self.duration).contains(&response) {
            return f64::INFINITY;
        }
        let model = Wiener::<N>::new(&hyper, self.step, self.duration);
        let parts = self.training.iter();
        let total: f64 = parts
            .map(|range| model.log_likelihood(&self.channels, range.clone(), self.step))
            .sum();
        if total.is_finite() {
            -total
        } else {
            f64::INFINITY
        }
    }

    /// Maximum-likelihood hyper-parameters of the model of order N.
    pub fn fit<const N: usize>(&self) -> Result<Fit, SmoothError> {
        let nothing = || SmoothError::NoLikelihood {
            range: range_of(self.channels.q),
        };
        let start = self.best_start::<N>().ok_or_else(nothing)?;
        let mut x = start;
        let mut converged = false;
        // A second simplex around the first result guards against a collapse.
        for size in [0.4, 0.1] {
            (x, converged) = self.search::<N>(x, size);
        }
        let cost = self.cost::<N>(&x);
        if !cost.is_finite() {
            return Err(nothing());
        }
        Ok(Fit {
            hyper: self.hyper::<N>(&x),
            log_likelihood: -cost,
            converged,
        })
    }

    /// The most likely of a few intensities at the robust noise levels.
    fn best_start<const N: usize>(&self) -> Option<Vec<f64>> {
        let logs: Vec<f64> = self.start.iter().flatten().map(|sd| sd.ln()).collect();
        let sd_q = self.start[0].unwrap_or(1.0);
        let candidates = RESPONSES.map(|steps| {
            let response = steps * self.step;
            let density = sd_q * sd_q * self.step / response.powi(2 * N as i32);
            let mut x = logs.clone();
            x.push(density.ln() / (2.0 * N as f64));
            (self.cost::<N>(&x), x)
        });
        let finite = candidates.into_iter().filter(|(cost, _)| cost.is_finite());
        finite.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, x)| x)
    }

    fn search<const N: usize>(&self, start: Vec<f64>, size: f64) -> (Vec<f64>, bool) {
        let mut vertices = vec![start.clone()];
        for i in 0..start.len() {
            let mut vertex = start.clone();
            vertex[i] += size;
            vertices.push(vertex);
        }
        let solver = NelderMead::new()
            .with_absolute_simplex_size_tolerance(1e-3)
            .with_absolute_simplex_cost_tolerance(1e-3);
        let state = basin::SimplexProgress::from_simplex(vertices);
        let result = Executor::new(Objective::<N>(self), solver, state)
            .max_iter(ITERATIONS)
            .run();
        match result {
            Ok(result) => {
                let converged = result.iter() < ITERATIONS;
                (result.best_param().clone(), converged)
            }
            Err(never) => match never {},
        }
    }
}

/// The cost as the optimiser sees it.
struct Objective<'a, 'b, const N: usize>(&'a Task<'b>);

impl<const N: usize> CostFunction for Objective<'_, '_, N> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Infallible;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Infallible> {
        Ok(self.0.cost::<N>(x))
    }
}

fn range_of(values: &[f64]) -> f64 {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    let (least, most) = values
        .iter()
        .fold(start, |(a, b), value| (a.min(*value), b.max(*value)));
    (most - least).max(1e-12 * most.abs().max(1.0))
}

/// Noise level from fifth differences, whose weights have square sum 252: a
/// smooth motion leaves little in them.
fn high_frequency(values: &[f64]) -> f64 {
    let fifth: Vec<f64> = values
        .windows(6)
        .map(|v| (v[5] - v[0]) - 5.0 * (v[4] - v[1]) + 10.0 * (v[3] - v[2]))
        .collect();
    mad_sd(&fifth).unwrap_or(0.0) / 252_f64.sqrt()
}

/// Weak knowledge of the first state: three times the largest value, velocity,
/// acceleration and jerk that a local polynomial sees anywhere.
fn prior(channels: &Channels, step: f64, segments: &[Range<usize>]) -> [f64; 4] {
    let filter = SavitzkyGolay::reference(step);
    let largest = |values: &[f64], derivative: usize| -> f64 {
        let parts = segments.iter().map(|range| {
            let part = filter.apply(
                &channels.t[range.clone()],
                &values[range.clone()],
                derivative,
            );
            part.iter()
                .fold(0.0_f64, |most, value| most.max(value.abs()))
        });
        parts.fold(0.0, f64::max)
    };
    let position = range_of(channels.q);
    let velocity = channels
        .dq
        .map_or_else(|| largest(channels.q, 1), |dq| largest(dq, 0));
    let acceleration = match (channels.ddq, channels.dq) {
        (Some(ddq), _) => largest(ddq, 0),
        (None, Some(dq)) => largest(dq, 1),
        (None, None) => largest(channels.q, 2),
    };
    let jerk = largest(channels.q, 3);
    // A coordinate that never moves still needs positive variances.
    let least = 1e-6 * position;
    [position, velocity, acceleration, jerk].map(|scale| 3.0 * scale.max(least))
}

/// All samples when sampling is regular; else evenly placed blocks.
fn training(t: &[f64], step: f64, segments: &[Range<usize>]) -> Vec<Range<usize>> {
    let regular = |pair: &&[f64]| (pair[1] - pair[0] - step).abs() <= 0.01 * step;
    let irregular = t.len() - 1 - t.windows(2).filter(regular).count();
    if t.len() <= IRREGULAR_SAMPLES || 20 * irregular < t.len() {
        return segments.to_vec();
    }
    let keep = IRREGULAR_SAMPLES as f64 / t.len() as f64;
    let block = IRREGULAR_SAMPLES / 6;
    let mut ranges = Vec::new();
    for segment in segments {
        let blocks = (segment.len() as f64 * keep / block as f64).ceil().max(1.0) as usize;
        let spacing = segment.len() / blocks;
        for b in 0..blocks {
            let start = segment.start + b * spacing;
            ranges.push(start..(start + block.min(spacing)));
        }
    }
    ranges
}
