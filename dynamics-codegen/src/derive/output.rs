//! Outputs: value, rate, Jacobian and `J̇ v`.

use super::constraint;
use super::reading::Readings;
use crate::graph::ExprId;
use crate::model::{ConstraintKind, Model};

pub(super) struct Outputs {
    pub values: Vec<ExprId>,
    pub rates: Vec<ExprId>,
    pub positional: Vec<usize>,
    pub jacobian: Vec<Vec<ExprId>>,
    pub bias: Vec<ExprId>,
}

/// An output of positions and time has a Jacobian, as a constraint has; one that
/// contains velocities, inputs or states has not.
pub(super) fn outputs(model: &mut Model, readings: &Readings) -> Outputs {
    let values: Vec<ExprId> = model.outputs.iter().map(|output| output.value).collect();
    let mut inputs = model.input_symbols();
    inputs.extend(model.states.iter().map(|z| z.symbol));
    let seeds = model.time_seeds();
    let rates = model.graph.directional(&values, &seeds);
    let mut outputs = Outputs {
        rates: readings.resolve(model, &rates),
        values: readings.resolve(model, &values),
        positional: Vec::new(),
        jacobian: Vec::new(),
        bias: Vec::new(),
    };
    for (index, value) in values.into_iter().enumerate() {
        let mut inputs = inputs.iter();
        if model.contains_velocity(value) || inputs.any(|&u| model.graph.depends_on(&[value], u)) {
            continue;
        }
        let row = constraint::row(model, readings, value, ConstraintKind::Holonomic);
        outputs.positional.push(index);
        outputs.jacobian.push(row.jacobian);
        outputs.bias.push(model.graph.neg(row.bias));
    }
    outputs
}
