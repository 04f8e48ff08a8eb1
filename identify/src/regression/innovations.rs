//! What each reading brings that the readings before it did not predict.

use super::readings::Sensor;
use super::whitener::{Mix, Whitener};

/// A whitened innovation of a position sensor: under the right model a draw from the
/// standard normal distribution, independent of all others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// Which sample.
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
                sample: update.sample as usize,
                coordinate,
                value: *value,
            }),
            _ => None,
        };
        let updates = self.updates.iter().zip(rows.iter());
        updates.filter_map(innovation).collect()
    }
}
