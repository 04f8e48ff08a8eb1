//! Kinematic state estimation: position, velocity and acceleration with their
//! uncertainty from noisy, perhaps irregular, measurements.
//!
//! Each coordinate is smoothed on its own. Its motion is a process whose third,
//! fourth or fifth derivative is white noise,
//!
//! `dᴺq/dtᴺ = w(t)`, N = 3, 4 or 5,
//!
//! and every logged channel — `q`, and `dq`, `ddq` where there are — measures
//! its derivative with white noise of its own. The noise levels, the intensity
//! of `w` and the order N maximise the likelihood of the log; a fixed-interval
//! Kalman smoother then gives the posterior, exact at irregular times, in time
//! proportional to the number of samples. The posterior mean is the smoothing
//! spline of degree 2N-1 (G. Wahba, *J. R. Stat. Soc. B* 40, 1978), so between
//! samples it is a polynomial: see [`Smoothed::between`].
//!
//! [`savgol_states`] is the other pipeline, by which acceleration errors are
//! reported.
//!
//! ```
//! use identify::smooth::{Channels, Smoother};
//!
//! let t: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
//! // A slow sine through an encoder with steps of 1 mrad.
//! let q: Vec<f64> = t.iter().map(|t| ((2.0 * t).sin() * 1e3).round() / 1e3).collect();
//! let channels = Channels::new(&t, &q, None, None)?;
//! let smoothed = Smoother::fit(&channels)?.apply(&channels)?;
//! assert!((smoothed.v[200] - 2.0 * (2.0 * t[200]).cos()).abs() < 0.01);
//! assert!(smoothed.sd_v[200] < 0.01);
//! # Ok::<(), identify::smooth::SmoothError>(())
//! ```

mod backward;
mod channels;
mod error;
mod filter;
mod fit;
mod hermite;
mod in_blocks;
mod savitzky_golay;
mod smoothed;
mod smoother;
mod wiener;

pub use channels::Channels;
pub use error::SmoothError;
pub use hermite::State;
pub use savitzky_golay::{SavitzkyGolay, SgStates, savgol_states};
pub use smoothed::{ChannelNoise, Innovations, Midpoint, Smoothed};
pub use smoother::{Options, Smoother};

pub(crate) use fit::high_frequency;

use crate::log::Record;
use rayon::prelude::*;

/// Fits and smooths every coordinate of a record, in parallel, with default
/// [`Options`].
///
/// # Errors
///
/// The first [`SmoothError`] of any coordinate.
pub fn smooth(record: &Record) -> Result<Vec<Smoothed>, SmoothError> {
    let coordinates = 0..record.q.len();
    coordinates
        .into_par_iter()
        .map(|i| smooth_one(record, i))
        .collect()
}

/// The same of the coordinates that a column of the log shows; `None` for the others.
///
/// # Errors
///
/// As [`smooth`].
pub fn smooth_measured(record: &Record) -> Result<Vec<Option<Smoothed>>, SmoothError> {
    let coordinates = 0..record.q.len();
    let measured = |i: usize| record.is_measured(i).then(|| smooth_one(record, i));
    coordinates
        .into_par_iter()
        .map(|i| measured(i).transpose())
        .collect()
}

fn smooth_one(record: &Record, i: usize) -> Result<Smoothed, SmoothError> {
    let of = |error: SmoothError| error.of(&record.coordinates[i]);
    let channels = Channels::of(record, i).map_err(of)?;
    let smoother = Smoother::fit(&channels).map_err(of)?;
    smoother.apply(&channels).map_err(of)
}

#[cfg(test)]
mod tests;
