//! Noise levels and the intensity of motion by maximum likelihood.

use super::channels::NAMES;
use super::savitzky_golay::SavitzkyGolay;
use super::wiener::{HIGHEST, Hyper, Wiener};
use super::{Channels, Options, SmoothError};
use crate::log::{mad_sd, median_step, quantisation_step, segments};
use basin::{CostFunction, Executor, NelderMead};
use std::convert::Infallible;
use std::ops::Range;

/// Fewest samples from which hyper-parameters are estimated.
pub(super) const MINIMUM: usize = 20;

/// Samples used for the estimate on regular steps, where a sample costs a few
/// multiplications, and otherwise, where it costs covariance updates. The
/// standard error of a noise level is about `1/sqrt(2n)` of it.
const REGULAR_SAMPLES: usize = 12_000;
const IRREGULAR_SAMPLES: usize = 3000;

/// Blocks into which these are divided over a longer log.
const BLOCKS: usize = 6;

/// Response times tried as a start, in median steps.
pub(super) const RESPONSES: [f64; 9] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// Iterations of the simplex method; it stops on its own after about a
/// hundred.
const ITERATIONS: u64 = 600;

/// The best hyper-parameters found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub order: usize,
    pub hyper: Hyper,
    pub log_likelihood: f64,
    pub converged: bool,
}

/// What does not depend on the order of the model.
pub(super) struct Task<'a> {
    pub(super) channels: Channels<'a>,
    /// Segments over which the likelihood is taken.
    pub(super) training: Vec<Range<usize>>,
    pub(super) step: f64,
    pub(super) duration: f64,
    /// Start values of the noise, by robust differences.
    pub(super) start: [Option<f64>; 3],
    /// Lower bounds of the noise, from the quantisation.
    floor: [f64; 3],
    /// Upper bounds of the noise.
    ceiling: [f64; 3],
    pub(super) prior_sd: [f64; HIGHEST],
    pub(super) shortest_response: f64,
}

