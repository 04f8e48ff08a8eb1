//! Constraints and outputs along the motion (thesis 3.28, 3.29; `docs/errata.md`).

use super::reading::Readings;
use crate::graph::{ExprId, Unary};
use crate::model::{ConstraintKind, Model};

pub(super) struct Row {
    pub jacobian: Vec<ExprId>,
    pub bias: ExprId,
    pub residual: ExprId,
    pub rate: ExprId,
}

/// Holonomic `c(q,t)`: `A = ∂c/∂q`, `b = A a − c̈`. Nonholonomic `c(q,v,t)`:
/// `A = ∂c/∂v`, `b = −(∂c/∂q) v − ∂c/∂t`.
pub(super) fn row(
    model: &mut Model,
    readings: &Readings,
    residual: ExprId,
    kind: ConstraintKind,
) -> Row {
    let nonholonomic = kind == ConstraintKind::Nonholonomic;
    let mut jacobian = readings.jacobian(model, residual, nonholonomic);
    // The part of the last time derivative that holds no acceleration is −b.
    let rate = if nonholonomic {
        residual
    } else {
        along_the_motion(model, residual)
    };
    let drift = along_the_motion(model, rate);
    let bias = model.graph.neg(drift);
    jacobian.extend([bias, residual, rate]);
    let mut resolved = readings.resolve(model, &jacobian);
    let [bias, residual, rate] = [2, 1, 0].map(|back| resolved[resolved.len() - 1 - back]);
    resolved.truncate(resolved.len() - 3);
    Row {
        jacobian: resolved,
        bias,
        residual,
        rate,
    }
}

/// A row that is null, residual and all, where `active` is not positive.
pub(super) fn switched(model: &mut Model, readings: &Readings, row: Row, active: ExprId) -> Row {
    let active = readings.resolve(model, &[active])[0];
    let graph = &mut model.graph;
    let there = graph.unary(Unary::Step, active);
    Row {
        jacobian: row
            .jacobian
            .iter()
            .map(|&entry| graph.mul(there, entry))
            .collect(),
        bias: graph.mul(there, row.bias),
        residual: graph.mul(there, row.residual),
        rate: graph.mul(there, row.rate),
    }
}

/// `d/dt` at `a = 0`, readings of frames as symbols.
fn along_the_motion(model: &mut Model, expr: ExprId) -> ExprId {
    let seeds = model.time_seeds();
    model.graph.directional(&[expr], &seeds)[0]
}
