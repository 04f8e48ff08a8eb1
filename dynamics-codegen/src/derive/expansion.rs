//! A model's graph, grown by what functions are asked to compute.
//!
//! The motion and its derivatives come out as straight lines: `M` is factored on the
//! graph, and `K ∂[a; −λ]/∂s = −∂[R; S]/∂s` is solved with the same factors, where
//! `R` and `S` are differentiated at fixed `a, λ` (MATH section 4).

use super::sensitivity::residuals;
use super::{Group, Item, System, Term};
use crate::compile::Compiled;
use crate::graph::{ExprId, Node, SymbolId};
use crate::model::Model;
use crate::tree::Factor;
use std::collections::{BTreeMap, HashMap};

/// Why a model has no such function.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ItemError {
    /// It would have no entry.
    #[error("`{item}` is empty: the model has no {lacks}")]
    Empty {
        /// The function's name.
        item: String,
        /// What there is none of.
        lacks: &'static str,
    },
    /// A pivot of `M`, or of `A M⁻¹ Aᵀ`, is zero whatever the state.
    #[error(
        "`{item}` does not exist: the mass matrix is singular, or the constraints are redundant, at every state; solve at run time instead (`dynamics::acceleration`)"
    )]
    Singular {
        /// The function's name.
        item: String,
    },
}

/// A copy of a model that derives items when they are asked for.
#[derive(Debug, Clone)]
pub struct Expansion {
    /// The model; its graph holds the items.
    pub model: Model,
    system: System,
    /// The symbols that stand for `a`.
    pub acceleration: Vec<SymbolId>,
    /// The symbols that stand for `λ`.
    pub multipliers: Vec<SymbolId>,
    known: BTreeMap<Item, Vec<ExprId>>,
}

/// The motion on the graph, and what solves for its derivatives.
struct Motion {
    factor: Factor,
    acceleration: Vec<ExprId>,
    multipliers: Vec<ExprId>,
}

impl Expansion {
    /// Of a compiled model.
    pub fn new(compiled: &Compiled) -> Self {
        let (mut model, system) = (compiled.model.clone(), compiled.system.clone());
        let acceleration = (0..model.coordinates.len())
            .map(|i| {
                let name = format!("ddq_{}", model.coordinates[i].name);
                model.graph.symbol(name)
            })
            .collect();
        let multipliers = (0..model.constraints.len())
            .map(|k| {
                let name = format!("lambda_{}", model.constraints[k].name);
                model.graph.symbol(name)
            })
            .collect();
        Self {
            model,
            system,
            acceleration,
            multipliers,
            known: BTreeMap::new(),
        }
    }

    /// The entries of an item: rows, then columns, then what it is differentiated by.
    ///
    /// # Errors
    /// If there is no entry, or if a factor is singular at every state.
    pub fn entries(&mut self, item: Item) -> Result<Vec<ExprId>, ItemError> {
        if let Some(known) = self.known.get(&item) {
            return Ok(known.clone());
        }
        if let Some(lacks) = self.lacks(item) {
            let item = item.to_string();
            return Err(ItemError::Empty { item, lacks });
        }
        let entries = match item.by {
            None => self.value(item.term),
            Some(group) => self.slope(item.term, group),
        };
        let solved = matches!(
            item.term,
            Term::ForwardDynamics | Term::ConstrainedAcceleration | Term::ConstrainedMultipliers
        );
        let reachable = self.model.graph.reachable(&entries);
        let finite = |expr| match self.model.graph.node(expr) {
            Node::Constant(bits) => f64::from_bits(bits).is_finite(),
            _ => true,
        };
        if solved && !reachable.iter().all(finite) {
            let item = item.to_string();
            return Err(ItemError::Singular { item });
        }
        self.known.insert(item, entries.clone());
        Ok(entries)
    }

