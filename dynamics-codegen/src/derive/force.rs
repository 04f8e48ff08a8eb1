//! Stated and dissipative forces, split by what the inputs contribute.

use super::reading::Readings;
use crate::graph::ExprId;
use crate::model::Model;
use std::collections::HashMap;

pub(super) struct Forces {
    pub applied_force: Vec<ExprId>,
    pub input_matrix: Vec<Vec<ExprId>>,
    pub total: Vec<ExprId>,
}

/// `Q_D(q, v, z, t)` and `B = ∂Q/∂u`, with `Q_D` the stated forces at `u = 0` (delayed
/// inputs count as further inputs)
/// and `−∂R/∂v` of the Rayleigh function `R`.
pub(super) fn forces(model: &mut Model, readings: &Readings) -> Forces {
    let velocities: Vec<_> = model.coordinates.iter().map(|c| c.velocity).collect();
    let inputs = model.input_symbols();
    // The Rayleigh function is differentiated by velocities: readings go first.
    let dissipation = readings.resolve(model, &[model.dissipation])[0];
    let mut stated = readings.resolve(model, &model.forces.clone());
    for (stated, force) in stated.iter_mut().zip(readings.point_forces(model)) {
        *stated = model.graph.add(*stated, force);
    }
    let stated = readings.resolve(model, &stated);
    let graph = &mut model.graph;
    let total: Vec<ExprId> = stated
        .iter()
        .zip(&velocities)
        .map(|(&force, &v)| {
            let slope = graph.derivatives(&[dissipation], v)[0];
            graph.sub(force, slope)
        })
        .collect();
    let input_matrix = graph.jacobian(&total, &inputs);
    let zero = graph.zero();
    let at_rest: HashMap<_, _> = inputs.iter().map(|&u| (u, zero)).collect();
    let applied_force = graph.substitute(&total, &at_rest);
    Forces {
        applied_force,
        input_matrix,
        total,
    }
}
