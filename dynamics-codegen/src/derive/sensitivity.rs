//! Derivatives of the equation of motion at fixed acceleration and multipliers.
//!
//! `a` and `λ` solve `K [a; −λ] = [Q; b]` with `K = [[M, Aᵀ], [A, 0]]`. For any
//! input `s`, `K ∂[a; −λ]/∂s = −∂[R; S]/∂s`, with the residuals
//! `R = M a − Q − Aᵀλ` and `S = A a − b` differentiated at fixed `a, λ`: first
//! derivatives only, no derivative of an inverse (MATH section 4).

use super::reading::Readings;
use super::{System, force, inertial};
use crate::graph::{ExprId, SymbolId};
use crate::model::Model;

/// What to differentiate by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variable {
    /// The position of a coordinate.
    Position(usize),
    /// The velocity of a coordinate.
    Velocity(usize),
    /// An input.
    Input(usize),
    /// A parameter.
    Parameter(usize),
    /// Time.
    Time,
}

impl Variable {
    /// Its symbol.
    pub fn symbol(self, model: &Model) -> SymbolId {
        match self {
            Self::Position(index) => model.coordinates[index].position,
            Self::Velocity(index) => model.coordinates[index].velocity,
            Self::Input(index) => model.inputs[index].symbol,
            Self::Parameter(index) => model.parameters[index].symbol,
            Self::Time => model.time,
        }
    }
}

/// The residuals' derivatives, as functions of the system's arguments, `a` and `λ`.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    /// The symbols that stand for `a`, `n`.
    pub acceleration: Vec<SymbolId>,
    /// The symbols that stand for `λ`, `m`.
    pub multiplier: Vec<SymbolId>,
    /// Per variable: `∂R/∂s` (`n`), then `∂S/∂s` (`m`).
    pub columns: Vec<Vec<ExprId>>,
}

impl Sensitivity {
    /// Differentiates the residuals by each of `variables`.
    pub fn new(model: &mut Model, system: &System, variables: &[Variable]) -> Self {
        let acceleration: Vec<SymbolId> = (0..model.coordinates.len())
            .map(|i| {
                let name = format!("ddq_{}", model.coordinates[i].name);
                model.graph.symbol(name)
            })
            .collect();
        let multiplier: Vec<SymbolId> = (0..model.constraints.len())
            .map(|k| {
                let name = format!("lambda_{}", model.constraints[k].name);
                model.graph.symbol(name)
            })
            .collect();
        let symbols: Vec<SymbolId> = variables.iter().map(|v| v.symbol(model)).collect();
        let residuals = residuals(model, system, &acceleration, &multiplier);
        let columns = symbols
            .iter()
            .map(|&symbol| model.graph.derivatives(&residuals, symbol))
            .collect();
        Self {
            acceleration,
            multiplier,
            columns,
        }
    }
}

/// `R = M a − Q − Aᵀλ` (`n`), then `S = A a − b` (`m`).
fn residuals(
    model: &mut Model,
    system: &System,
    acceleration: &[SymbolId],
    multiplier: &[SymbolId],
) -> Vec<ExprId> {
    let graph = &model.graph;
    let a: Vec<ExprId> = acceleration.iter().map(|&s| graph.var(s)).collect();
    let lambda: Vec<ExprId> = multiplier.iter().map(|&s| graph.var(s)).collect();
    let readings = Readings::new(model);
    let needed = inertial::inverse(model, &readings, &a);
    let applied = force::forces(model, &readings).total;
    let graph = &mut model.graph;
    let mut residuals = Vec::with_capacity(a.len() + lambda.len());
    for i in 0..a.len() {
        let column: Vec<ExprId> = system.constraint_matrix.iter().map(|row| row[i]).collect();
        let constraint_force = graph.inner_product(&column, &lambda);
        let forces = graph.add(applied[i], constraint_force);
        residuals.push(graph.sub(needed[i], forces));
    }
    for (row, &b) in system.constraint_matrix.iter().zip(&system.constraint_bias) {
        let demanded = graph.inner_product(row, &a);
        residuals.push(graph.sub(demanded, b));
    }
    residuals
}
