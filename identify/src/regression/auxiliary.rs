//! Auxiliary residuals (Harvey and Koopman, 1992): each reading held against all the others, earlier and
//! later ones.

use super::readings::Sensor;
use super::whitener::{Mix, Whitener};

/// A reading of a coordinate beside what all other readings say of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Auxiliary {
    /// The row of the log that it stands in.
    pub sample: usize,
    /// Which derivative of a position was read.
    pub derivative: usize,
    /// Of which coordinate.
    pub coordinate: usize,
    /// The reading less what the others say, in its own unit.
    pub apart: f64,
    /// The same in units of its standard deviation: under the right model a draw from the standard
    /// normal distribution.
    pub value: f64,
}

impl Whitener<'_> {
    /// The auxiliary residual of every reading of a coordinate: with `u = ν/S − Kᵀr` and `D = 1/S + KᵀNK` of the
    /// smoother, `y` is `u/D` apart from what the others say, which is `u/√D` standard deviations.
    pub fn auxiliary(&self) -> Vec<Auxiliary> {
        let rows = self.whiten(&Mix::Columns(&[0]));
        let mut found = Vec::with_capacity(self.updates.len());
        self.backward(&rows, true, |_, _, errors| {
            for error in errors {
                let (derivative, coordinate) = match error.sensor {
                    Sensor::Position(i) => (0, i),
                    Sensor::Velocity(i) => (1, i),
                    Sensor::Acceleration(i) => (2, i),
                    Sensor::Instrument(_) | Sensor::Closure(_) => continue,
                };
                found.push(Auxiliary {
                    sample: error.reading,
                    derivative,
                    coordinate,
                    apart: error.pull / error.own,
                    value: error.pull / error.own.sqrt(),
                });
            }
        });
        found
    }
}
