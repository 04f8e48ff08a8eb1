//! What the symbols for readings of frames stand for, and their Jacobians.

use crate::graph::ExprId;
use crate::model::{Kinematic, Model, Reading};
use crate::tree::{Frame, Mechanism};
use std::collections::HashMap;

/// The readings of a model, from the kinematics of its tree.
pub(super) struct Readings {
    mechanism: Option<Mechanism>,
}

impl Readings {
    pub fn new(model: &Model) -> Self {
        Self {
            mechanism: model.mechanism.clone(),
        }
    }

    /// Puts the kinematics in place of the symbols.
    pub fn resolve(&self, model: &mut Model, exprs: &[ExprId]) -> Vec<ExprId> {
        let Some(mechanism) = &self.mechanism else {
            return exprs.to_vec();
        };
        let mut values = HashMap::new();
        for kinematic in model.kinematics.clone() {
            let Kinematic {
                symbol, reading, ..
            } = kinematic;
            let graph = &mut model.graph;
            if !graph.depends_on(exprs, symbol) {
                continue;
            }
            let frame = Frame::of_body(graph, kinematic.frame);
            let value = match reading {
                Reading::Position(i) => mechanism.pose(graph, &frame).position[i],
                Reading::Axis(axis, i) => mechanism.pose(graph, &frame).rotation[i][axis],
                Reading::Velocity(i) => mechanism.velocity(graph, &frame)[i],
                Reading::AngularVelocity(i) => mechanism.velocity(graph, &frame)[3 + i],
                Reading::AccelerationBias(i) => {
                    mechanism.jacobian_rate_times_velocity(graph, &frame)[i]
                }
                Reading::AngularAccelerationBias(i) => {
                    mechanism.jacobian_rate_times_velocity(graph, &frame)[3 + i]
                }
                Reading::Acceleration(i) => acceleration(model, mechanism, &frame, i),
                Reading::AngularAcceleration(i) => acceleration(model, mechanism, &frame, 3 + i),
            };
            values.insert(symbol, value);
        }
        if values.is_empty() {
            return exprs.to_vec();
        }
        model.graph.substitute(exprs, &values)
    }

    /// `∂e/∂q` for an expression of positions, or `∂e/∂v` for one of velocities:
    /// directly, and through the Jacobians of the frames that it reads.
    pub fn jacobian(&self, model: &mut Model, expr: ExprId, velocities: bool) -> Vec<ExprId> {
        let mut row: Vec<ExprId> = (0..model.coordinates.len())
            .map(|index| {
                let seeds = if velocities {
                    vec![(model.coordinates[index].velocity, model.graph.one())]
                } else {
                    model.displacement(index)
                };
                model.graph.directional(&[expr], &seeds)[0]
            })
            .collect();
        let Some(mechanism) = &self.mechanism else {
            return row;
        };
        for kinematic in model.kinematics.clone() {
            let Kinematic {
                symbol, reading, ..
            } = kinematic;
            let graph = &mut model.graph;
            if reading.is_positional() == velocities || !graph.depends_on(&[expr], symbol) {
                continue;
            }
            let slope = graph.derivatives(&[expr], symbol)[0];
            let frame = Frame::of_body(graph, kinematic.frame);
            let jacobian = mechanism.jacobian(graph, &frame);
            for (column, entry) in row.iter_mut().enumerate() {
                let along = match reading {
                    Reading::Position(i) | Reading::Velocity(i) => jacobian[i][column],
                    Reading::AngularVelocity(i) => jacobian[3 + i][column],
                    // δaxis = δφ × axis
                    Reading::Axis(axis, i) => {
                        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                        let rotation = mechanism.pose(graph, &frame).rotation;
                        let plus = graph.mul(jacobian[3 + j][column], rotation[k][axis]);
                        let minus = graph.mul(jacobian[3 + k][column], rotation[j][axis]);
                        graph.sub(plus, minus)
                    }
                    Reading::AccelerationBias(_)
                    | Reading::AngularAccelerationBias(_)
                    | Reading::Acceleration(_)
                    | Reading::AngularAcceleration(_) => continue,
                };
                let part = graph.mul(slope, along);
                *entry = graph.add(*entry, part);
            }
        }
        row
    }

    /// `Σ Jᵀ F` of the model's forces and torques at frames.
    pub fn point_forces(&self, model: &mut Model) -> Vec<ExprId> {
        let mut total = vec![model.graph.zero(); model.coordinates.len()];
        let Some(mechanism) = &self.mechanism else {
            return total;
        };
        for force in model.point_forces.clone() {
            let graph = &mut model.graph;
            let frame = Frame::of_body(graph, force.frame);
            let jacobian = mechanism.jacobian(graph, &frame);
            let first = if force.torque { 3 } else { 0 };
            for (column, entry) in total.iter_mut().enumerate() {
                for (row, &component) in jacobian[first..first + 3].iter().zip(&force.value) {
                    let part = graph.mul(row[column], component);
                    *entry = graph.add(*entry, part);
                }
            }
        }
        total
    }
}

/// A component of `J a + J̇ v`.
fn acceleration(model: &mut Model, mechanism: &Mechanism, frame: &Frame, row: usize) -> ExprId {
    let graph = &mut model.graph;
    let bias = mechanism.jacobian_rate_times_velocity(graph, frame)[row];
    let jacobian = mechanism.jacobian(graph, frame);
    let a: Vec<ExprId> = model.accelerations.iter().map(|&a| graph.var(a)).collect();
    let own = graph.inner_product(&jacobian[row], &a);
    graph.add(bias, own)
}
