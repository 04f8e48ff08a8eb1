//! What the columns of a log say of its motion, thinned to what a look needs, and how far the
//! model is from it.

use super::mistake::{Change, Column, Kind};
use crate::log::{Record, rms};
use crate::machine::{Machine, States};
use crate::smooth::{SmoothError, savgol_states};
use crate::trace::score::scales;

/// Samples that are looked at.
const LOOKED_AT: usize = 400;

/// The columns of a record with their derivatives, each from itself alone: what becomes of
/// them if a column is another is known without filtering again.
#[derive(Debug, Clone)]
pub(super) struct Seen {
    t: Vec<f64>,
    u: Vec<Vec<f64>>,
    /// Per coordinate and kind of column ([`Kind::MOTION`]), what it measures and its
    /// derivatives up to the acceleration; nothing where it was not logged.
    motion: Vec<[Vec<Vec<f64>>; 3]>,
}

/// A model with the values of its parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given<'a> {
    pub machine: &'a Machine,
    pub values: &'a [f64],
}

impl Seen {
    /// Samples evenly spread over a record.
    ///
    /// # Errors
    /// If the record cannot be filtered.
    pub fn of(record: &Record) -> Result<Self, SmoothError> {
        let without_acceleration = Record {
            ddq: vec![None; record.ddq.len()],
            ..record.clone()
        };
        let by_velocity = savgol_states(&without_acceleration)?;
        let by_position = savgol_states(&Record {
            dq: vec![None; record.dq.len()],
            ..without_acceleration
        })?;
        let stride = record.len().div_ceil(LOOKED_AT).max(1);
        let thin = |values: &[f64]| values.iter().step_by(stride).copied().collect::<Vec<f64>>();
        let motion = (0..record.q.len()).map(|i| {
            let position = [&by_position.q[i], &by_position.v[i], &by_position.a[i]];
            let velocity = [&by_velocity.v[i], &by_velocity.a[i]];
            [
                position.map(|values| thin(values)).to_vec(),
                match record.dq[i] {
                    Some(_) => velocity.map(|values| thin(values)).to_vec(),
                    None => Vec::new(),
                },
                record.ddq[i].iter().map(|values| thin(values)).collect(),
            ]
        });
        Ok(Self {
            t: thin(&record.t),
            u: record.u.iter().map(|u| thin(u)).collect(),
            motion: motion.collect(),
        })
    }

    /// The logged columns of a coordinate.
    pub fn columns(&self, coordinate: usize) -> Vec<Column> {
        let kinds = Kind::MOTION.into_iter().zip(&self.motion[coordinate]);
        let logged = kinds.filter(|(_, values)| !values.is_empty());
        let column = |(kind, _)| Column {
            kind,
            index: coordinate,
        };
        logged.map(column).collect()
    }

    /// A logged velocity, and the rate of the position beside it; nothing without the former.
    pub fn rates(&self, of: usize, beside: usize) -> Option<(&[f64], &[f64])> {
        let logged = self.motion[of][1].first()?;
        Some((logged, &self.motion[beside][0][1]))
    }

    /// How many coordinates there are.
    pub fn coordinates(&self) -> usize {
        self.motion.len()
    }

    /// How many inputs there are.
    pub fn inputs(&self) -> usize {
        self.u.len()
    }

    /// What would be seen with some columns mended.
    pub fn with(&self, changes: &[Change]) -> Self {
        let mut seen = self.clone();
        for &change in changes {
            match change {
                Change::Scale(column, by) => {
                    let values = seen.of_column(column).iter_mut().flatten();
                    values.for_each(|value| *value *= by);
                }
                Change::Swap(a, b) => {
                    let taken = seen.of_column(a).to_vec();
                    let other = seen.of_column(b).to_vec();
                    seen.of_column(a).clone_from_slice(&other);
                    seen.of_column(b).clone_from_slice(&taken);
                }
            }
        }
        seen
    }

    fn of_column(&mut self, column: Column) -> &mut [Vec<f64>] {
        match column.kind {
            Kind::Input => std::slice::from_mut(&mut self.u[column.index]),
            kind => &mut self.motion[column.index][kind as usize],
        }
    }

    /// The best that was logged of a derivative (0, 1 or 2) of every coordinate.
    fn derivative(&self, order: usize) -> Vec<Vec<f64>> {
        let best = |kinds: &[Vec<Vec<f64>>; 3]| {
            let logged = (0..=order).rev().find(|&kind| !kinds[kind].is_empty());
            // Positions are always logged.
            let kind = logged.unwrap_or(0);
            kinds[kind][order - kind].clone()
        };
        self.motion.iter().map(best).collect()
    }

    /// The error of the model's accelerations as a share of their size, root mean square over
    /// coordinates; infinite where the model has none.
    pub fn error(&self, given: Given<'_>) -> f64 {
        let [q, v, a] = [0, 1, 2].map(|order| self.derivative(order));
        let states = States {
            t: self.t.clone(),
            q,
            v,
            u: self.u.clone(),
            ..States::default()
        };
        let Ok(motions) = given.machine.motion(&states, given.values) else {
            return f64::INFINITY;
        };
        let shares = a.iter().zip(scales(&a)).enumerate().map(|(i, (a, size))| {
            let misses = motions.iter().zip(a).map(|(m, a)| m.acceleration[i] - a);
            let misses: Vec<f64> = misses.collect();
            match size > 0.0 {
                true => rms(&misses) / size,
                false => 0.0,
            }
        });
        rms(&shares.collect::<Vec<f64>>())
    }
}
