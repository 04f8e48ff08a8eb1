//! A model's graph, grown by what functions are asked to compute.
//!
//! The motion and its derivatives come out as straight lines: `M` is factored on the
//! graph, and `K ∂[a; −λ]/∂s = −∂[R; S]/∂s` is solved with the same factors, where
//! `R` and `S` are differentiated at fixed `a, λ`.

use super::reading::Readings;
use super::sensitivity::residuals_from;
use super::{Group, Item, System, Term, force, inertial};
use crate::compile::Compiled;
use crate::graph::{ExprId, Node, SymbolId};
use crate::model::Model;
use crate::tree::{Factor, Mechanism};
use std::collections::{BTreeMap, HashMap};

/// Why a model has no such function.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
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
    /// It solves an equation that is not linear, a force depends on a multiplier, or of
    /// which rows come and go.
    #[error(
        "`{item}` does not exist: a force depends on a constraint's multiplier, or a constraint is switched: no straight line solves that; solve at run time instead (`dynamics::acceleration`)"
    )]
    Contact {
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

    /// The terms of the equations.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The entries of an item: rows, then columns, then what it is differentiated by.
    ///
    /// # Errors
    /// If there is no entry, or if a factor is singular at every state.
    pub fn entries(&mut self, item: Item) -> Result<Vec<ExprId>, ItemError> {
        if let Some(known) = self.known.get(&item) {
            return Ok(known.clone());
        }
        self.can_have(item)?;
        let entries = match item.by {
            None => self.value(item.term),
            Some(group) => self.slope(item.term, group),
        };
        let solved = matches!(
            item.term,
            Term::ForwardDynamics
                | Term::ConstrainedAcceleration
                | Term::ConstrainedMultipliers
                | Term::PredictedSensors
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

    /// As [`entries`](Self::entries), by the operations that are fewest in a function that
    /// computes the mass matrix or its factors as well.
    ///
    /// # Errors
    /// As [`entries`](Self::entries).
    pub fn entries_beside_mass(&mut self, item: Item) -> Result<Vec<ExprId>, ItemError> {
        let entries = self.entries(item)?;
        Ok(match (item.term, item.by) {
            (Term::BiasForce, None) => self.system.bias_force_beside_mass.clone(),
            (Term::Force, None) => self.system.force_beside_mass.clone(),
            (Term::ForwardDynamics, None) => self.motion(false).acceleration,
            _ => entries,
        })
    }

    /// Whether the model has the item, but for factors that are singular at every state.
    ///
    /// # Errors
    /// If there is no entry, or no straight line that solves for it.
    pub fn can_have(&self, item: Item) -> Result<(), ItemError> {
        if let Some(lacks) = self.lacks(item) {
            let item = item.to_string();
            return Err(ItemError::Empty { item, lacks });
        }
        let switched = self.model.constraints.iter().any(|c| c.active.is_some());
        let constrained = matches!(
            item.term,
            Term::ConstrainedAcceleration | Term::ConstrainedMultipliers | Term::PredictedSensors
        );
        if self.model.uses_multipliers() && item.solves() || switched && constrained {
            let item = item.to_string();
            return Err(ItemError::Contact { item });
        }
        Ok(())
    }

    /// What an item would need one of.
    fn lacks(&self, item: Item) -> Option<&'static str> {
        let term = match item.term {
            Term::InputMatrix if self.model.inputs.is_empty() => Some("input"),
            Term::PositionRate if self.model.poses.is_empty() => {
                Some("body that floats by its twist")
            }
            Term::StateRate | Term::InitialState if self.model.states.is_empty() => {
                Some("internal state")
            }
            Term::ContactGap
            | Term::ContactVelocity
            | Term::ContactJacobian
            | Term::ContactBias
            | Term::ContactCoefficients
                if self.model.contacts.is_empty() =>
            {
                Some("contact")
            }
            Term::Outputs | Term::OutputRates if self.model.outputs.is_empty() => Some("output"),
            Term::Sensors | Term::PredictedSensors if self.model.sensors.is_empty() => {
                Some("sensor")
            }
            Term::OutputJacobian | Term::OutputBias
                if self.system.positional_outputs.is_empty() =>
            {
                Some("output of positions alone")
            }
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
            Term::ContactGap => system.contact_gap.clone(),
            Term::ContactVelocity => system.contact_velocity.clone(),
            Term::ContactJacobian => system.contact_jacobian.concat(),
            Term::ContactBias => system.contact_bias.clone(),
            Term::ContactCoefficients => system.contact_coefficients.concat(),
            Term::PositionRate => self.model.position_rates(),
            Term::StateRate => system.state_rates.clone(),
            Term::InitialState => system.initial_states.clone(),
            Term::Outputs => system.outputs.clone(),
            Term::OutputRates => system.output_rates.clone(),
            Term::OutputJacobian => system.output_jacobian.concat(),
            Term::OutputBias => system.output_bias.clone(),
            Term::Sensors => self.sensors(),
            Term::PredictedSensors => {
                let sensors = self.sensors();
                let motion = self.motion(self.is_constrained());
                self.at_motion(&sensors, &motion)
            }
            Term::InverseDynamics => self.inverse_dynamics(false),
            Term::ForwardDynamics => self.forward_dynamics(),
            Term::ConstrainedAcceleration => self.motion(true).acceleration,
            Term::ConstrainedMultipliers => self.motion(true).multipliers,
            Term::ForceResidual => {
                let mut residuals = self.residuals(true, false);
                residuals.truncate(self.acceleration.len());
                residuals
            }
            Term::AccelerationResidual => self
                .residuals(true, false)
                .split_off(self.acceleration.len()),
        }
    }

    /// The tree of bodies, if there is one whose coordinates are all free of constraints
    /// (a quaternion's are not: derivatives by them are those of the expressions).
    fn free_tree(&self) -> Option<Mechanism> {
        let mechanism = self.model.mechanism.clone();
        mechanism.filter(|m| !m.is_floating())
    }

    /// The tree, if it is all the inertia there is and moves with every coordinate: the
    /// forward dynamics are then its own.
    fn whole_tree(&self) -> Option<Mechanism> {
        let graph = &self.model.graph;
        let alone = graph.is_zero(self.model.kinetic) && graph.is_zero(self.model.potential);
        self.free_tree().filter(|m| alone && m.moves_all())
    }

    fn variables(&self, symbols: &[SymbolId]) -> Vec<ExprId> {
        symbols.iter().map(|&s| self.model.graph.var(s)).collect()
    }

    /// `M a − Q_C` at the stated `a`; without what a tree of bodies needs if `rest`.
    fn needed(&mut self, rest: bool) -> Vec<ExprId> {
        let a = self.variables(&self.acceleration);
        let readings = Readings::new(&self.model);
        if rest {
            inertial::inverse_of_energies(&mut self.model, &readings, &a)
        } else {
            inertial::inverse(&mut self.model, &readings, &a)
        }
    }

    /// `M a − Q_C − Q_D`
    fn inverse_dynamics(&mut self, rest: bool) -> Vec<ExprId> {
        let needed = self.needed(rest);
        let graph = &mut self.model.graph;
        (needed.iter().zip(&self.system.applied_force))
            .map(|(&needed, &applied)| graph.sub(needed, applied))
            .collect()
    }

    /// `R` then `S` at stated `a, λ`; without constraints `M a − Q`.
    fn residuals(&mut self, constrained: bool, rest: bool) -> Vec<ExprId> {
        let needed = self.needed(rest);
        let a = self.variables(&self.acceleration);
        let (system, lambda) = if constrained {
            (self.system.clone(), self.variables(&self.multipliers))
        } else {
            let system = System {
                constraint_matrix: Vec::new(),
                constraint_bias: Vec::new(),
                ..self.system.clone()
            };
            (system, Vec::new())
        };
        residuals_from(&mut self.model, &system, &needed, &a, &lambda)
    }

    /// Whether the forward dynamics by itself are a recursion over the tree, which does not
    /// need the mass matrix.
    pub fn moves_without_mass_matrix(&self) -> bool {
        self.whole_tree().is_some_and(|tree| tree.is_articulated())
    }

    /// `a` without constraints.
    fn forward_dynamics(&mut self) -> Vec<ExprId> {
        match self.whole_tree() {
            Some(tree) => {
                let applied = self.applied();
                tree.forward_dynamics(&mut self.model.graph, &applied)
            }
            None => self.motion(false).acceleration,
        }
    }

    /// `a` and `λ`; `a = M⁻¹ Q` without constraints.
    fn motion(&mut self, constrained: bool) -> Motion {
        let (rows, bias) = self.rows(constrained);
        let mechanism = self.model.mechanism.as_ref();
        let tree = mechanism.map_or_else(Vec::new, Mechanism::factor_order);
        let others = (0..self.acceleration.len()).filter(|i| !tree.contains(i));
        let order = others.chain(tree.iter().copied()).collect();
        let graph = &mut self.model.graph;
        let factor = Factor::new(graph, &self.system.mass_matrix, order);
        let solution = match self.whole_tree() {
            Some(mechanism) => {
                let applied = self.applied();
                let graph = &mut self.model.graph;
                mechanism.constrained_forward_dynamics(graph, &applied, &rows, &bias)
            }
            None => {
                let graph = &mut self.model.graph;
                factor.constrained(graph, &self.system.force_beside_mass, &rows, &bias)
            }
        };
        Motion {
            factor,
            acceleration: solution.acceleration,
            multipliers: solution.multipliers,
        }
    }

    /// `Q_D + Q_u`
    fn applied(&mut self) -> Vec<ExprId> {
        let readings = Readings::new(&self.model);
        force::forces(&mut self.model, &readings).total
    }

    fn rows(&self, constrained: bool) -> (Vec<Vec<ExprId>>, Vec<ExprId>) {
        if constrained {
            let system = &self.system;
            (
                system.constraint_matrix.clone(),
                system.constraint_bias.clone(),
            )
        } else {
            (Vec::new(), Vec::new())
        }
    }

    fn slope(&mut self, term: Term, group: Group) -> Vec<ExprId> {
        let n = self.acceleration.len();
        let columns = match term {
            Term::ForwardDynamics => self.forward_slopes(group),
            Term::ConstrainedAcceleration => self.motion_slopes(true, group).0,
            Term::ConstrainedMultipliers => self.motion_slopes(true, group).1,
            Term::PredictedSensors => self.predicted_slopes(group),
            Term::InverseDynamics => {
                self.recursive_slopes(group, |this, rest| this.inverse_dynamics(rest))
            }
            Term::ForceResidual => self.recursive_slopes(group, |this, rest| {
                let mut residuals = this.residuals(true, rest);
                residuals.truncate(n);
                residuals
            }),
            _ => {
                let values = self.value(term);
                self.slopes_of(&values, group)
            }
        };
        rows_of(&columns)
    }

    fn slopes_of(&mut self, values: &[ExprId], group: Group) -> Vec<Vec<ExprId>> {
        if group == Group::Position {
            let mut along = |index| {
                let displacement = self.model.displacement(index);
                self.model.graph.directional(values, &displacement)
            };
            return (0..self.acceleration.len()).map(&mut along).collect();
        }
        let by = self.symbols(group);
        let graph = &mut self.model.graph;
        by.iter().map(|&s| graph.derivatives(values, s)).collect()
    }

    /// Slopes of what contains the inverse dynamics of a tree as its first `n` entries:
    /// those by recursion, the others on the graph. `values(…, true)` leaves the tree out.
    fn recursive_slopes(
        &mut self,
        group: Group,
        values: impl Fn(&mut Self, bool) -> Vec<ExprId>,
    ) -> Vec<Vec<ExprId>> {
        let by_state = matches!(group, Group::Position | Group::Velocity);
        let mechanism = self.model.mechanism.clone().filter(Mechanism::is_simple);
        let Some(mechanism) = mechanism.filter(|_| by_state) else {
            let values = values(self, false);
            return self.slopes_of(&values, group);
        };
        let rest = values(self, true);
        let mut columns = self.slopes_of(&rest, group);
        let slopes = self.slopes_of_tree(&mechanism, group);
        let graph = &mut self.model.graph;
        for (j, column) in columns.iter_mut().enumerate() {
            for (entry, row) in column.iter_mut().zip(&slopes) {
                *entry = graph.add(*entry, row[j]);
            }
        }
        columns
    }

    /// Slopes of a tree's inverse dynamics by recursion. Along a quaternion itself, where the
    /// recursion says nothing, those of the expressions: one sweep for all its columns.
    fn slopes_of_tree(&mut self, mechanism: &Mechanism, group: Group) -> Vec<Vec<ExprId>> {
        let a = self.variables(&self.acceleration);
        let symbols = self.symbols(group);
        let graph = &mut self.model.graph;
        let slopes = mechanism.inverse_dynamics_derivatives(graph, &a);
        let mut slopes = match group {
            Group::Position => slopes.position,
            _ => slopes.velocity,
        };
        for (places, quaternion) in mechanism.quaternions() {
            let needed = mechanism.inverse_dynamics(graph, &a);
            let seeds = places
                .map(|place| symbols[place])
                .into_iter()
                .zip(quaternion);
            let along = graph.directional(&needed, &seeds.collect::<Vec<_>>());
            for (row, along) in slopes.iter_mut().zip(along) {
                let found = graph.inner_product(&places.map(|place| row[place]), &quaternion);
                let missing = graph.sub(along, found);
                for (place, value) in places.into_iter().zip(quaternion) {
                    let part = graph.mul(missing, value);
                    row[place] = graph.add(row[place], part);
                }
            }
        }
        slopes
    }

    /// `∂a/∂s` without constraints; of a tree by recursion.
    fn forward_slopes(&mut self, group: Group) -> Vec<Vec<ExprId>> {
        let recursive = matches!(group, Group::Position | Group::Velocity | Group::Input);
        let tree = self.whole_tree().filter(Mechanism::is_simple);
        let Some(mechanism) = tree.filter(|_| recursive) else {
            return self.motion_slopes(false, group).0;
        };
        let applied = self.applied();
        let changes = self.slopes_of(&applied, group);
        let graph = &mut self.model.graph;
        let slopes = mechanism.forward_dynamics_derivatives(graph, &applied);
        let direct = match group {
            Group::Position => Some(slopes.position),
            Group::Velocity => Some(slopes.velocity),
            _ => None,
        };
        let columns = changes.iter().enumerate().map(|(j, change)| {
            let rows = slopes.force.iter().enumerate().map(|(i, inverse)| {
                let through_force = graph.inner_product(inverse, change);
                match &direct {
                    Some(direct) => graph.add(direct[i][j], through_force),
                    None => through_force,
                }
            });
            rows.collect()
        });
        columns.collect()
    }

    /// `∂a/∂s` and `∂λ/∂s`, one column per variable of the group.
    fn motion_slopes(
        &mut self,
        constrained: bool,
        group: Group,
    ) -> (Vec<Vec<ExprId>>, Vec<Vec<ExprId>>) {
        let motion = self.motion(constrained);
        let (rows, _) = self.rows(constrained);
        let changes = self.recursive_slopes(group, |this, rest| this.residuals(constrained, rest));
        let values = motion.acceleration.iter().chain(&motion.multipliers);
        let symbols = self.acceleration.iter().chain(&self.multipliers);
        let at: HashMap<SymbolId, ExprId> = symbols.copied().zip(values.copied()).collect();
        let graph = &mut self.model.graph;
        let columns = changes.into_iter().map(|change| {
            let change = graph.substitute(&change, &at);
            let opposite: Vec<ExprId> = change.into_iter().map(|x| graph.neg(x)).collect();
            let (force, demand) = opposite.split_at(motion.acceleration.len());
            let solution = motion.factor.constrained(graph, force, &rows, demand);
            (solution.acceleration, solution.multipliers)
        });
        columns.unzip()
    }

    /// What sensors show at stated `a` and `λ`.
    fn sensors(&mut self) -> Vec<ExprId> {
        let own = (self.model.accelerations.iter().copied())
            .chain(self.model.multiplier_symbols())
            .collect::<Vec<_>>();
        let stated = self.acceleration.iter().chain(&self.multipliers);
        let graph = &mut self.model.graph;
        let stated = own.into_iter().zip(stated.map(|&symbol| graph.var(symbol)));
        let stated: HashMap<SymbolId, ExprId> = stated.collect();
        graph.substitute(&self.system.sensors, &stated)
    }

    fn is_constrained(&self) -> bool {
        !self.model.constraints.is_empty()
    }

    /// With the motion's `a` and `λ` in place of stated ones.
    fn at_motion(&mut self, exprs: &[ExprId], motion: &Motion) -> Vec<ExprId> {
        let values = motion.acceleration.iter().chain(&motion.multipliers);
        let symbols = self.acceleration.iter().chain(&self.multipliers);
        let at: HashMap<SymbolId, ExprId> = symbols.copied().zip(values.copied()).collect();
        self.model.graph.substitute(exprs, &at)
    }

    /// `∂y/∂s + ∂y/∂a ∂a/∂s + ∂y/∂λ ∂λ/∂s`, one column per variable of the group.
    fn predicted_slopes(&mut self, group: Group) -> Vec<Vec<ExprId>> {
        let constrained = self.is_constrained();
        let sensors = self.sensors();
        let direct = self.slopes_of(&sensors, group);
        let graph = &mut self.model.graph;
        let solved: Vec<SymbolId> = (self.acceleration.iter().chain(&self.multipliers))
            .copied()
            .collect();
        let through: Vec<Vec<ExprId>> = (solved.iter())
            .map(|&symbol| graph.derivatives(&sensors, symbol))
            .collect();
        let motion = self.motion(constrained);
        let (by_a, by_lambda) = self.motion_slopes(constrained, group);
        let columns = direct.iter().enumerate().map(|(j, column)| {
            let changes: Vec<ExprId> = by_a[j].iter().chain(&by_lambda[j]).copied().collect();
            let rows = column.iter().enumerate().map(|(row, &own)| {
                let slopes: Vec<ExprId> = through.iter().map(|slopes| slopes[row]).collect();
                let whole = [&slopes[..], &[own]].concat();
                let whole = self.at_motion(&whole, &motion);
                let graph = &mut self.model.graph;
                let followed = graph.inner_product(&whole[..slopes.len()], &changes);
                graph.add(whole[slopes.len()], followed)
            });
            rows.collect()
        });
        columns.collect()
    }

    /// The symbols of a group, one per column.
    fn symbols(&self, group: Group) -> Vec<SymbolId> {
        let model = &self.model;
        match group {
            Group::Position => model.coordinates.iter().map(|c| c.position).collect(),
            Group::Velocity => model.coordinates.iter().map(|c| c.velocity).collect(),
            // As generated code has them: delayed ones behind the others.
            Group::Input => (model.inputs.iter().map(|u| u.symbol))
                .chain(model.delays.iter().map(|d| d.symbol))
                .collect(),
            Group::Parameters => model.parameters.iter().map(|p| p.symbol).collect(),
            Group::Time => vec![model.time],
        }
    }
}

/// Row by row from columns.
fn rows_of(columns: &[Vec<ExprId>]) -> Vec<ExprId> {
    let rows = columns.first().map_or(0, Vec::len);
    (0..rows)
        .flat_map(|row| columns.iter().map(move |column| column[row]))
        .collect()
}