impl<'a> Task<'a> {
    pub fn new(channels: Channels<'a>, options: &Options) -> Result<Self, SmoothError> {
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
            // What stands in the place of wild samples was not read, and hides the steps of what was.
            let each = values.iter().enumerate();
            let read = each.filter(|(k, _)| channels.is_measured(i, *k));
            let read: Vec<f64> = read.map(|(_, value)| *value).collect();
            let rounding = quantisation_step(&read).unwrap_or(0.0) / 12_f64.sqrt();
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
            shortest_response: options.shortest_response.unwrap_or(1e-3 * step),
        })
    }

    /// Hyper-parameters from the search variables: logarithms of the noise
    /// levels of the channels there are, then `ln(density)/2N`.
    fn hyper<const N: usize>(&self, x: &[f64]) -> Hyper {
        let density = x.last().map_or(1.0, |log| (2.0 * N as f64 * log).exp());
        Hyper {
            density,
            sd: self.noise_levels(x),
            prior_sd: self.prior_sd,
        }
    }

    /// Noise levels of the channels there are, from their logarithms.
    pub(super) fn noise_levels(&self, logs: &[f64]) -> [Option<f64>; 3] {
        let mut logs = logs.iter();
        self.start
            .map(|start| start.and_then(|_| logs.next().map(|log| log.exp())))
    }

    pub(super) fn is_within_bounds(&self, sds: &[Option<f64>; 3]) -> bool {
        let bounds = self.floor.iter().zip(&self.ceiling);
        let mut each = sds.iter().zip(bounds);
        each.all(|(sd, (floor, ceiling))| sd.is_none_or(|sd| (*floor..=*ceiling).contains(&sd)))
    }

    /// Negative log-likelihood; infinite outside the bounds.
    fn cost<const N: usize>(&self, x: &[f64]) -> f64 {
        let hyper = self.hyper::<N>(x);
        if !self.is_within_bounds(&hyper.sd) {
            return f64::INFINITY;
        }
        let longest = self.shortest_response.max(10.0 * self.duration);
        let response = hyper.response(N, self.step);
        if !(self.shortest_response..=longest).contains(&response) {
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

    /// The most likely order and its hyper-parameters; where noise hides behind the motion's
    /// wildest stretches, that of its calm ones.
    pub fn fit(&self) -> Result<Fit, SmoothError> {
        let fit = self.fit_at_once()?;
        match self.is_unseen(&fit) {
            true => Ok(self.fit_in_blocks().unwrap_or(fit)),
            false => Ok(fit),
        }
    }

    /// With one intensity for all of the motion.
    ///
    /// All are searched for order 4; with its noise levels kept, the intensity
    /// is searched for orders 3 and 5, and if one of them is more likely, all
    /// are searched again for that one.
    fn fit_at_once(&self) -> Result<Fit, SmoothError> {
        let logs: Vec<f64> = self.start.iter().flatten().map(|sd| sd.ln()).collect();
        let start = self
            .with_intensity::<4>(&logs)
            .ok_or_else(|| self.hopeless())?;
        let fourth = self.all::<4>(start)?;
        let sds = fourth.hyper.sd.iter().flatten();
        let logs: Vec<f64> = sds.map(|sd| sd.ln()).collect();
        let (third, fifth) = rayon::join(
            || self.with_intensity::<3>(&logs),
            || self.with_intensity::<5>(&logs),
        );
        let third = third.map(|x| (self.cost::<3>(&x), x));
        let fifth = fifth.map(|x| (self.cost::<5>(&x), x));
        let cost = |found: &Option<(f64, Vec<f64>)>| found.as_ref().map_or(f64::INFINITY, |f| f.0);
        let other = if cost(&third) < cost(&fifth) {
            third.map(|(cost, x)| (cost, x, 3))
        } else {
            fifth.map(|(cost, x)| (cost, x, 5))
        };
        match other {
            Some((cost, x, 3)) if -cost > fourth.log_likelihood => self.all::<3>(x),
            Some((cost, x, _)) if -cost > fourth.log_likelihood => self.all::<5>(x),
            _ => Ok(fourth),
        }
    }

    fn hopeless(&self) -> SmoothError {
        SmoothError::NoLikelihood {
            range: range_of(self.channels.q),
        }
    }

    /// Maximum-likelihood hyper-parameters of order N near a start.
    fn all<const N: usize>(&self, start: Vec<f64>) -> Result<Fit, SmoothError> {
        let (x, _) = self.search::<N>(&[], start, 0.4);
        // A second simplex guards against a first one that collapsed.
        let (x, converged) = self.search::<N>(&[], x, 0.1);
        let cost = self.cost::<N>(&x);
        if !cost.is_finite() {
            return Err(self.hopeless());
        }
        Ok(Fit {
            order: N,
            hyper: self.hyper::<N>(&x),
            log_likelihood: -cost,
            converged,
        })
    }

    /// The given noise levels with their most likely intensity: the best of a
    /// grid of response times, refined.
    fn with_intensity<const N: usize>(&self, logs: &[f64]) -> Option<Vec<f64>> {
        let sd_q = logs.first()?.exp();
        let candidates = RESPONSES.map(|steps| {
            let response = (steps * self.step).max(1.01 * self.shortest_response);
            let density = sd_q * sd_q * self.step / response.powi(2 * N as i32);
            let x = density.ln() / (2.0 * N as f64);
            (self.cost::<N>(&[logs, &[x]].concat()), x)
        });
        let finite = candidates.into_iter().filter(|(cost, _)| cost.is_finite());
        let (_, best) = finite.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (x, _) = self.search::<N>(logs, vec![best], 0.3);
        Some([logs, &x].concat())
    }

    /// The given noise levels with the most likely intensity of order N.
    pub(super) fn with_noise<const N: usize>(&self, logs: &[f64]) -> Option<Fit> {
        let x = self.with_intensity::<N>(logs)?;
        Some(Fit {
            order: N,
            hyper: self.hyper::<N>(&x),
            log_likelihood: -self.cost::<N>(&x),
            converged: true,
        })
    }

    /// Nelder–Mead over the variables that follow `fixed`; also whether it
    /// converged.
    fn search<const N: usize>(
        &self,
        fixed: &[f64],
        start: Vec<f64>,
        size: f64,
    ) -> (Vec<f64>, bool) {
        let cost = |x: &[f64]| self.cost::<N>(&[fixed, x].concat());
        Self::minimum(&cost, start, size)
    }

    /// Nelder–Mead from a simplex of some size; also whether it converged.
    pub(super) fn minimum(
        cost: &dyn Fn(&[f64]) -> f64,
        start: Vec<f64>,
        size: f64,
    ) -> (Vec<f64>, bool) {
        let mut vertices = vec![start.clone()];
        for i in 0..start.len() {
            let mut vertex = start.clone();
            vertex[i] += size;
            vertices.push(vertex);
        }
        // Variables are logarithms: 2e-3 is a fifth of a percent, well within
        // the standard error at any length of log.
        let solver = NelderMead::new()
            .with_absolute_simplex_size_tolerance(2e-3)
            .with_absolute_simplex_cost_tolerance(1e-2);
        let state = basin::SimplexProgress::from_simplex(vertices);
        let objective = Objective { cost };
        let result = Executor::new(objective, solver, state)
            .max_iter(ITERATIONS)
            .run();
        match result {
            Ok(result) => (result.best_param().clone(), result.iter() < ITERATIONS),
            Err(never) => match never {},
        }
    }
}

/// The cost as the optimiser sees it.
struct Objective<'a> {
    cost: &'a dyn Fn(&[f64]) -> f64,
}

