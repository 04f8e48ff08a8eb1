//! How noisy sensors are, and what they would have shown at the samples.

use crate::log::{Reading, Sensed, quantisation_step, rms};
use crate::regression::NoiseEvidence;
use crate::smooth::{Channels, SmoothError, Smoothed, Smoother};
use rayon::prelude::*;

/// Noise is no less than this share of what a sensor shows: nothing is known better.
const LEAST: f64 = 1e-6;
/// Share of the noise's variance that the other readings must tell from the motion.
const SEEN: f64 = 0.5;
/// Noise that changes by less than this share is the same.
const SAME: f64 = 0.05;

/// Estimates the noise of each reading from the reading alone, as that of a measured position is,
/// and brings readings that were taken between samples to the samples where they stand.
pub(super) fn estimate(sensed: &mut Sensed, t: &[f64]) {
    sensed.readings.par_iter_mut().for_each(|reading| {
        let (times, values) = reading.taken(t);
        // What is too short or too odd to be smoothed changes as it does by noise alone.
        let smoothed = smoothed(&times, &values);
        let sd = smoothed.as_ref().map_or(f64::INFINITY, |s| s.noise.sd_q);
        let sd = if sd.is_finite() { sd } else { rms(&values) };
        reading.sd = sd.max(least(&values));
        if let Ok(smoothed) = smoothed {
            bring_to_samples(reading, t, &smoothed);
        }
    });
}

/// Believes readings more that agree with each other through the model better than their noise
/// says: of a motion that is fast beside the samples a part was taken for noise. `evidence` is that
/// of the whitener with these readings. Whether anything changed by more than [`SAME`].
pub(super) fn sharpen(sensed: &mut Sensed, evidence: &NoiseEvidence) -> bool {
    let mut changed = false;
    for (place, reading) in sensed.readings.iter_mut().enumerate() {
        let information = evidence.instrument_information[place];
        let ratio = evidence.instrument_score[place] / information;
        let count = (0..reading.values.len())
            .filter(|&k| reading.is_new(k))
            .count();
        let seen = information * reading.sd.powi(2) / count.max(1) as f64;
        if seen > SEEN && ratio.is_finite() && ratio < 1.0 {
            let sd = (reading.sd * ratio.sqrt()).max(least(&reading.values));
            changed |= sd < (1.0 - SAME) * reading.sd;
            reading.sd = sd.min(reading.sd);
        }
    }
    changed
}

/// The least noise of a sensor that shows these values.
fn least(values: &[f64]) -> f64 {
    let step = quantisation_step(values).unwrap_or(0.0);
    let least = (LEAST * rms(values)).max(step / 12.0_f64.sqrt());
    least.max(f64::MIN_POSITIVE.sqrt())
}

fn smoothed(t: &[f64], values: &[f64]) -> Result<Smoothed, SmoothError> {
    let channels = Channels::new(t, values, None, None)?;
    Smoother::fit(&channels)?.apply(&channels)
}

/// Adds what a reading has changed by, smoothly, since it was taken.
fn bring_to_samples(reading: &mut Reading, t: &[f64], smoothed: &Smoothed) {
    let new = (0..t.len()).filter(|&k| reading.is_new(k));
    let new: Vec<usize> = new.collect();
    for (place, &k) in new.iter().enumerate() {
        let age = reading.age.get(k).copied().flatten().unwrap_or(0.0);
        let step = smoothed
            .t
            .get(place + 1)
            .map(|next| next - smoothed.t[place]);
        let after = step.and_then(|step| smoothed.between(place, (age / step).min(1.0)));
        if let Some(after) = after.filter(|_| age > 0.0) {
            reading.values[k] += after.q - smoothed.q[place];
        }
    }
}
