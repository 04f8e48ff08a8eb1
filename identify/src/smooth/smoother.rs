//! The smoother of one coordinate and its result.

use super::channels::NAMES;
use super::fit::Task;
use super::smoothed::{ChannelNoise, Smoothed, Tally, tally};
use super::wiener::{Hyper, Wiener};
use super::{Channels, SmoothError};
use crate::log::{median_step, segments};

/// How the motion is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Shortest response time of the filter \[s\], `None` for no limit. What
    /// is faster counts as noise. By default the likelihood decides, which
    /// takes errors that are not white — the ripple of an encoder or a gear —
    /// for motion where they stand out of the white noise.
    pub shortest_response: Option<f64>,
}

/// A smoother with its hyper-parameters: fitted once, applied to any log of
/// the same machine, or many times to perturbed copies of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoother {
    /// Order N of the motion model: 3 (white jerk), 4 (white snap) or 5.
    pub order: usize,
    /// Log-likelihood of the log it was fitted on \[nats\].
    pub log_likelihood: f64,
    /// Whether the search for the hyper-parameters converged.
    pub converged: bool,
    hyper: Hyper,
}

impl Smoother {
    /// Estimates noise levels, intensity and order from one coordinate's log,
    /// with default [`Options`].
    ///
    /// # Errors
    ///
    /// [`SmoothError::TooShort`] below 20 samples, [`SmoothError::NoLikelihood`]
    /// when no hyper-parameters explain the data.
    pub fn fit(channels: &Channels) -> Result<Self, SmoothError> {
        Self::fit_with(channels, &Options::default())
    }

    /// As [`Smoother::fit`], with options.
    ///
    /// # Errors
    ///
    /// As [`Smoother::fit`].
    pub fn fit_with(channels: &Channels, options: &Options) -> Result<Self, SmoothError> {
        let fit = Task::new(*channels, options)?.fit()?;
        Ok(Smoother {
            order: fit.order,
            log_likelihood: fit.log_likelihood,
            converged: fit.converged,
            hyper: fit.hyper,
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
        let (Some(first), Some(last)) = (channels.t.first(), channels.t.last()) else {
            return Err(SmoothError::TooShort {
                found: 0,
                minimum: 1,
            });
        };
        let duration = last - first;
        Ok(match self.order {
            3 => self.run::<3>(channels, duration),
            4 => self.run::<4>(channels, duration),
            _ => self.run::<5>(channels, duration),
        })
    }

    /// Response time of the filter on positions `step` seconds apart \[s\]:
    /// motion that changes faster than this is smoothed away.
    pub fn response(&self, step: f64) -> f64 {
        self.hyper.response(self.order, step)
    }

    fn run<const N: usize>(&self, channels: &Channels, duration: f64) -> Smoothed {
        let step = median_step(channels.t).max(f64::MIN_POSITIVE);
        let model = Wiener::<N>::new(&self.hyper, step, duration);
        let n = channels.t.len();
        let mut out = Smoothed::empty(self, channels.t, n);
        let mut innovations: [Tally; 3] = Default::default();
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
                out.higher
                    .push([3, 4].map(|k| if k < N { mean(k) } else { 0.0 }));
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
