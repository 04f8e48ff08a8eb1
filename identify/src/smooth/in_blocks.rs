//! Noise levels where motion is fast at times.
//!
//! One intensity for all of the motion is that of its wildest stretches. Where these change
//! from sample to sample by more than the noise, the likelihood no longer sees the noise
//! anywhere. With an intensity for each block the calm ones tell it.

use super::fit::{Fit, RESPONSES, Task};
use super::wiener::{HIGHEST, Hyper, Wiener};
use rayon::prelude::*;
use std::ops::Range;

/// Samples in a block, and blocks at most.
const LENGTH: usize = 64;
const MOST: usize = 48;
/// Response times below this many steps leave nothing to the noise.
const UNSEEN: f64 = 1.0;
/// Response times tried in each block beside [`RESPONSES`], in median steps.
const FASTER: [f64; 3] = [0.06, 0.12, 0.25];

impl Task<'_> {
    /// Whether some channel's noise, as likely as `fit` has it, hides behind the motion.
    pub(super) fn is_unseen(&self, fit: &Fit) -> bool {
        let responses = fit.hyper.responses(fit.order, self.step);
        responses
            .iter()
            .any(|response| *response < UNSEEN * self.step)
    }

    /// The noise that is most likely where each block moves in its own way; with it the order
    /// and the intensity that are most likely for all of the log.
    pub(super) fn fit_in_blocks(&self) -> Option<Fit> {
        let blocks = self.blocks();
        let start = self.start.iter().flatten().map(|sd| sd.ln()).collect();
        let cost = |logs: &[f64]| self.cost_in_blocks(&blocks, logs);
        let (logs, converged) = Self::minimum(&cost, start, 0.7);
        let of_order = [
            self.with_noise::<3>(&logs),
            self.with_noise::<4>(&logs),
            self.with_noise::<5>(&logs),
        ];
        let fits = of_order.into_iter().flatten();
        let best = fits.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
        Some(Fit { converged, ..best })
    }

    /// Stretches without gaps, evenly over the log.
    fn blocks(&self) -> Vec<Range<usize>> {
        let whole = self.training.iter().flat_map(|range| {
            let starts = (range.start..range.end).step_by(LENGTH);
            starts.map(|start| start..(start + LENGTH).min(range.end))
        });
        let all: Vec<Range<usize>> = whole.filter(|block| block.len() > 2 * HIGHEST).collect();
        let count = all.len().min(MOST);
        (0..count)
            .map(|i| all[i * all.len() / count].clone())
            .collect()
    }

    /// Negative log-likelihood of the blocks under noise levels, each with its own intensity;
    /// infinite outside the bounds.
    fn cost_in_blocks(&self, blocks: &[Range<usize>], logs: &[f64]) -> f64 {
        let sd = self.noise_levels(logs);
        if !self.is_within_bounds(&sd) {
            return f64::INFINITY;
        }
        let sd_q = sd[0].unwrap_or(1.0);
        let models = FASTER.iter().chain(&RESPONSES).map(|steps| {
            let response = (steps * self.step).max(self.shortest_response);
            let hyper = Hyper {
                density: sd_q * sd_q * self.step / response.powi(2 * HIGHEST as i32),
                sd,
                prior_sd: self.prior_sd,
            };
            Wiener::<HIGHEST>::new(&hyper, self.step, self.duration)
        });
        let models: Vec<Wiener<HIGHEST>> = models.collect();
        let cost = |block: &Range<usize>| {
            let costs = models
                .iter()
                .map(|model| -model.log_likelihood(&self.channels, block.clone(), self.step));
            costs.fold(f64::INFINITY, f64::min)
        };
        // In the order of the blocks: sums are the same on any number of cores.
        let costs: Vec<f64> = blocks.par_iter().map(cost).collect();
        costs.iter().sum()
    }
}
