//! Derivatives of the equation of motion at fixed acceleration and multipliers.
//!
//! `a` and `λ` solve `K [a; −λ] = [Q; b]` with `K = [[M, Aᵀ], [A, 0]]`. For any
//! input `s`, `K ∂[a; −λ]/∂s = −∂[R; S]/∂s`, with the residuals
//! `R = M a − Q − Aᵀλ` and `S = A a − b` differentiated at fixed `a, λ`: first
//! derivatives only, no derivative of an inverse.

use super::reading::Readings;
use super::{System, force, inertial};
use crate::graph::{ExprId, SymbolId};
use crate::model::Model;
use std::collections::HashSet;

/// What to differentiate by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variable {
    /// The position of a coordinate.
    Position(usize),
    /// The velocity of a coordinate.
    Velocity(usize),
    /// An input.
    Input(usize),
    /// An input as it was some time ago.
    Delayed(usize),
    /// A state.
    State(usize),
    /// A state as it is when the motion begins: what follows from it later, through the states'
    /// own equations.
    Beginning(usize),
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
            Self::Delayed(index) => model.delays[index].symbol,
            Self::State(index) | Self::Beginning(index) => model.states[index].symbol,
            Self::Parameter(index) => model.parameters[index].symbol,
            Self::Time => model.time,
        }
    }

    /// What changes with it at once: itself by one; of the position of a twist's component, which no
    /// expression contains, the pose by a displacement along that component; nothing with how a
    /// state began.
    pub fn displacement(self, model: &mut Model) -> Vec<(SymbolId, ExprId)> {
        match self {
            Self::Position(index) => model.displacement(index),
            Self::Beginning(_) => Vec::new(),
            _ => vec![(self.symbol(model), model.graph.one())],
        }
    }

    /// The same, and the delayed inputs whose delay it changes.
    fn seeds(self, model: &mut Model) -> Vec<(SymbolId, ExprId)> {
        match self {
            Self::Parameter(_) => {
                let symbol = self.symbol(model);
                model.parameter_seeds(symbol)
            }
            _ => self.displacement(model),
        }
    }
}

/// What a state owes to a parameter, or to how a state began: `w = ∂z/∂p` along the motion, with
/// `dw/dt = ∂f/∂z · w + ∂f/∂p`. A variable of the derivatives, whose value follows from
/// the past.
#[derive(Debug, Clone, Copy)]
pub struct StateSlope {
    /// Index of the state.
    pub state: usize,
    /// Index into the variables that the derivatives are taken by.
    pub variable: usize,
    /// The symbol that stands for `w`.
    pub symbol: SymbolId,
    /// `∂f/∂p`, with delayed inputs following `p` and the other states' `w` in it.
    pub drive: ExprId,
    /// `∂z/∂p` at the beginning.
    pub initial: ExprId,
}

/// The slopes that are not identically zero.
fn state_slopes(model: &mut Model, system: &System, variables: &[Variable]) -> Vec<StateSlope> {
    let mut slopes = Vec::new();
    let moved_by: Vec<HashSet<SymbolId>> = (0..model.states.len())
        .map(|state| {
            let mut all = vec![system.state_rates[state], system.initial_states[state]];
            let others = model.states_in(model.states[state].rate);
            all.extend(others.iter().map(|&z| system.state_rates[z]));
            model.graph.symbols_in(&all)
        })
        .collect();
    for (index, &variable) in variables.iter().enumerate() {
        let (name, begun) = match variable {
            Variable::Parameter(parameter) => (model.parameters[parameter].name.clone(), None),
            Variable::Beginning(state) => {
                (format!("{}_begun", model.states[state].name), Some(state))
            }
            _ => continue,
        };
        let mut seeds = variable.seeds(model);
        let own = begun.map(|state| model.states[state].symbol);
        let symbols: Vec<SymbolId> = seeds.iter().map(|(symbol, _)| *symbol).chain(own).collect();
        let moved: Vec<usize> = (0..model.states.len())
            .filter(|&state| {
                begun == Some(state) || symbols.iter().any(|s| moved_by[state].contains(s))
            })
            .collect();
        let own: Vec<SymbolId> = moved
            .iter()
            .map(|&z| format!("d{}_d{name}", model.states[z].name))
            .collect::<Vec<_>>()
            .into_iter()
            .map(|name| model.graph.symbol(name))
            .collect();
        let direct = seeds.clone();
        for (&state, &symbol) in moved.iter().zip(&own) {
            seeds.push((model.states[state].symbol, model.graph.var(symbol)));
        }
        for (&state, &symbol) in moved.iter().zip(&own) {
            let (rate, initial) = (system.state_rates[state], system.initial_states[state]);
            let z = model.states[state].symbol;
            let others: Vec<_> = seeds.iter().copied().filter(|(s, _)| *s != z).collect();
            let graph = &mut model.graph;
            slopes.push(StateSlope {
                state,
                variable: index,
                symbol,
                drive: graph.directional(&[rate], &others)[0],
                initial: match begun == Some(state) {
                    true => graph.one(),
                    false => graph.directional(&[initial], &direct)[0],
                },
            });
        }
    }
    slopes
}

/// The residuals' derivatives, as functions of the system's arguments, `a` and `λ`.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    /// The symbols that stand for `a`, `n`.
    pub acceleration: Vec<SymbolId>,
    /// The symbols that stand for `λ`, `m`.
    pub multiplier: Vec<SymbolId>,
    /// The symbols that stand for `u̇(t − τ)`, one per delay.
    pub delay_rates: Vec<SymbolId>,
    /// What states owe to parameters, and to how states began.
    pub memory: Vec<StateSlope>,
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
        let multiplier = model.multiplier_symbols();
        let memory = state_slopes(model, system, variables);
        let residuals = residuals(model, system, &acceleration, &multiplier);
        let columns = variables
            .iter()
            .enumerate()
            .map(|(index, &variable)| {
                let mut seeds = variable.seeds(model);
                for slope in memory.iter().filter(|slope| slope.variable == index) {
                    let state = model.states[slope.state].symbol;
                    seeds.push((state, model.graph.var(slope.symbol)));
                }
                model.graph.directional(&residuals, &seeds)
            })
            .collect();
        Self {
            acceleration,
            multiplier,
            delay_rates: model.delays.iter().map(|d| d.rate).collect(),
            memory,
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
    residuals_from(model, system, &needed, &a, &lambda)
}

/// The residuals, with `M a − Q_C` given.
pub(super) fn residuals_from(
    model: &mut Model,
    system: &System,
    needed: &[ExprId],
    a: &[ExprId],
    lambda: &[ExprId],
) -> Vec<ExprId> {
    let readings = Readings::new(model);
    let applied = force::forces(model, &readings).total;
    let graph = &mut model.graph;
    let mut residuals = Vec::with_capacity(a.len() + lambda.len());
    for i in 0..a.len() {
        let column: Vec<ExprId> = system.constraint_matrix.iter().map(|row| row[i]).collect();
        let constraint_force = graph.inner_product(&column, lambda);
        let forces = graph.add(applied[i], constraint_force);
        residuals.push(graph.sub(needed[i], forces));
    }
    for (row, &b) in system.constraint_matrix.iter().zip(&system.constraint_bias) {
        let demanded = graph.inner_product(row, a);
        residuals.push(graph.sub(demanded, b));
    }
    residuals
}
