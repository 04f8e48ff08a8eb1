//! Constraints along a curve, read as sensors that always read zero.

use super::mover::Columns;
use super::sensed::mixed;
use super::whitener::Mix;
use crate::machine::States;
use nalgebra::{DMatrix, DVector};

/// The holonomic constraints `c(q, t) = 0` along a curve, and what columns change in them.
#[derive(Debug, Clone, Default)]
pub struct Closed {
    /// `c`, `m`, per sample.
    pub residual: Vec<DVector<f64>>,
    /// `∂c/∂q`, `m×n`, per sample.
    pub gradient: Vec<DMatrix<f64>>,
    /// How far each constraint reaches along the curve: how much `c` would spread if each
    /// coordinate went its way alone.
    pub reach: DVector<f64>,
    /// Which columns constraints know of, counted from zero, ascending.
    columns: Vec<usize>,
    /// Per sample `∂c/∂s` by these, `m×k`.
    by: Vec<DMatrix<f64>>,
}

/// The holonomic constraints at one place along a curve.
#[derive(Debug, Clone)]
pub(super) struct Missed {
    /// `c`, `m`.
    pub residual: DVector<f64>,
    /// `∂c/∂q`, `m×n`.
    pub gradient: DMatrix<f64>,
}

/// A way beyond which a coordinate's spread counts no more, in its unit: a crank that turns on
/// and on does not reach farther.
const FAR: f64 = 1.0;

impl Closed {
    /// Along `curve`, where constraints are `missed` as given per sample.
    pub(super) fn new(columns: &[Columns<'_>], curve: &States, missed: Vec<Missed>) -> Self {
        let parts = missed.into_iter().map(|at| (at.residual, at.gradient));
        let (residual, gradient): (Vec<_>, Vec<_>) = parts.unzip();
        let rows = residual.first().map_or(0, DVector::len);
        if rows == 0 {
            return Self::default();
        }
        let (mut known, mut slopes) = (Vec::new(), Vec::new());
        let mut first = 0;
        for block in columns {
            if let Some(closure) = block.sensors.map(|sensors| &sensors.closure) {
                let states = block.machine.at_rest(curve, block.parameters);
                known.extend(closure.closing.iter().map(|variable| first + variable));
                slopes.extend(closure.slopes(&states, block.parameters));
            }
            first += block.tape.variable_count();
        }
        let at = |sample: usize| {
            DMatrix::from_fn(rows, known.len(), |row, column| slopes[column][row][sample])
        };
        Self {
            reach: reach(&gradient, curve),
            by: (0..curve.len()).map(at).collect(),
            columns: known,
            residual,
            gradient,
        }
    }

    /// Number of constraints.
    pub fn rows(&self) -> usize {
        self.reach.len()
    }

    /// What a mix of columns adds to the constraints at a sample, `m × count`.
    pub(super) fn of(&self, sample: usize, mix: &Mix<'_>) -> Option<DMatrix<f64>> {
        self.by.get(sample).map(|by| mixed(&self.columns, by, mix))
    }

    /// Root mean square of each constraint along the curve.
    pub fn violation(&self) -> DVector<f64> {
        let squares = self.residual.iter().map(|c| c.component_mul(c));
        let sum = squares.fold(DVector::zeros(self.rows()), |sum, c| sum + c);
        sum.map(|sum| (sum / self.residual.len().max(1) as f64).sqrt())
    }
}

fn reach(gradient: &[DMatrix<f64>], curve: &States) -> DVector<f64> {
    let samples = curve.len().max(1) as f64;
    let spread = |q: &Vec<f64>| {
        let mean = q.iter().sum::<f64>() / samples;
        let square = q.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / samples;
        square.sqrt().min(FAR)
    };
    let spread: Vec<f64> = curve.q.iter().map(spread).collect();
    let rows = gradient.first().map_or(0, DMatrix::nrows);
    DVector::from_fn(rows, |row, _| {
        let moved = |a: &DMatrix<f64>| -> f64 {
            let each = spread.iter().enumerate();
            each.map(|(j, spread)| (a[(row, j)] * spread).powi(2)).sum()
        };
        (gradient.iter().map(moved).sum::<f64>() / samples).sqrt()
    })
}
