//! Choosing and scaling data.

use crate::error::{GpError, Result, finite, shape};
use crate::inputs::Inputs;
use crate::posterior::Prediction;
use crate::simd::dispatch;
use faer::Mat;
use serde::{Deserialize, Serialize};

/// Indices of `count` points spread over the data: greedy farthest point
/// sampling (Gonzalez 1985) in Euclidean distance, beginning with `first`.
///
/// Standardise the inputs before. Ends early, with fewer points, once every
/// remaining point coincides with a chosen one. Errors: `first` out of range,
/// `count = 0`.
///
/// ```
/// let x = gp::Inputs::from_rows(&[[0.0], [0.1], [1.0], [0.5], [0.0]])?;
/// assert_eq!(gp::farthest_points(&x, 3, 0)?, vec![0, 2, 3]);
/// assert_eq!(gp::farthest_points(&x, 9, 0)?.len(), 4); // 0 and 4 coincide
/// # Ok::<(), gp::GpError>(())
/// ```
pub fn farthest_points(x: &Inputs, count: usize, first: usize) -> Result<Vec<usize>> {
    if first >= x.len() || count == 0 {
        return Err(shape(
            "farthest point sampling",
            format!("a first point below {} and at least one point", x.len()),
            format!("first point {first}, {count} points"),
        ));
    }
    let mut chosen = vec![first];
    let mut nearest = vec![f64::INFINITY; x.len()];
    let mut distance = vec![0.0; x.len()];
    while chosen.len() < count.min(x.len()) {
        let last = chosen[chosen.len() - 1];
        dispatch(|| {
            distance.fill(0.0);
            for d in 0..x.dims() {
                let column = x.dim(d);
                let c = column[last];
                for (s, v) in distance.iter_mut().zip(column) {
                    *s += (v - c) * (v - c);
                }
            }
            for (n, s) in nearest.iter_mut().zip(&distance) {
                *n = if *s < *n { *s } else { *n };
            }
        });
        let (mut next, mut far) = (last, 0.0);
        for (i, &d) in nearest.iter().enumerate() {
            if d > far {
                (next, far) = (i, d);
            }
        }
        if far == 0.0 {
            break;
        }
        chosen.push(next);
    }
    Ok(chosen)
}

/// Shift and scale per coordinate or channel: `normalised = (raw - shift)/scale`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// Subtracted first; unit of the data.
    pub shift: Vec<f64>,
    /// Divided by afterwards; unit of the data, positive.
    pub scale: Vec<f64>,
}

/// More channels than any machine has; a larger number is a mistake of the caller.
const MOST_CHANNELS: usize = 1 << 16;

fn moments(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let sd = (values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt();
    // A constant column carries no scale of its own.
    (mean, if sd > 1e-12 * mean.abs() { sd } else { 1.0 })
}

impl Scaling {
    /// Mean and standard deviation (divisor `N`) of every coordinate; a
    /// constant coordinate gets scale 1. Errors: no points.
    pub fn of_inputs(x: &Inputs) -> Result<Self> {
        if x.is_empty() {
            return Err(shape("points to normalise by", "at least 1", 0));
        }
        let (shift, scale) = (0..x.dims())
            .map(|d| moments(x.dim(d).iter().copied()))
            .unzip();
        Self { shift, scale }.computed()
    }

    /// Mean and standard deviation of every channel of the measurements `y`,
    /// `channels` naming the channel of each row.
    pub fn of_outputs(y: &[f64], channels: &[usize]) -> Result<Self> {
        if y.is_empty() || y.len() != channels.len() {
            return Err(shape(
                "measurements to normalise by",
                format!("{} (their channels), at least 1", channels.len()),
                y.len(),
            ));
        }
        finite("measurements y", y)?;
        let count = channels.iter().max().map_or(0, |c| c.saturating_add(1));
        if count > MOST_CHANNELS {
            let expected = format!("at most {MOST_CHANNELS}, numbered from 0");
            return Err(shape("channels", expected, count));
        }
        let (shift, scale) = (0..count)
            .map(|c| {
                moments(
                    y.iter()
                        .zip(channels)
                        .filter(move |(_, k)| **k == c)
                        .map(|(v, _)| *v),
                )
            })
            .unzip();
        Self { shift, scale }.computed()
    }

    /// Fails when the data were so large that their moments overflowed.
    fn computed(self) -> Result<Self> {
        finite("mean of the data", &self.shift)?;
        finite("standard deviation of the data", &self.scale)?;
        Ok(self)
    }

    fn check(&self, channels: &[usize], rows: usize) -> Result<()> {
        if channels.len() != rows {
            return Err(shape("channels of the rows", rows, channels.len()));
        }
        let known = self.scale.len().min(self.shift.len());
        if let Some(c) = channels.iter().find(|&&c| c >= known) {
            return Err(shape("channel of a row", format!("below {known}"), c));
        }
        self.usable()
    }

    /// The fields are public: what was put there is checked before it is used.
    fn usable(&self) -> Result<()> {
        finite("shift", &self.shift)?;
        match self.scale.iter().position(|s| !(s.is_finite() && *s > 0.0)) {
            None => Ok(()),
            Some(c) => Err(GpError::Parameter {
                name: format!("scale[{c}]"),
                value: self.scale[c],
                expected: "a positive, finite number".into(),
            }),
        }
    }

    /// `(x - shift)/scale` for inputs.
    pub fn inputs(&self, x: &Inputs) -> Result<Inputs> {
        self.usable()?;
        x.standardised(&self.shift, &self.scale)
    }

    /// `(y - shift)/scale` for measurements.
    pub fn outputs(&self, y: &[f64], channels: &[usize]) -> Result<Vec<f64>> {
        self.check(channels, y.len())?;
        let out: Vec<f64> = y
            .iter()
            .zip(channels)
            .map(|(v, &c)| (v - self.shift[c]) / self.scale[c])
            .collect();
        finite("normalised measurements", &out)?;
        Ok(out)
    }

    /// Undo [`Scaling::outputs`] on means or samples.
    pub fn restore(&self, values: &[f64], channels: &[usize]) -> Result<Vec<f64>> {
        self.check(channels, values.len())?;
        let out: Vec<f64> = values
            .iter()
            .zip(channels)
            .map(|(v, &c)| v * self.scale[c] + self.shift[c])
            .collect();
        finite("restored values", &out)?;
        Ok(out)
    }

    /// Undo [`Scaling::outputs`] on means and variances.
    pub fn restore_prediction(&self, p: &Prediction, channels: &[usize]) -> Result<Prediction> {
        let mean = self.restore(&p.mean, channels)?;
        self.check(channels, p.variance.len())?;
        let variance = p
            .variance
            .iter()
            .zip(channels)
            .map(|(v, &c)| v * self.scale[c] * self.scale[c])
            .collect();
        Ok(Prediction { mean, variance })
    }

    /// Undo [`Scaling::outputs`] on a covariance.
    pub fn restore_covariance(
        &self,
        covariance: &Mat<f64>,
        channels: &[usize],
    ) -> Result<Mat<f64>> {
        self.check(channels, covariance.nrows())?;
        self.check(channels, covariance.ncols())?;
        Ok(Mat::from_fn(
            covariance.nrows(),
            covariance.ncols(),
            |i, j| covariance[(i, j)] * self.scale[channels[i]] * self.scale[channels[j]],
        ))
    }

    pub(crate) fn validate(&self) -> Result<()> {
        if self.shift.len() != self.scale.len() {
            return Err(GpError::Saved("a scaling has unequal lengths".into()));
        }
        self.usable()
    }
}
