//! Derivatives for trees with a floating body, by forward mode on the graph.
//!
//! A quaternion's four coordinates are redundant: the equations of motion are
//! functions on the unit sphere, and how a formula continues them off it is an
//! accident of the formula. The derivatives here are right along every change
//! that keeps the quaternion a unit (`ηᵀδη = 0`); along `η` itself they mean
//! nothing, nor do those of any other formula.

use super::mechanism::Mechanism;
use super::sensitivity::{ForwardDerivatives, InverseDerivatives, transposed};
use super::space::Space;
use crate::graph::{ExprId, Graph, SymbolId};
use std::collections::HashMap;

/// `∂τ/∂(q, v)` at fixed `a`.
pub(super) fn inverse(
    mechanism: &Mechanism,
    g: &mut Graph,
    acceleration: &[ExprId],
) -> InverseDerivatives {
    let placeholder = Placeholder::new(g, acceleration);
    let forces = mechanism.inverse_dynamics(g, &placeholder.variables);
    let mut by = |symbols: Vec<SymbolId>| {
        let columns: Vec<Vec<ExprId>> = (symbols.into_iter())
            .map(|symbol| placeholder.derivative(g, &forces, symbol))
            .collect();
        transposed(&columns)
    };
    InverseDerivatives {
        position: by(positions(mechanism)),
        velocity: by(velocities(mechanism)),
    }
}

/// `∂a/∂(q, v, Q)`: with quasi-accelerations `α`, inverse dynamics `τ(q, v, α)`
/// and `a = T α + d`, `∂a = ∂T α + ∂d + T M⁻¹ (∂Q − ∂τ)`.
pub(super) fn forward(
    mechanism: &Mechanism,
    g: &mut Graph,
    force: &[ExprId],
) -> ForwardDerivatives {
    let quasi = Space::quasi(g, mechanism);
    let factor = mechanism.quasi_factor(g, &quasi);
    let rest = vec![g.zero(); mechanism.coordinates];
    let bias = mechanism.quasi_inverse_dynamics(g, &quasi, &rest);
    let applied = mechanism.to_quasi(g, force);
    let load: Vec<ExprId> = (applied.iter().zip(&bias))
        .map(|(&applied, &bias)| g.sub(applied, bias))
        .collect();
    let alpha = factor.solve(g, &load);

    let placeholder = Placeholder::new(g, &alpha);
    let given = Placeholder::new(g, force);
    let needed = mechanism.quasi_inverse_dynamics(g, &quasi, &placeholder.variables);
    let applied = mechanism.to_quasi(g, &given.variables);
    let residual: Vec<ExprId> = (needed.iter().zip(&applied))
        .map(|(&needed, &applied)| g.sub(needed, applied))
        .collect();
    let turned = mechanism.of_quasi(g, &placeholder.variables);
    let drift = mechanism.quaternion_drift(g);
    let outer: Vec<ExprId> = (turned.iter().zip(&drift))
        .map(|(&turned, &drift)| g.add(turned, drift))
        .collect();

    let mut by = |symbols: Vec<SymbolId>| {
        let mut columns = Vec::with_capacity(symbols.len());
        for symbol in symbols {
            let slopes = placeholder.derivative(g, &residual, symbol);
            let slopes = given.fill(g, &slopes);
            let inner = factor.solve_negative(g, &slopes);
            let inner = mechanism.of_quasi(g, &inner);
            let direct = placeholder.derivative(g, &outer, symbol);
            let column = (inner.iter().zip(&direct)).map(|(&x, &y)| g.add(x, y));
            columns.push(column.collect());
        }
        transposed(&columns)
    };
    let (position, velocity) = (by(positions(mechanism)), by(velocities(mechanism)));
    let columns: Vec<Vec<ExprId>> = (0..mechanism.coordinates)
        .map(|j| {
            let mut unit = rest.clone();
            unit[j] = g.one();
            let unit = mechanism.to_quasi(g, &unit);
            let column = factor.solve(g, &unit);
            mechanism.of_quasi(g, &column)
        })
        .collect();
    ForwardDerivatives {
        acceleration: placeholder.fill(g, &outer),
        position,
        velocity,
        force: transposed(&columns),
    }
}

/// Variables that stand for expressions while something is differentiated that
/// must not see into them.
struct Placeholder {
    variables: Vec<ExprId>,
    values: HashMap<SymbolId, ExprId>,
}

impl Placeholder {
    fn new(g: &mut Graph, values: &[ExprId]) -> Self {
        let symbols: Vec<SymbolId> = values.iter().map(|_| g.symbol("held")).collect();
        Self {
            variables: symbols.iter().map(|&symbol| g.var(symbol)).collect(),
            values: symbols.into_iter().zip(values.iter().copied()).collect(),
        }
    }

    fn fill(&self, g: &mut Graph, outputs: &[ExprId]) -> Vec<ExprId> {
        g.substitute(outputs, &self.values)
    }

    fn derivative(&self, g: &mut Graph, outputs: &[ExprId], symbol: SymbolId) -> Vec<ExprId> {
        let slopes = g.derivatives(outputs, symbol);
        self.fill(g, &slopes)
    }
}

fn positions(mechanism: &Mechanism) -> Vec<SymbolId> {
    mechanism
        .symbols
        .iter()
        .flatten()
        .map(|symbols| symbols.0)
        .collect()
}

fn velocities(mechanism: &Mechanism) -> Vec<SymbolId> {
    mechanism
        .symbols
        .iter()
        .flatten()
        .map(|symbols| symbols.1)
        .collect()
}
