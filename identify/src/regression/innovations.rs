//! What each reading brings that the readings before it did not predict.

use super::readings::Sensor;
use super::whitener::{Mix, Whitener};
use crate::log::mad_sd;
use std::collections::BTreeMap;

/// A whitened innovation of a position sensor: under the right model a draw from the
/// standard normal distribution, independent of all others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// The row of the log that it stands in.
    pub sample: usize,
    /// Which coordinate.
    pub coordinate: usize,
    /// The innovation in units of its standard deviation.
    pub value: f64,
}

impl Whitener<'_> {
    /// Whitened innovations of all position readings, in order of time.
    pub fn position_innovations(&self) -> Vec<Innovation> {
        let rows = self.whiten(&Mix::Columns(&[0]));
        let innovation = |(update, value): (&super::whitener::Update, &f64)| match update.sensor {
            Sensor::Position(coordinate) => Some(Innovation {
                sample: update.reading as usize,
                coordinate,
                value: *value,
            }),
            _ => None,
        };
        let updates = self.updates.iter().zip(rows.iter());
        updates.filter_map(innovation).collect()
    }

    /// What each sample's readings cost: half the squares of their whitened innovations, nats.
    pub fn losses(&self) -> Vec<f64> {
        let rows = self.whiten(&Mix::Columns(&[0]));
        let mut losses = vec![0.0; self.dynamics.t.len()];
        for (update, e) in self.updates.iter().zip(rows.iter()) {
            losses[update.sample as usize] += 0.5 * e * e;
        }
        losses
    }

    /// How each sensor errs by its innovations.
    pub fn channel_errors(&self) -> Vec<ChannelErrors> {
        let rows = self.whiten(&Mix::Columns(&[0]));
        let mut channels: BTreeMap<(usize, usize), Vec<f64>> = BTreeMap::new();
        for (update, e) in self.updates.iter().zip(rows.iter()) {
            let channel = match update.sensor {
                Sensor::Position(i) => (0, i),
                Sensor::Velocity(i) => (1, i),
                Sensor::Acceleration(i) => (2, i),
                Sensor::Instrument(_) | Sensor::Closure(_) => continue,
            };
            channels.entry(channel).or_default().push(*e);
        }
        let each = channels.into_iter();
        each.map(|((derivative, coordinate), e)| ChannelErrors::new(derivative, coordinate, &e))
            .collect()
    }
}

/// How a sensor errs if all of its innovations are its own errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelErrors {
    /// Which derivative of a position it reads.
    pub derivative: usize,
    /// Of which coordinate.
    pub coordinate: usize,
    /// Sum of squares of its innovations.
    pub squares: f64,
    /// Correlation `ψ` of an error with the one before.
    pub memory: f64,
    /// Variance `v` of what of an error the one before does not foretell, in units of what it was thought
    /// to be.
    pub news: f64,
    /// Nats by which the readings are likelier so: `½ Σ e² − ½ n (1 + ln v)` of `n` innovations `e`.
    pub gain: f64,
    /// How many of these are for the memory, and not for another size: `−½ n ln(1 − ψ²)`.
    pub by_memory: f64,
}

/// Ordinary sizes beyond which an innovation counts as no larger.
const WILD: f64 = 5.0;

impl ChannelErrors {
    fn new(derivative: usize, coordinate: usize, innovations: &[f64]) -> Self {
        // A wild sample that nobody set aside says nothing of the others.
        let ordinary = mad_sd(innovations).filter(|sd| *sd > 0.0);
        let most = ordinary.map_or(f64::INFINITY, |sd| WILD * sd);
        let e: Vec<f64> = innovations.iter().map(|e| e.clamp(-most, most)).collect();
        let (count, squares) = (e.len() as f64, e.iter().map(|e| e * e).sum::<f64>());
        let products: f64 = e.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let memory = match squares > 0.0 {
            true => products / squares,
            false => 0.0,
        };
        let news = squares / count * (1.0 - memory * memory);
        Self {
            derivative,
            coordinate,
            squares,
            memory,
            news,
            gain: match news > 0.0 {
                true => 0.5 * squares - 0.5 * count * (1.0 + news.ln()),
                false => 0.0,
            },
            by_memory: -0.5 * count * (1.0 - memory * memory).ln(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn errors_that_remember_are_known_by_it() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let (memory, news) = (0.8, 0.36_f64);
        let mut last = 0.0;
        let errors: Vec<f64> = (0..20_000)
            .map(|_| {
                last = memory * last + news.sqrt() * draw();
                last
            })
            .collect();
        let own = ChannelErrors::new(0, 0, &errors);
        assert!((own.memory - memory).abs() < 0.01, "{own:?}");
        assert!((own.news - news).abs() < 0.01, "{own:?}");
        // −½ n ln 0.36, with a variance of one.
        assert!((own.gain / 20_000.0 - 0.511).abs() < 0.02, "{own:?}");
        assert!((own.by_memory / own.gain - 1.0).abs() < 0.02, "{own:?}");
        let white: Vec<f64> = (0..20_000).map(|_| draw()).collect();
        assert!(ChannelErrors::new(0, 0, &white).gain < 10.0);
        // Of another size than was thought, and white all the same.
        let larger: Vec<f64> = white.iter().map(|e| 1.2 * e).collect();
        let own = ChannelErrors::new(0, 0, &larger);
        assert!(own.gain > 100.0 && own.by_memory < 5.0, "{own:?}");
    }
}
