//! States in columns: one entry per sample.

use dynamics_codegen::Column;

/// Where a machine is evaluated. Every column has one entry per sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct States {
    /// Time, s.
    pub t: Vec<f64>,
    /// Positions, one column per coordinate.
    pub q: Vec<Vec<f64>>,
    /// Velocities, one column per coordinate.
    pub v: Vec<Vec<f64>>,
    /// Inputs, one column per input.
    pub u: Vec<Vec<f64>>,
}

impl States {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// The tape's inputs, in the order `t, q, v, u, parameters`.
    pub(super) fn columns<'a>(&'a self, parameters: &'a [f64]) -> Vec<Column<'a>> {
        let mut columns = vec![Column::Each(self.t.as_slice())];
        for group in [&self.q, &self.v, &self.u] {
            columns.extend(group.iter().map(|column| Column::Each(column.as_slice())));
        }
        columns.extend(parameters.iter().map(|&value| Column::Same(value)));
        columns
    }

    /// The samples in `range`.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Self {
        let cut =
            |columns: &[Vec<f64>]| columns.iter().map(|c| c[range.clone()].to_vec()).collect();
        Self {
            t: self.t[range.clone()].to_vec(),
            q: cut(&self.q),
            v: cut(&self.v),
            u: cut(&self.u),
        }
    }
}
