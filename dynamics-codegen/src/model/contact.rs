//! Forces that depend on what a constraint or a drive exerts: `multiplier(c)`,
//! `normal_force(c)`, `speed(c)`, `force c = …`, and `load(x)`.

use super::builder::Builder;
use super::quantity::{Measure, Quantity};
use super::{Constraint, ConstraintKind, Model, PointForce, Reading};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::{ExprId, SymbolId};
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name, PortKind};
use std::collections::HashMap;

/// What slides along a constraint: the velocity that friction opposes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sliding {
    /// A point that moves by these coordinates, all in metres.
    Coordinates(Vec<usize>),
    /// The origin of a frame: index among the tree's bodies.
    Frame(usize),
    /// Where a shape touches a plane: index of the contact.
    Contact(usize),
}

/// What the inputs exert on a coordinate, while the model is being built.
#[derive(Debug, Clone, Copy)]
pub(super) struct Load {
    coordinate: usize,
    pub symbol: SymbolId,
}

/// Added to squared speeds, (m/s)²: a direction exists at rest, too.
const AT_REST: f64 = 1e-18;
/// A point has three coordinates.
const MOST_AXES: usize = 3;

impl Model {
    /// Whether a force depends on a multiplier.
    pub fn uses_multipliers(&self) -> bool {
        let mut all = self.forces.clone();
        all.extend(self.point_forces.iter().flat_map(|f| f.value));
        let mut constraints = self.constraints.iter();
        constraints.any(|c| self.graph.depends_on(&all, c.multiplier))
    }

    /// The multipliers' variables.
    pub fn multiplier_symbols(&self) -> Vec<SymbolId> {
        self.constraints.iter().map(|c| c.multiplier).collect()
    }

    /// What slides along a constraint: the contact whose gap it closes; the frame whose position it reads; where it reads
    /// none and holds coordinates in metres only, the point that has the model's
    /// coordinates in metres (two or three of them). `None` for every other constraint:
    /// it is no contact.
    pub fn sliding(&self, constraint: usize) -> Option<Sliding> {
        let Constraint { kind, residual, .. } = self.constraints[constraint];
        if kind != ConstraintKind::Holonomic {
            return None;
        }
        if let Some(contact) = self.contacts.iter().position(|c| c.gap == residual) {
            return Some(Sliding::Contact(contact));
        }
        let contains = |symbol| self.graph.depends_on(&[residual], symbol);
        let coordinates = self.coordinates.iter().enumerate();
        let held: Vec<usize> = coordinates
            .filter(|(_, c)| contains(c.position))
            .map(|(index, _)| index)
            .collect();
        let mut frames = Vec::new();
        for reading in self.kinematics.iter().filter(|k| contains(k.symbol)) {
            match reading.reading {
                Reading::Position(_) if !frames.contains(&reading.frame) => {
                    frames.push(reading.frame);
                }
                Reading::Position(_) => {}
                _ => return None,
            }
        }
        let metres = |index: &usize| self.coordinates[*index].dimension == Some(Dimension::LENGTH);
        match (frames.as_slice(), held.is_empty()) {
            ([frame], true) => Some(Sliding::Frame(*frame)),
            ([], false) if held.iter().all(metres) => {
                let axes: Vec<usize> = (0..self.coordinates.len()).filter(metres).collect();
                let axes = if axes.len() > MOST_AXES { held } else { axes };
                (2..=MOST_AXES)
                    .contains(&axes.len())
                    .then_some(Sliding::Coordinates(axes))
            }
            _ => None,
        }
    }
}

