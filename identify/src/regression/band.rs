//! The band in which a log shows accelerations at all.

use crate::log::Record;
use crate::smooth::Smoothed;

/// The band in which accelerations are known: forces outside it cannot be explained, and
/// both sides of the equation are limited to it by the same window, without phase.
#[derive(Debug, Clone)]
pub struct Band {
    window: Vec<f64>,
    stride: usize,
}

impl Band {
    /// Of a record whose coordinates were smoothed, so many `times` as narrow as that in which it shows
    /// accelerations; of the samples at most `most` are kept.
    pub fn of(record: &Record, smoothed: &[Smoothed], most: usize, times: usize) -> Self {
        let step = record.step();
        let response = smoothed.iter().map(|s| s.smoother.response(step));
        let response = response.fold(0.0, f64::max);
        let response = match times {
            1 => response,
            // Motion that the log shows from sample to sample has no window to widen.
            _ => times as f64 * response.max(step),
        };
        Self::new(response, step, record.len(), most)
    }

    /// Every sample by itself.
    pub fn everything() -> Self {
        Self {
            window: vec![1.0],
            stride: 1,
        }
    }

    /// How many samples the window holds.
    pub fn window(&self) -> usize {
        self.window.len()
    }

    /// For motion that answers within `response` s, at samples `step` s apart.
    fn new(response: f64, step: f64, samples: usize, most: usize) -> Self {
        let half = if step > 0.0 {
            (response / step).round() as usize
        } else {
            0
        };
        let half = half.min(samples / 20);
        let length = 2 * half + 1;
        let hann = |k: usize| {
            let phase = (k + 1) as f64 / (length + 1) as f64;
            1.0 - (2.0 * std::f64::consts::PI * phase).cos()
        };
        let window: Vec<f64> = (0..length).map(hann).collect();
        let sum: f64 = window.iter().sum();
        Self {
            window: window.iter().map(|w| w / sum).collect(),
            // Four samples per window keep what it lets pass.
            stride: (length / 4).max(samples.div_ceil(most)).max(1),
        }
    }

    /// Every how many samples one is kept.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The mean under the window around every `stride`-th sample; at the ends, of what
    /// there is.
    pub fn limit(&self, values: &[f64]) -> Vec<f64> {
        self.means(values, self.stride)
    }

    /// The same of values that are not needed any longer: those themselves, where every sample stands alone.
    pub fn limited(&self, values: Vec<f64>) -> Vec<f64> {
        if self.window.len() == 1 && self.stride == 1 {
            return values;
        }
        self.limit(&values)
    }

    /// The same around every sample.
    pub fn limit_everywhere(&self, values: &[f64]) -> Vec<f64> {
        self.means(values, 1)
    }

    fn means(&self, values: &[f64], stride: usize) -> Vec<f64> {
        let half = self.window.len() / 2;
        (0..values.len())
            .step_by(stride)
            .map(|center| {
                let first = center.saturating_sub(half);
                let last = (center + half).min(values.len() - 1);
                let weights = &self.window[first + half - center..=last + half - center];
                let sum: f64 = weights.iter().sum();
                let pairs = weights.iter().zip(&values[first..=last]);
                pairs.map(|(w, x)| w * x).sum::<f64>() / sum
            })
            .collect()
    }
}
