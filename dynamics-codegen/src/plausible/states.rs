//! The states at which a model is tried.

use crate::derive::System;
use crate::graph::{ExprId, SymbolId};
use crate::model::{Model, Parameter, Pose};
use crate::tape::{Column, Tape};
use crate::tree::Joint;

/// So many states are tried: the first is zero, the others lie in general position, so
/// that what holds at all of them by accident is not met with.
const TRIALS: usize = 8;

/// Positions, velocities and times are tried up to this, in the units of the SI: the size
/// of a machine, and of an angle at which no sine is near its argument.
const REACH: f64 = 1.0;

/// States of a model, at its nominal parameters; inputs and internal states are zero.
#[derive(Clone)]
pub(super) struct States<'a> {
    model: &'a Model,
    arguments: Vec<SymbolId>,
    /// Per argument its values, one per state.
    columns: Vec<Vec<f64>>,
}

impl<'a> States<'a> {
    /// Of a model.
    pub fn of(model: &'a Model) -> Self {
        let arguments = System::arguments(model);
        let paired = model.coordinates.iter().enumerate();
        let paired = paired.filter(|(index, _)| model.pose_of(*index).is_none());
        let twists = model.coordinates.iter().enumerate();
        let twists = twists.filter(|(index, _)| model.pose_of(*index).is_some());
        let moving: Vec<SymbolId> = paired
            .flat_map(|(_, c)| [c.position, c.velocity])
            .chain([model.time])
            .chain(model.poses.iter().flat_map(Pose::symbols))
            .chain(twists.map(|(_, c)| c.velocity))
            .collect();
        let column = |symbol: &SymbolId| -> Vec<f64> {
            if let Some(place) = moving.iter().position(|moving| moving == symbol) {
                return (0..TRIALS)
                    .map(|trial| REACH * spread(trial, place))
                    .collect();
            }
            let parameter = model.parameters.iter().find(|p| p.symbol == *symbol);
            vec![parameter.map_or(0.0, |p| p.nominal); TRIALS]
        };
        let mut states = Self {
            model,
            columns: arguments.iter().map(column).collect(),
            arguments,
        };
        states.normalise_quaternions();
        states
    }

    /// The same with another value of a parameter.
    pub fn with(&self, parameter: &Parameter, value: f64) -> Self {
        let mut changed = self.clone();
        if let Some(place) = self.place(parameter.symbol) {
            changed.columns[place].fill(value);
        }
        changed
    }

    fn place(&self, symbol: SymbolId) -> Option<usize> {
        self.arguments.iter().position(|&own| own == symbol)
    }

    /// What turns by a quaternion turns by one of length one, `w` last.
    fn normalise_quaternions(&mut self) {
        let turning = self.model.tree.bodies.iter().filter_map(|body| {
            let quaternion = match &body.joint {
                Joint::Ball(quaternion) => quaternion,
                Joint::Floating(floating) => &floating.quaternion,
                _ => return None,
            };
            Some(quaternion.map(|c| self.model.coordinates[c.index].position))
        });
        let poses = self.model.poses.iter().map(|pose| pose.quaternion);
        let quaternions: Vec<[SymbolId; 4]> = turning.chain(poses).collect();
        for quaternion in quaternions {
            let places = quaternion.map(|symbol| self.place(symbol));
            // Every position is an argument.
            let places: Vec<usize> = places.into_iter().flatten().collect();
            for trial in 0..TRIALS {
                let mut values: Vec<f64> = places.iter().map(|&p| self.columns[p][trial]).collect();
                let mut length = values.iter().map(|x| x * x).sum::<f64>().sqrt();
                if length == 0.0 {
                    (values, length) = (vec![0.0, 0.0, 0.0, 1.0], 1.0);
                }
                for (&place, value) in places.iter().zip(values) {
                    self.columns[place][trial] = value / length;
                }
            }
        }
    }

    /// The values of expressions at every state where all of them are finite, with the
    /// number of the state.
    pub fn evaluate(&self, outputs: &[ExprId]) -> Vec<(usize, Vec<f64>)> {
        let tape = Tape::new(&self.model.graph, outputs, &self.arguments);
        let columns: Vec<Column<'_>> = self.columns.iter().map(|c| Column::Each(c)).collect();
        let found = tape.evaluate_all(&columns, TRIALS);
        let at = |trial: usize| found.iter().map(|column| column[trial]).collect();
        let states = (0..TRIALS).map(|trial| (trial, at(trial)));
        states
            .filter(|(_, values): &(usize, Vec<f64>)| values.iter().all(|x| x.is_finite()))
            .collect()
    }

    /// The positions at a state, in the order of `q`.
    pub fn positions(&self, trial: usize) -> Vec<f64> {
        let positions = self.model.position_symbols().into_iter();
        positions
            .filter_map(|symbol| self.place(symbol))
            .map(|column| self.columns[column][trial])
            .collect()
    }
}

/// A number between −1 and 1, zero in the first trial: multiples of irrational steps, a
/// step of its own for every place.
fn spread(trial: usize, place: usize) -> f64 {
    let step = ((place + 2) as f64).sqrt() * std::f64::consts::E;
    let turns = trial as f64 * step + 0.5;
    2.0 * turns.fract() - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_lie_apart() {
        for place in 0..200 {
            assert_eq!(spread(0, place), 0.0);
            for trial in 1..TRIALS {
                let here = spread(trial, place);
                assert!(here.abs() < 1.0);
                assert!((0..place).all(|other| (spread(trial, other) - here).abs() > 1e-9));
            }
        }
    }
}
