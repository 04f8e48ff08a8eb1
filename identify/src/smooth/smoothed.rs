//! Estimated states, and how well the model predicted the log.

use super::filter::Step;
use super::hermite::{State, between};
use super::smoother::Smoother;
use crate::log::median;
use serde::Serialize;
use std::ops::Range;

/// Standard deviations of the measurement noise of each channel, quantisation
/// included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChannelNoise {
    /// Of the position.
    pub sd_q: f64,
    /// Of the velocity, where measured.
    pub sd_dq: Option<f64>,
    /// Of the acceleration, where measured.
    pub sd_ddq: Option<f64>,
}

/// States of one coordinate given all its samples (n each).
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// Time stamps \[s\].
    pub t: Vec<f64>,
    /// Posterior mean of the position.
    pub q: Vec<f64>,
    /// Posterior mean of the velocity.
    pub v: Vec<f64>,
    /// Posterior mean of the acceleration.
    pub a: Vec<f64>,
    /// Posterior standard deviation of the position.
    pub sd_q: Vec<f64>,
    /// Posterior standard deviation of the velocity.
    pub sd_v: Vec<f64>,
    /// Posterior standard deviation of the acceleration.
    pub sd_a: Vec<f64>,
    /// Noise levels used.
    pub noise: ChannelNoise,
    /// The smoother used.
    pub smoother: Smoother,
    /// Ranges of samples between gaps, smoothed apart.
    pub segments: Vec<Range<usize>>,
    /// How well the model predicts each channel.
    pub innovations: Vec<Innovations>,
    /// Posterior means of jerk and snap, zero where the order has none.
    pub(super) higher: Vec<[f64; 2]>,
}

/// The state half-way between two samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Midpoint {
    /// Index k of the sample before.
    pub after: usize,
    /// Time `t_k + h/2` \[s\].
    pub t: f64,
    /// Step `h` to the next sample \[s\].
    pub h: f64,
    /// Posterior mean of the state.
    pub state: State,
}

impl Smoothed {
    pub(super) fn empty(smoother: &Smoother, t: &[f64], n: usize) -> Self {
        let room = || Vec::with_capacity(n);
        Smoothed {
            t: t.to_vec(),
            q: room(),
            v: room(),
            a: room(),
            sd_q: room(),
            sd_v: room(),
            sd_a: room(),
            noise: smoother.noise(),
            smoother: *smoother,
            segments: Vec::new(),
            innovations: Vec::new(),
            higher: Vec::with_capacity(n),
        }
    }

    /// The posterior mean at `s` in \[0, 1\] of the way from sample `k` to
    /// `k + 1`: given the states at both ends, the model's mean is the
    /// polynomial of degree 2N-1 through them, and by the Markov property this
    /// is the mean given the whole log.
    ///
    /// `None` when a gap lies between the two, or there is no sample `k + 1`.
    pub fn between(&self, k: usize, s: f64) -> Option<State> {
        if !self
            .segments
            .iter()
            .any(|range| range.contains(&k) && range.contains(&(k + 1)))
        {
            return None;
        }
        Some(self.interpolate(k, s))
    }

    /// The states half-way between all neighbouring samples; steps across a
    /// gap are left out.
    pub fn midpoints(&self) -> Vec<Midpoint> {
        let pairs = self.segments.iter().flat_map(|range| {
            let last = range.end.saturating_sub(1);
            range.start..last
        });
        pairs
            .map(|k| {
                let h = self.t[k + 1] - self.t[k];
                Midpoint {
                    after: k,
                    t: self.t[k] + 0.5 * h,
                    h,
                    state: self.interpolate(k, 0.5),
                }
            })
            .collect()
    }

    /// Both samples must be in one segment.
    fn interpolate(&self, k: usize, s: f64) -> State {
        let at = |k: usize| {
            let [jerk, snap] = self.higher[k];
            [self.q[k], self.v[k], self.a[k], jerk, snap]
        };
        let h = self.t[k + 1] - self.t[k];
        between(&at(k), &at(k + 1), self.smoother.order, h, s)
    }
}

/// One-step prediction errors of a channel, each divided by its predicted
/// standard deviation: white with variance one when the model is right.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Innovations {
    /// The channel: `q`, `dq` or `ddq`.
    pub channel: &'static str,
    /// Mean; away from zero for a biased channel.
    pub mean: f64,
    /// Mean square.
    pub variance: f64,
    /// Correlation of neighbours: the median over stretches of the log, so that one violent
    /// moment does not speak for all of it.
    pub lag_1: f64,
}

/// Innovations in a stretch over which a correlation is taken: enough to know it to 0.1.
const STRETCH: usize = 100;

/// Sums over normalised innovations.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub(super) count: f64,
    sum: f64,
    square: f64,
    /// Correlations of neighbours, one of each stretch.
    correlations: Vec<f64>,
}

impl Tally {
    pub(super) fn summary(&self, channel: &'static str) -> Innovations {
        Innovations {
            channel,
            mean: self.sum / self.count,
            variance: self.square / self.count,
            lag_1: median(&self.correlations).unwrap_or(0.0),
        }
    }

    fn add(&mut self, normalised: &[f64]) {
        let square = |z: &[f64]| z.iter().map(|z| z * z).sum::<f64>();
        self.count += normalised.len() as f64;
        self.sum += normalised.iter().sum::<f64>();
        self.square += square(normalised);
        let stretches = (normalised.len() / STRETCH).max(1);
        let stretches = normalised.chunks(normalised.len().div_ceil(stretches).max(1));
        let correlation = |z: &[f64]| {
            let neighbours: f64 = z.windows(2).map(|pair| pair[0] * pair[1]).sum();
            let square = square(z);
            (square > 0.0).then(|| neighbours / square)
        };
        self.correlations.extend(stretches.filter_map(correlation));
    }
}

/// Adds a stretch, without the samples in which the filter settles.
pub(super) fn tally<const N: usize>(steps: &[Step<N>], tallies: &mut [Tally; 3]) {
    for (i, tally) in tallies.iter_mut().enumerate() {
        let updates = steps.iter().skip(2 * N).filter_map(|step| step.updates[i]);
        let normalised: Vec<f64> = updates
            .map(|update| update.innovation / update.variance.sqrt())
            .collect();
        tally.add(&normalised);
    }
}
