//! What the parameters of an effect do: strengths, and what gives these their shape.

use dynamics_codegen::Compiled;
use dynamics_codegen::graph::{ExprId, SymbolId};
use dynamics_codegen::model::Model;
use std::collections::HashMap;

/// What a parameter of an effect does when it alone leaves its default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// It changes the motion at once.
    Strength,
    /// It changes the motion, but not to first order, as a centre of mass that leaves an axis:
    /// nothing to begin with, and nothing to be chosen freely.
    Curved,
    /// It changes what strengths do, once they have left theirs.
    Shape,
    /// It changes nothing, whatever the others are.
    Inert,
}

/// A model whose parameters leave their defaults one by one.
pub(crate) struct Roles {
    model: Model,
    /// The terms of the equation of motion; those behind `moving` say how states go on.
    terms: Vec<ExprId>,
    moving: usize,
    /// Every parameter at its default.
    defaults: HashMap<SymbolId, ExprId>,
    symbols: Vec<SymbolId>,
}

impl Roles {
    /// Of a model's parameters about `defaults`, one value each, as motion and those sensors show
    /// it that are `seen`, by their places.
    pub fn new(compiled: &Compiled, defaults: &[f64], seen: impl Fn(usize) -> bool) -> Self {
        let mut model = compiled.model.clone();
        let system = &compiled.system;
        let mut terms = system.force.clone();
        terms.extend(system.mass_matrix.iter().flatten());
        terms.extend(system.constraint_matrix.iter().flatten());
        terms.extend(&system.constraint_bias);
        terms.extend(&system.constraint_residual);
        terms.extend(&system.measured);
        for (place, &sensor) in system.sensors.iter().enumerate() {
            if seen(place) {
                terms.extend([sensor, system.sensor_leads[place]]);
            }
        }
        terms.extend(&system.state_rates);
        terms.extend(&system.initial_states);
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let pairs = symbols.iter().zip(defaults);
        let defaults = pairs.map(|(&symbol, &value)| (symbol, model.graph.constant(value)));
        Self {
            defaults: defaults.collect(),
            // What a state owes to a parameter only shows where the state does something.
            moving: terms.len() - system.state_rates.len() * 2,
            model,
            terms,
            symbols,
        }
    }

    /// The roles of one effect's parameters.
    pub fn of(&mut self, own: &[usize]) -> Vec<Role> {
        let mut roles: Vec<Role> = own.iter().map(|&index| self.alone(index)).collect();
        // A load at the axis of its link does nothing to first order, wherever the default puts
        // it: what makes all of its other parameters meaningless is its strength all the same.
        if own.len() > 1 && !roles.contains(&Role::Strength) {
            for (&index, role) in own.iter().zip(&mut roles) {
                if *role == Role::Shape && self.switches_off(index, own) {
                    *role = Role::Strength;
                }
            }
        }
        roles
    }

    /// Whether forces and inertias are linear in these parameters together.
    pub fn is_linear(&mut self, strengths: &[usize]) -> bool {
        strengths.iter().all(|&strength| {
            let slopes = self.slopes(strength);
            let mut others = strengths.iter().map(|&other| self.symbols[other]);
            others.all(|other| !self.model.graph.depends_on(&slopes[..self.moving], other))
        })
    }

    /// Whether what a parameter does to forces depends on where a coordinate is, by its symbol.
    pub fn acts_by_place(&mut self, index: usize, position: SymbolId) -> bool {
        let slopes = self.slopes(index);
        self.model
            .graph
            .depends_on(&slopes[..self.moving], position)
    }

    fn slopes(&mut self, index: usize) -> Vec<ExprId> {
        let seeds = self.model.parameter_seeds(self.symbols[index]);
        self.model.graph.directional(&self.terms, &seeds)
    }

    /// Whether some of the slopes that move the machine are not zero with these values.
    fn shows(&mut self, slopes: &[ExprId], values: &HashMap<SymbolId, ExprId>) -> bool {
        let graph = &mut self.model.graph;
        let slopes = graph.substitute(&slopes[..self.moving], values);
        slopes.iter().any(|&slope| !graph.is_zero(slope))
    }

    fn alone(&mut self, index: usize) -> Role {
        let slopes = self.slopes(index);
        let defaults = self.defaults.clone();
        if self.shows(&slopes, &defaults) {
            return Role::Strength;
        }
        let mut others = defaults;
        others.remove(&self.symbols[index]);
        if self.shows(&slopes, &others) {
            return Role::Curved;
        }
        match slopes.iter().any(|&slope| !self.model.graph.is_zero(slope)) {
            true => Role::Shape,
            false => Role::Inert,
        }
    }

    /// Whether one parameter at its default makes the effect's others meaningless.
    fn switches_off(&mut self, switch: usize, own: &[usize]) -> bool {
        let mut off = self.defaults.clone();
        for &index in own.iter().filter(|&&index| index != switch) {
            off.remove(&self.symbols[index]);
        }
        let mut others = own.iter().filter(|&&index| index != switch);
        others.all(|&other| {
            let slopes = self.slopes(other);
            !self.shows(&slopes, &off)
        })
    }
}