    /// What an item would need one of.
    fn lacks(&self, item: Item) -> Option<&'static str> {
        let term = match item.term {
            Term::InputMatrix if self.model.inputs.is_empty() => Some("input"),
            Term::Outputs | Term::OutputRates if self.model.outputs.is_empty() => Some("output"),
            Term::ConstraintJacobian
            | Term::ConstraintBias
            | Term::ConstraintResidual
            | Term::ConstraintRate
            | Term::ConstrainedAcceleration
            | Term::ConstrainedMultipliers
            | Term::AccelerationResidual
                if self.model.constraints.is_empty() =>
            {
                Some("constraint")
            }
            _ if self.model.coordinates.is_empty() => Some("coordinate"),
            _ => None,
        };
        term.or(match item.by {
            Some(Group::Input) if self.model.inputs.is_empty() => Some("input"),
            Some(Group::Parameters) if self.model.parameters.is_empty() => Some("parameter"),
            _ => None,
        })
    }

    fn value(&mut self, term: Term) -> Vec<ExprId> {
        let system = &self.system;
        match term {
            Term::MassMatrix => system.mass_matrix.concat(),
            Term::BiasForce => system.bias_force.clone(),
            Term::AppliedForce => system.applied_force.clone(),
            Term::InputMatrix => system.input_matrix.concat(),
            Term::Force => system.force.clone(),
            Term::ConstraintJacobian => system.constraint_matrix.concat(),
            Term::ConstraintBias => system.constraint_bias.clone(),
            Term::ConstraintResidual => system.constraint_residual.clone(),
            Term::ConstraintRate => system.constraint_rate.clone(),
            Term::Outputs => system.outputs.clone(),
            Term::OutputRates => system.output_rates.clone(),
            Term::InverseDynamics => self.inverse_dynamics(),
            Term::ForwardDynamics => self.motion(false).acceleration,
            Term::ConstrainedAcceleration => self.motion(true).acceleration,
            Term::ConstrainedMultipliers => self.motion(true).multipliers,
            Term::ForceResidual => self.residuals(true).0,
            Term::AccelerationResidual => self.residuals(true).1,
        }
    }

    /// `M a − Q_C − Q_D`
    fn inverse_dynamics(&mut self) -> Vec<ExprId> {
        let graph = &mut self.model.graph;
        let a: Vec<ExprId> = self.acceleration.iter().map(|&s| graph.var(s)).collect();
        (0..a.len())
            .map(|i| {
                let inertial = graph.inner_product(&self.system.mass_matrix[i], &a);
                let known = graph.add(self.system.bias_force[i], self.system.applied_force[i]);
                graph.sub(inertial, known)
            })
            .collect()
    }

    /// `R` and `S` at stated `a, λ`; without constraints `M a − Q` and nothing.
    fn residuals(&mut self, constrained: bool) -> (Vec<ExprId>, Vec<ExprId>) {
        let system = if constrained {
            self.system.clone()
        } else {
            System {
                constraint_matrix: Vec::new(),
                constraint_bias: Vec::new(),
                ..self.system.clone()
            }
        };
        let multipliers: &[SymbolId] = if constrained { &self.multipliers } else { &[] };
        let mut force = residuals(&mut self.model, &system, &self.acceleration, multipliers);
        let acceleration = force.split_off(self.acceleration.len());
        (force, acceleration)
    }

    /// `a` and `λ`; `a = M⁻¹ Q` without constraints.
    fn motion(&mut self, constrained: bool) -> Motion {
        let order = (0..self.system.mass_matrix.len()).collect();
        let graph = &mut self.model.graph;
        let factor = Factor::new(graph, &self.system.mass_matrix, order);
        let (rows, bias) = self.rows(constrained);
        let graph = &mut self.model.graph;
        let solution = factor.constrained(graph, &self.system.force, &rows, &bias);
        Motion {
            factor,
            acceleration: solution.acceleration,
            multipliers: solution.multipliers,
        }
    }

    fn rows(&self, constrained: bool) -> (Vec<Vec<ExprId>>, Vec<ExprId>) {
        if constrained {
            let system = &self.system;
            (system.constraint_matrix.clone(), system.constraint_bias.clone())
        } else {
            (Vec::new(), Vec::new())
        }
    }

    fn slope(&mut self, term: Term, group: Group) -> Vec<ExprId> {
        let columns = match term {
            Term::ForwardDynamics => self.motion_slopes(false, group).0,
            Term::ConstrainedAcceleration => self.motion_slopes(true, group).0,
            Term::ConstrainedMultipliers => self.motion_slopes(true, group).1,
            _ => {
                let values = self.value(term);
                let by = self.symbols(group);
                let graph = &mut self.model.graph;
                by.iter().map(|&s| graph.derivatives(&values, s)).collect()
            }
        };
        let rows = columns.first().map_or(0, Vec::len);
        (0..rows)
            .flat_map(|row| columns.iter().map(move |column| column[row]))
            .collect()
    }

    /// `∂a/∂s` and `∂λ/∂s`, one column per variable of the group.
    fn motion_slopes(
        &mut self,
        constrained: bool,
        group: Group,
    ) -> (Vec<Vec<ExprId>>, Vec<Vec<ExprId>>) {
        let motion = self.motion(constrained);
        let (rows, _) = self.rows(constrained);
        let (force, demand) = self.residuals(constrained);
        let residuals = [force, demand].concat();
        let values = motion.acceleration.iter().chain(&motion.multipliers);
        let symbols = self.acceleration.iter().chain(&self.multipliers);
        let at: HashMap<SymbolId, ExprId> = symbols.copied().zip(values.copied()).collect();
        let by = self.symbols(group);
        let graph = &mut self.model.graph;
        let columns = by.into_iter().map(|symbol| {
            let change = graph.derivatives(&residuals, symbol);
            let change = graph.substitute(&change, &at);
            let opposite: Vec<ExprId> = change.into_iter().map(|x| graph.neg(x)).collect();
            let (force, demand) = opposite.split_at(motion.acceleration.len());
            let solution = motion.factor.constrained(graph, force, &rows, demand);
            (solution.acceleration, solution.multipliers)
        });
        columns.unzip()
    }

    /// The symbols of a group, one per column.
    fn symbols(&self, group: Group) -> Vec<SymbolId> {
        let model = &self.model;
        match group {
            Group::Position => model.coordinates.iter().map(|c| c.position).collect(),
            Group::Velocity => model.coordinates.iter().map(|c| c.velocity).collect(),
            Group::Input => model.inputs.iter().map(|u| u.symbol).collect(),
            Group::Parameters => model.parameters.iter().map(|p| p.symbol).collect(),
            Group::Time => vec![model.time],
        }
    }
}
