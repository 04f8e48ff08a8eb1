//! The measurements of one coordinate.

use super::SmoothError;
use crate::log::{Record, is_aside};

/// Names of the channels in messages, by the derivative they measure.
pub(super) const NAMES: [&str; 3] = ["q", "dq", "ddq"];

/// The measurements of one coordinate: position, and where logged velocity and
/// acceleration. Same length, finite, at strictly increasing times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channels<'a> {
    /// Time stamps \[s\] (n).
    pub t: &'a [f64],
    /// Positions (n).
    pub q: &'a [f64],
    /// Velocities (n).
    pub dq: Option<&'a [f64]>,
    /// Accelerations (n).
    pub ddq: Option<&'a [f64]>,
    /// Samples of each that are no measurements, as [`Aside::of`](crate::log::Aside::of) has them.
    pub aside: [&'a [bool]; 3],
}

impl<'a> Channels<'a> {
    /// Checks and bundles the channels.
    ///
    /// # Errors
    ///
    /// [`SmoothError::Length`], [`SmoothError::NotFinite`] or
    /// [`SmoothError::Disordered`] with the first place.
    pub fn new(
        t: &'a [f64],
        q: &'a [f64],
        dq: Option<&'a [f64]>,
        ddq: Option<&'a [f64]>,
    ) -> Result<Self, SmoothError> {
        let aside = [&[][..]; 3];
        let channels = Channels {
            t,
            q,
            dq,
            ddq,
            aside,
        };
        let named = [("t", Some(t)), ("q", Some(q)), ("dq", dq), ("ddq", ddq)];
        for (channel, values) in named {
            let values = values.unwrap_or(t);
            if values.len() != t.len() {
                return Err(SmoothError::Length {
                    channel,
                    found: values.len(),
                    expected: t.len(),
                });
            }
            if let Some(sample) = values.iter().position(|value| !value.is_finite()) {
                return Err(SmoothError::NotFinite { channel, sample });
            }
        }
        match t.windows(2).position(|pair| pair[1] <= pair[0]) {
            Some(k) => Err(SmoothError::Disordered { sample: k + 1 }),
            None => Ok(channels),
        }
    }

    /// The channels of coordinate `i` (counted from 0) of a record.
    ///
    /// # Errors
    ///
    /// As [`Channels::new`], or [`SmoothError::NoCoordinate`].
    pub fn of(record: &'a Record, i: usize) -> Result<Self, SmoothError> {
        let Some(q) = record.q.get(i) else {
            return Err(SmoothError::NoCoordinate {
                index: i,
                coordinates: record.q.len(),
            });
        };
        let optional = |channels: &'a [Option<Vec<f64>>]| channels.get(i)?.as_deref();
        let channels = Channels::new(&record.t, q, optional(&record.dq), optional(&record.ddq))?;
        Ok(Channels {
            aside: record.aside.of(i),
            ..channels
        })
    }

    /// Whether the `i`-th derivative was measured at sample `k`.
    pub(super) fn is_measured(&self, i: usize, k: usize) -> bool {
        !is_aside(self.aside[i], k)
    }

    /// The channel that measures the `i`-th derivative.
    pub(super) fn derivative(&self, i: usize) -> Option<&'a [f64]> {
        [Some(self.q), self.dq, self.ddq].get(i).copied().flatten()
    }
}