impl CostFunction for Objective<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Infallible;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, Infallible> {
        Ok((self.cost)(x))
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
/// smooth motion leaves little in them, and noise all of itself. Nothing where most of them are nothing.
pub(crate) fn high_frequency(values: &[f64]) -> f64 {
    let fifth: Vec<f64> = values
        .windows(6)
        .map(|v| (v[5] - v[0]) - 5.0 * (v[4] - v[1]) + 10.0 * (v[3] - v[2]))
        .collect();
    mad_sd(&fifth).unwrap_or(0.0) / 252_f64.sqrt()
}

/// Weak knowledge of the first state: three times the largest value, velocity,
/// acceleration, jerk and snap that a local polynomial sees anywhere. Samples
/// are taken as evenly spaced: only the order of magnitude matters.
fn prior(channels: &Channels, step: f64, segments: &[Range<usize>]) -> [f64; HIGHEST] {
    let filter = SavitzkyGolay::reference(step);
    let even: Vec<f64> = (0..channels.t.len()).map(|k| k as f64 * step).collect();
    let largest = |values: &[f64], derivative: usize| -> f64 {
        let parts = segments.iter().map(|range| {
            let part = filter.apply(&even[range.clone()], &values[range.clone()], derivative);
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
    let (jerk, snap) = (largest(channels.q, 3), largest(channels.q, 4));
    // A coordinate that never moves still needs positive variances.
    let least = 1e-6 * position;
    [position, velocity, acceleration, jerk, snap].map(|scale| 3.0 * scale.max(least))
}

/// All samples of a log of moderate length; else evenly placed blocks.
fn training(t: &[f64], step: f64, segments: &[Range<usize>]) -> Vec<Range<usize>> {
    let regular = |pair: &&[f64]| (pair[1] - pair[0] - step).abs() <= 0.01 * step;
    let irregular = t.len() - 1 - t.windows(2).filter(regular).count();
    let most = if 50 * irregular < t.len() {
        REGULAR_SAMPLES
    } else {
        IRREGULAR_SAMPLES
    };
    if t.len() <= most {
        return segments.to_vec();
    }
    let mut ranges = Vec::new();
    for segment in segments {
        let share = segment.len() * most / t.len();
        let blocks = (share * BLOCKS / most).max(1);
        for b in 0..blocks {
            let start = segment.start + b * segment.len() / blocks;
            ranges.push(start..start + share / blocks);
        }
    }
    ranges.retain(|range| !range.is_empty());
    ranges
}
