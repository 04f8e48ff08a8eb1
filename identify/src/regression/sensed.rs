//! What a column changes in readings without changing the motion: an offset of a sensor.

use super::mover::Columns;
use super::whitener::Mix;
use crate::log::segments;
use crate::machine::{Measured, States};
use nalgebra::DMatrix;

/// Derivatives of readings by those columns that sensors know of, along a curve.
#[derive(Debug, Clone, Default)]
pub struct Sensed {
    /// Which columns, counted from zero, ascending.
    columns: Vec<usize>,
    /// Per sample, `3n×k`: of positions, velocities and accelerations, in units of what a
    /// change of the motion would change in the reading.
    values: Vec<DMatrix<f64>>,
}

impl Sensed {
    /// Along `curve`, where the accelerations are those given, one column per coordinate.
    pub(super) fn new(columns: &[Columns<'_>], curve: &States, accelerations: &[Vec<f64>]) -> Self {
        let mut known = Vec::new();
        let mut changes = Vec::new();
        let mut first = 0;
        for block in columns {
            if let Some(sensors) = block.sensors.filter(|sensors| !sensors.sensing.is_empty()) {
                let states = block.machine.at_rest(curve, block.parameters);
                let read = sensors.read(&states, accelerations, block.parameters);
                known.extend(sensors.sensing.iter().map(|variable| first + variable));
                let places = 0..sensors.sensing.len();
                changes.extend(places.map(|place| read.changes(place, &curve.t)));
            }
            first += block.tape.variable_count();
        }
        if known.is_empty() {
            return Self::default();
        }
        let at = |sample: usize| {
            let entry = |row: usize, column: usize| changes[column][row][sample];
            DMatrix::from_fn(3 * curve.q.len(), known.len(), entry)
        };
        Self {
            values: (0..curve.len()).map(at).collect(),
            columns: known,
        }
    }

    /// Per column that sensors know of, counted from zero: root mean square of what a unit of it
    /// changes in the readings of each position.
    pub fn sizes(&self) -> Vec<(usize, Vec<f64>)> {
        let samples = self.values.len().max(1) as f64;
        let size = |place: usize, row: usize| {
            let squares = self.values.iter().map(|at| at[(row, place)].powi(2));
            (squares.sum::<f64>() / samples).sqrt()
        };
        let coordinates = self.values.first().map_or(0, |at| at.nrows() / 3);
        let sizes = |place: usize| (0..coordinates).map(|row| size(place, row)).collect();
        let known = self.columns.iter().enumerate();
        known
            .map(|(place, &column)| (column, sizes(place)))
            .collect()
    }

    /// What a mix of columns adds to the readings of a sample, `3n × count`; `None` if no
    /// sensor knows of any column.
    pub(super) fn of(&self, sample: usize, mix: &Mix<'_>) -> Option<DMatrix<f64>> {
        let values = self.values.get(sample)?;
        Some(mixed(&self.columns, values, mix))
    }
}

/// A mix of columns, where all but those `known` are null: these have the given values.
pub(super) fn mixed(known: &[usize], values: &DMatrix<f64>, mix: &Mix<'_>) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(values.nrows(), mix.count());
    for (place, &column) in known.iter().enumerate() {
        let weights: &mut dyn Iterator<Item = (usize, f64)> = match mix {
            // The data are number zero there.
            Mix::Columns(all) => {
                let wanted = all.iter().enumerate();
                &mut wanted.filter_map(|(i, &c)| (c == column + 1).then_some((i, 1.0)))
            }
            Mix::Sum(weights) => &mut std::iter::once((0, weights[column + 1])),
        };
        for (i, weight) in weights {
            sum.column_mut(i).axpy(weight, &values.column(place), 1.0);
        }
    }
    sum
}

impl Measured {
    /// What variable number `place` changes in the readings of positions, velocities and
    /// accelerations (`3n` columns), in units of the readings' slopes.
    fn changes(&self, place: usize, t: &[f64]) -> Vec<Vec<f64>> {
        let shared = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let pairs = columns.iter().zip(&self.slope);
            pairs
                .map(|(column, slope)| divided(column, slope))
                .collect()
        };
        let positions = shared(&self.q_by[place]);
        let rates = shared(&self.v_by[place]);
        let accelerations: Vec<Vec<f64>> = rates.iter().map(|rate| derivative(t, rate)).collect();
        [positions, rates, accelerations].concat()
    }
}

pub(crate) fn divided(column: &[f64], slope: &[f64]) -> Vec<f64> {
    column.iter().zip(slope).map(|(x, s)| x / s).collect()
}

/// `dx/dt` by central differences, one-sided at the ends of what is without a gap.
pub(crate) fn derivative(t: &[f64], x: &[f64]) -> Vec<f64> {
    let mut rate = vec![0.0; x.len()];
    for range in segments(t) {
        for k in range.clone() {
            let (a, b) = (
                k.saturating_sub(1).max(range.start),
                (k + 1).min(range.end - 1),
            );
            if b > a {
                rate[k] = (x[b] - x[a]) / (t[b] - t[a]);
            }
        }
    }
    rate
}