impl Builder<'_> {
    /// The constraint of this name, directly or through a port.
    pub(super) fn find_constraint(&mut self, name: &Name) -> Option<usize> {
        if let Some(&(PortKind::Constraint, index)) = self.scope.ports.get(&name.text) {
            return Some(index);
        }
        let mut constraints = self.model.constraints.iter();
        let own = self.effect.is_none();
        if let Some(index) = constraints.position(|c| own && c.name == name.text) {
            return Some(index);
        }
        let known: Vec<String> = (self.model.constraints.iter())
            .map(|c| c.name.clone())
            .collect();
        self.unknown_place(name, "constraint", &known)
    }

    /// The constraint that a force of this name acts along: a port, or a constraint that
    /// shares its name with no coordinate.
    pub(super) fn contact_named(&self, name: &str) -> Option<usize> {
        match self.scope.ports.get(name) {
            Some((PortKind::Constraint, index)) => return Some(*index),
            Some(_) => return None,
            None => {}
        }
        let coordinate = self.model.coordinates.iter().any(|c| c.name == name);
        if coordinate || self.effect.is_some() {
            return None;
        }
        self.model.constraints.iter().position(|c| c.name == name)
    }

    /// `multiplier(c)`, `normal_force(c)`, `speed(c)`, `load(x)`.
    pub(super) fn lower_contact(
        &mut self,
        function: &str,
        argument: &Expr,
        span: Span,
    ) -> Option<Quantity> {
        let ExprKind::Name(text) = &argument.kind else {
            let what = if function == "load" {
                "coordinate"
            } else {
                "constraint"
            };
            let message = format!("`{function}(…)` takes the name of one {what}");
            return self.report(Diagnostic::error(argument.span, message));
        };
        let name = Name {
            text: text.clone(),
            span: argument.span,
        };
        if function == "load" {
            let index = self.find_coordinate(&name)?;
            return Some(self.load(index));
        }
        let index = self.find_constraint(&name)?;
        match function {
            "multiplier" => Some(self.multiplier(index)),
            "speed" => {
                let sliding = self.contact(index, span)?;
                let expr = self.speed(&sliding);
                let measure = Measure::Known(Dimension::LENGTH.rate());
                Some(Quantity { expr, measure })
            }
            _ => self.normal_force(index, span),
        }
    }

    fn multiplier(&self, index: usize) -> Quantity {
        let constraint = &self.model.constraints[index];
        let per = constraint.dimension.map(|unit| match constraint.kind {
            ConstraintKind::Holonomic => unit,
            ConstraintKind::Nonholonomic => unit * Dimension::TIME,
        });
        Quantity {
            expr: self.model.graph.var(constraint.multiplier),
            measure: Measure::of(per.map(|unit| Dimension::ENERGY / unit)),
        }
    }

    fn contact(&mut self, index: usize, span: Span) -> Option<Sliding> {
        if let Some(sliding) = self.model.sliding(index) {
            return Some(sliding);
        }
        let name = &self.model.constraints[index].name;
        let message = format!("nothing slides along the constraint `{name}`");
        self.report(Diagnostic::error(span, message).help(
            "a contact holds the position of one frame, or of a point by its two or three \
             coordinates in metres",
        ))
    }

    /// `|λ| ‖∂c/∂x‖`, with `x` the position of what slides.
    fn normal_force(&mut self, index: usize, span: Span) -> Option<Quantity> {
        let sliding = self.contact(index, span)?;
        let residual = self.model.constraints[index].residual;
        let lambda = self.multiplier(index).expr;
        let size = self.model.graph.unary(crate::graph::Unary::Abs, lambda);
        let measure = Measure::Known(Dimension::ENERGY / Dimension::LENGTH);
        let positions: Vec<SymbolId> = match sliding {
            // A gap is a distance.
            Sliding::Contact(_) => {
                let expr = size;
                return Some(Quantity { expr, measure });
            }
            Sliding::Coordinates(axes) => {
                let axes = axes.iter();
                axes.map(|&i| self.model.coordinates[i].position).collect()
            }
            Sliding::Frame(frame) => (self.model.kinematics.iter())
                .filter(|k| k.frame == frame && matches!(k.reading, Reading::Position(_)))
                .map(|k| k.symbol)
                .collect(),
        };
        let graph = &mut self.model.graph;
        let slopes: Vec<ExprId> = positions
            .iter()
            .map(|&x| graph.derivatives(&[residual], x)[0])
            .collect();
        let square = graph.inner_product(&slopes, &slopes);
        let length = graph.unary(crate::graph::Unary::Sqrt, square);
        let expr = self.model.graph.mul(size, length);
        Some(Quantity { expr, measure })
    }

    fn velocity(&mut self, sliding: &Sliding) -> Vec<ExprId> {
        match sliding {
            Sliding::Coordinates(axes) => {
                let velocity =
                    |&i: &usize| self.model.graph.var(self.model.coordinates[i].velocity);
                axes.iter().map(velocity).collect()
            }
            Sliding::Frame(frame) => (0..3)
                .map(|axis| self.model.reading(*frame, Reading::Velocity(axis)))
                .collect(),
            Sliding::Contact(contact) => self.model.contacts[*contact].velocity[..2].to_vec(),
        }
    }

    fn speed(&mut self, sliding: &Sliding) -> ExprId {
        let velocity = self.velocity(sliding);
        self.length(&velocity)
    }

    /// `√(Σ x² + tiny)`: its derivatives are finite everywhere.
    pub(super) fn length(&mut self, entries: &[ExprId]) -> ExprId {
        let graph = &mut self.model.graph;
        let square = graph.inner_product(entries, entries);
        let tiny = graph.constant(AT_REST);
        let sum = graph.add(square, tiny);
        graph.unary(crate::graph::Unary::Sqrt, sum)
    }

    /// `force c = value`: along the velocity of what slides on the constraint.
    pub(super) fn lower_sliding_force(&mut self, constraint: usize, value: &Expr) -> Option<()> {
        let sliding = self.contact(constraint, value.span)?;
        let quantity = self.lower(value)?;
        let newton = Dimension::ENERGY / Dimension::LENGTH;
        self.expect_dimension(quantity, newton, value.span, "a force along a contact")?;
        let velocity = self.velocity(&sliding);
        let speed = self.length(&velocity);
        let share = self.model.graph.div(quantity.expr, speed);
        let graph = &mut self.model.graph;
        let parts: Vec<ExprId> = velocity.iter().map(|&v| graph.mul(share, v)).collect();
        match sliding {
            Sliding::Coordinates(axes) => {
                for (axis, part) in axes.into_iter().zip(parts) {
                    let sum = self.model.graph.add(self.model.forces[axis], part);
                    self.model.forces[axis] = sum;
                }
            }
            Sliding::Frame(frame) => self.model.point_forces.push(PointForce {
                frame,
                value: [parts[0], parts[1], parts[2]],
                torque: false,
            }),
            Sliding::Contact(contact) => self.model.rub(contact, [parts[0], parts[1]]),
        }
        Some(())
    }

    /// What the inputs exert on a coordinate: known when all forces are.
    fn load(&mut self, coordinate: usize) -> Quantity {
        let known = self.loads.iter().find(|load| load.coordinate == coordinate);
        let symbol = match known {
            Some(load) => load.symbol,
            None => {
                let name = format!("load_{}", self.model.coordinates[coordinate].name);
                let symbol = self.model.graph.symbol(name);
                self.loads.push(Load { coordinate, symbol });
                symbol
            }
        };
        let unit = self.model.coordinates[coordinate].dimension;
        Quantity {
            expr: self.model.graph.var(symbol),
            measure: Measure::of(unit.map(|unit| Dimension::ENERGY / unit)),
        }
    }

    /// Remembers a force if it is the inputs' work.
    pub(super) fn note_driven(&mut self, coordinate: usize, force: ExprId) {
        let inputs = self.model.input_symbols();
        let mut others = self.model.multiplier_symbols();
        others.extend(self.loads.iter().map(|load| load.symbol));
        let graph = &self.model.graph;
        let on = |symbols: &[SymbolId]| symbols.iter().any(|&s| graph.depends_on(&[force], s));
        if on(&inputs) && !on(&others) {
            self.driven.push((coordinate, force));
        }
    }

    /// Puts the loads in: the forces that the inputs make, less those without inputs.
    pub(super) fn put_loads_into_forces(&mut self) {
        let zero = self.model.graph.zero();
        let symbols = self.model.input_symbols();
        let nothing: HashMap<SymbolId, ExprId> = symbols.iter().map(|&u| (u, zero)).collect();
        let mut values = HashMap::new();
        for load in self.loads.clone() {
            let driven = self.driven.iter();
            let forces: Vec<ExprId> = driven
                .filter(|(coordinate, _)| *coordinate == load.coordinate)
                .map(|(_, force)| *force)
                .collect();
            let graph = &mut self.model.graph;
            let all = graph.sum(forces);
            let rest = graph.substitute(&[all], &nothing)[0];
            values.insert(load.symbol, graph.sub(all, rest));
        }
        if values.is_empty() {
            return;
        }
        let forces = self.model.forces.clone();
        self.model.forces = self.model.graph.substitute(&forces, &values);
        for force in &mut self.model.point_forces {
            let value = self.model.graph.substitute(&force.value, &values);
            force.value = [value[0], value[1], value[2]];
        }
    }
}
