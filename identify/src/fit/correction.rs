//! What a fit adds to the equation of motion.

use super::columns::Columns;
use crate::machine::{Machine, States};
use nalgebra::{DMatrix, DVector};

/// Estimated corrections `x` of the columns `X`: with them the machine moves by
/// `M a = Q − X(q, v, a) x + Aᵀλ`.
#[derive(Debug, Clone)]
pub(super) struct Correction {
    pub columns: Columns,
    /// `x`, one per column.
    pub values: Vec<f64>,
    /// The fastest motion of the log that was learnt from, per coordinate.
    pub fastest: Vec<f64>,
}

impl Correction {
    /// Whether nothing is corrected.
    pub fn is_empty(&self) -> bool {
        self.values.iter().all(|&x| x == 0.0)
    }

    /// Per sample `ΔM` (`n×n`) and `ΔQ` (`n`): the columns are affine in the accelerations,
    /// so that `(M + ΔM) a = Q − ΔQ + Aᵀλ`.
    pub fn along(
        &self,
        machine: &Machine,
        states: &States,
        parameters: &[f64],
    ) -> Vec<(DMatrix<f64>, DVector<f64>)> {
        let n = machine.coordinate_count();
        let mut a = vec![vec![0.0; states.len()]; n];
        let still = self.weighed(machine, states, parameters, &a);
        let slopes: Vec<Vec<Vec<f64>>> = (0..n)
            .map(|j| {
                a[j].fill(1.0);
                let moved = self.weighed(machine, states, parameters, &a);
                a[j].fill(0.0);
                moved
            })
            .collect();
        (0..states.len())
            .map(|k| {
                let mass = DMatrix::from_fn(n, n, |i, j| slopes[j][i][k] - still[i][k]);
                (mass, DVector::from_fn(n, |i, _| still[i][k]))
            })
            .collect()
    }

    /// `X(q, v, a) x`: per coordinate, a value per sample.
    pub fn weighed(
        &self,
        machine: &Machine,
        states: &States,
        parameters: &[f64],
        a: &[Vec<f64>],
    ) -> Vec<Vec<f64>> {
        let columns = (self.columns).along(machine, states, parameters, a, &self.fastest);
        let mut sum = vec![vec![0.0; states.len()]; a.len()];
        for (column, &x) in columns.iter().zip(&self.values).filter(|(_, x)| **x != 0.0) {
            for (sum, column) in sum.iter_mut().zip(column) {
                sum.iter_mut().zip(column).for_each(|(s, c)| *s += x * c);
            }
        }
        sum
    }
}
