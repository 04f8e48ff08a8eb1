//! Constraints on acceleration level [3.28, 3.29, corrected: MATH section 3].

use crate::graph::ExprId;
use crate::model::{ConstraintKind, Model};

pub(super) struct Row {
    pub jacobian: Vec<ExprId>,
    pub bias: ExprId,
    pub residual: ExprId,
    pub rate: ExprId,
}

/// Holonomic `c(q,t)`: `A = ∂c/∂q`, `b = A a − c̈`. Nonholonomic `c(q,v,t)`:
/// `A = ∂c/∂v`, `b = −(∂c/∂q) v − ∂c/∂t`.
pub(super) fn row(model: &mut Model, index: usize) -> Row {
    let constraint = &model.constraints[index];
    let (kind, residual) = (constraint.kind, constraint.residual);
    let symbols: Vec<_> = model
        .coordinates
        .iter()
        .map(|c| match kind {
            ConstraintKind::Holonomic => c.position,
            ConstraintKind::Nonholonomic => c.velocity,
        })
        .collect();
    let seeds = model.time_seeds();
    let graph = &mut model.graph;
    let jacobian = symbols
        .iter()
        .map(|&s| graph.derivatives(&[residual], s)[0])
        .collect();
    // The part of the last time derivative that holds no acceleration is −b.
    let rate = match kind {
        ConstraintKind::Holonomic => graph.directional(&[residual], &seeds)[0],
        ConstraintKind::Nonholonomic => residual,
    };
    let drift = graph.directional(&[rate], &seeds)[0];
    let bias = graph.neg(drift);
    Row {
        jacobian,
        bias,
        residual,
        rate,
    }
}
