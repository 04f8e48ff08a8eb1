//! The smoother of one coordinate and its result.

use super::channels::NAMES;
use super::filter::Step;
use super::fit::{Fit, Task};
use super::hermite::{State, between};
use super::wiener::{Hyper, Wiener};
use super::{Channels, SmoothError};
use crate::log::{median_step, segments};
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

/// A smoother with its hyper-parameters: fitted once, applied to any log of
/// the same machine, or many times to perturbed copies of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoother {
    /// Order N of the motion model: 3 (white jerk) or 4 (white snap).
    pub order: usize,
    /// Log-likelihood of the log it was fitted on \[nats\].
    pub log_likelihood: f64,
    /// Whether the search for the hyper-parameters converged.
    pub converged: bool,
    hyper: Hyper,
}

impl Smoother {
    /// Estimates noise levels, intensity and order from one coordinate's log.
    ///
    /// # Errors
    ///
    /// [`SmoothError::TooShort`] below 20 samples, [`SmoothError::NoLikelihood`]
    /// when no hyper-parameters explain the data.
    pub fn fit(channels: &Channels) -> Result<Self, SmoothError> {
        let task = Task::new(*channels)?;
        let (third, fourth) = rayon::join(|| task.fit::<3>(), || task.fit::<4>());
        let (third, fourth) = (third?, fourth?);
        let best = |order: usize, fit: Fit| Smoother {
            order,
            log_likelihood: fit.log_likelihood,
            converged: fit.converged,
            hyper: fit.hyper,
        };
        Ok(if fourth.log_likelihood > third.log_likelihood {
            best(4, fourth)
        } else {
            best(3, third)
        })
    }

    /// The noise levels of the channels.
    pub fn noise(&self) -> ChannelNoise {
        ChannelNoise {
            // A fitted smoother always has a position channel.
            sd_q: self.hyper.sd[0].unwrap_or(0.0),
            sd_dq: self.hyper.sd[1],
            sd_ddq: self.hyper.sd[2],
        }
    }

    /// Intensity of the white noise that drives the N-th derivative
    /// \[unit²/s^(2N-1)\].
    pub fn density(&self) -> f64 {
        self.hyper.density
    }

    /// The posterior of position, velocity and acceleration at every sample.
    ///
    /// # Errors
    ///
    /// [`SmoothError::UnknownNoise`] when a channel is given whose noise the
    /// smoother was not fitted on; [`SmoothError::TooShort`] for no sample.
    pub fn apply(&self, channels: &Channels) -> Result<Smoothed, SmoothError> {
        for (i, channel) in NAMES.into_iter().enumerate() {
            if channels.derivative(i).is_some() && self.hyper.sd[i].is_none() {
                return Err(SmoothError::UnknownNoise { channel });
            }
        }
        match (channels.t.first(), channels.t.last()) {
            (Some(first), Some(last)) if self.order == 3 => {
                Ok(self.run::<3>(channels, last - first))
            }
            (Some(first), Some(last)) => Ok(self.run::<4>(channels, last - first)),
            _ => Err(SmoothError::TooShort {
                found: 0,
                minimum: 1,
            }),
        }
    }

    fn run<const N: usize>(&self, channels: &Channels, duration: f64) -> Smoothed {
        let step = median_step(channels.t).max(f64::MIN_POSITIVE);
        let model = Wiener::<N>::new(&self.hyper, step, duration);
        let n = channels.t.len();
        let mut out = Smoothed::empty(self, channels.t, n);
        let mut innovations = [Tally::default(); 3];
        for range in segments(channels.t) {
            let steps = model.filter(channels, range.clone());
            for posterior in model.backward(&steps, &channels.t[range.clone()]) {
                let mean = |k: usize| posterior.mean[k] * model.si(k);
                let sd = |k: usize| posterior.variance[k].sqrt() * model.si(k);
                out.q.push(mean(0));
                out.v.push(mean(1));
                out.a.push(mean(2));
                out.sd_q.push(sd(0));
                out.sd_v.push(sd(1));
                out.sd_a.push(sd(2));
                if N > 3 {
                    out.jerk.push(mean(3));
                }
            }
            tally(&steps, &mut innovations);
            out.segments.push(range);
        }
        let counted = NAMES.into_iter().zip(innovations);
        out.innovations = counted
            .filter(|(_, tally)| tally.count > 0.0)
            .map(|(channel, tally)| tally.summary(channel))
            .collect();
        out
    }
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
    /// Posterior mean of the jerk; empty when the order is 3.
    jerk: Vec<f64>,
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
    fn empty(smoother: &Smoother, t: &[f64], n: usize) -> Self {
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
            jerk: Vec::new(),
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
            [
                self.q[k],
                self.v[k],
                self.a[k],
                self.jerk.get(k).copied().unwrap_or(0.0),
            ]
        };
        let length = if self.jerk.is_empty() { 3 } else { 4 };
        let (start, end) = (at(k), at(k + 1));
        between(
            &start[..length],
            &end[..length],
            self.t[k + 1] - self.t[k],
            s,
        )
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
    /// Correlation of neighbours.
    pub lag_1: f64,
}

/// Sums over normalised innovations.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    count: f64,
    sum: f64,
    square: f64,
    product: f64,
}

impl Tally {
    fn summary(&self, channel: &'static str) -> Innovations {
        Innovations {
            channel,
            mean: self.sum / self.count,
            variance: self.square / self.count,
            lag_1: if self.square > 0.0 {
                self.product / self.square
            } else {
                0.0
            },
        }
    }
}

/// Adds a stretch, without the samples in which the filter settles.
fn tally<const N: usize>(steps: &[Step<N>], tallies: &mut [Tally; 3]) {
    for (i, tally) in tallies.iter_mut().enumerate() {
        let mut before: Option<f64> = None;
        for update in steps.iter().skip(2 * N).filter_map(|step| step.updates[i]) {
            let z = update.innovation / update.variance.sqrt();
            tally.count += 1.0;
            tally.sum += z;
            tally.square += z * z;
            tally.product += before.map_or(0.0, |before| before * z);
            before = Some(z);
        }
    }
}
