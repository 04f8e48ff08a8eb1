//! Bodies, gravity and forces at a point.

use super::Model;
use super::builder::Builder;
use super::frames::FrameState;
use super::quantity::{Measure, Quantity};
use crate::diagnostic::{Diagnostic, Severity};
use crate::dimension::Dimension;
use crate::graph::ExprId;
use crate::robot::{Impossible, MEND};
use crate::source::Span;
use crate::syntax::{self, BodyStatement, Expr, ExprKind, PortKind};
use crate::tree::{Body, Inertia, Joint, Placement};

/// A named body.
#[derive(Debug, Clone)]
pub struct NamedBody {
    /// Its name.
    pub name: String,
    /// Index of its frame among the tree's bodies.
    pub frame: usize,
    /// Index of what has its mass among the tree's bodies.
    pub massive: usize,
    /// What the model says about it.
    pub doc: String,
}

/// A force or torque at the origin of a frame.
#[derive(Debug, Clone)]
pub struct PointForce {
    /// Index among the tree's bodies.
    pub frame: usize,
    /// Along the world's axes.
    pub value: [ExprId; 3],
    /// Whether it is a torque.
    pub torque: bool,
}

/// An entry of `full(ixx, iyy, izz, ixy, ixz, iyz)`: its place in the tensor.
const FULL: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl Model {
    /// The bodies that move: what is fixed to the world has no part in the dynamics.
    pub fn moving_bodies(&self) -> impl Iterator<Item = &NamedBody> {
        let moves = |body: &&NamedBody| self.moved_with(body).is_some();
        self.bodies.iter().filter(moves)
    }

    /// Index, among the tree's bodies, of the one behind the last joint that moves a body: bodies for which
    /// it is the same are rigidly connected. `None` for what is fixed to the world.
    pub fn moved_with(&self, body: &NamedBody) -> Option<usize> {
        let bodies = &self.tree.bodies;
        let mut chain = std::iter::successors(Some(body.massive), |&index| bodies[index].parent);
        chain.find(|&index| !matches!(bodies[index].joint, Joint::Fixed))
    }

    /// The masses of its bodies at their nominal parameters, in the order of [`Model::bodies`], kg.
    pub fn masses(&self) -> Vec<f64> {
        let mut values = vec![0.0; self.graph.symbol_count()];
        for parameter in &self.parameters {
            values[parameter.symbol.index()] = parameter.nominal;
        }
        let masses = self.bodies.iter();
        let masses = masses.map(|body| self.tree.bodies[body.massive].inertia.mass);
        self.graph.evaluate(&masses.collect::<Vec<_>>(), &values)
    }
}

impl Builder<'_> {
    /// Names, so that frames may be attached to a body wherever it is defined.
    pub(super) fn declare_body(&mut self, body: &BodyStatement) {
        self.declare_frame(&body.name, &body.frame);
    }

    /// The inertia of a body, on its frame.
    pub(super) fn lower_body(&mut self, body: &BodyStatement, doc: &str) -> Option<()> {
        let frame = self.find_frame(&body.name.text, body.name.span);
        let mass = match &body.mass {
            Some(value) => self.constant_of_motion(value, "kg", "a mass"),
            None => Some(self.model.graph.zero()),
        };
        let zero = self.model.graph.zero();
        let mut center = [zero; 3];
        for (entry, value) in center.iter_mut().zip(body.center.iter().flatten()) {
            *entry = self.constant_of_motion(value, "m", "a centre of mass")?;
        }
        let tensor = match &body.inertia {
            Some(value) => self.inertia_tensor(value),
            None => Some([[zero; 3]; 3]),
        };
        let (frame, mass, tensor) = (frame?, mass?, tensor?);
        self.refuse_negative(mass, body.mass.as_ref(), "a mass")?;
        if let Some(value) = &body.inertia {
            self.refuse_impossible(&tensor, value.span, &body.name.text)?;
        }
        let inertia = Inertia {
            mass,
            center,
            tensor,
        };
        self.attach(frame, &body.name.text, inertia, doc);
        Some(())
    }

    /// Puts inertia on a frame; outside of effects it is a body with a name.
    pub(super) fn attach(&mut self, frame: usize, name: &str, inertia: Inertia, doc: &str) {
        let zero = self.model.graph.zero();
        self.model.tree.bodies.push(Body {
            name: name.to_string(),
            parent: Some(frame),
            placement: Placement {
                rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                translation: [zero; 3],
            },
            joint: Joint::Fixed,
            inertia,
        });
        if self.effect.is_none() {
            self.model.bodies.push(NamedBody {
                name: name.to_string(),
                frame,
                massive: self.model.tree.bodies.len() - 1,
                doc: doc.to_string(),
            });
        }
    }

    fn inertia_tensor(&mut self, value: &Expr) -> Option<[[ExprId; 3]; 3]> {
        let help = "write `diag(ix, iy, iz)` or `full(ixx, iyy, izz, ixy, ixz, iyz)`, about the centre of mass";
        let ExprKind::Call(function, arguments) = &value.kind else {
            let error = Diagnostic::error(value.span, "expected an inertia tensor");
            return self.report(error.help(help));
        };
        let count = match function.text.as_str() {
            "diag" => 3,
            "full" => 6,
            other => {
                let message = format!("`{other}` is no inertia tensor");
                return self.report(Diagnostic::error(function.span, message).help(help));
            }
        };
        if arguments.len() != count {
            let message = format!(
                "`{}` takes {count} entries, found {}",
                function.text,
                arguments.len()
            );
            return self.report(Diagnostic::error(value.span, message).help(help));
        }
        let zero = self.model.graph.zero();
        let mut tensor = [[zero; 3]; 3];
        for (argument, (i, j)) in arguments.iter().zip(FULL) {
            let entry = self.constant_of_motion(argument, "kg*m^2", "a moment of inertia")?;
            if i == j {
                self.refuse_negative(entry, Some(argument), "a moment of inertia")?;
            }
            tensor[i][j] = entry;
            tensor[j][i] = entry;
        }
        Some(tensor)
    }

    /// An expression of parameters and numbers.
    pub(super) fn constant_of_motion(
        &mut self,
        value: &Expr,
        unit: &str,
        role: &str,
    ) -> Option<ExprId> {
        let quantity = self.lower(value)?;
        let dimension = unit.split('*').fold(Dimension::ONE, |product, factor| {
            let (base, power) = factor.split_once('^').unwrap_or((factor, "1"));
            let base = Dimension::of_unit(base).unwrap_or_default();
            product * base.powi(power.parse().unwrap_or(1))
        });
        self.expect_dimension(quantity, dimension, value.span, role)?;
        let expr = quantity.expr;
        self.refuse_memory(expr, value.span, role)?;
        let graph = &self.model.graph;
        let inputs = self.model.inputs.iter().map(|u| u.symbol);
        let moving = self.model.contains_position(expr)
            || self.model.contains_velocity(expr)
            || graph.depends_on(&[expr], self.model.time)
            || inputs.into_iter().any(|u| graph.depends_on(&[expr], u));
        if moving {
            let message = format!("{role} does not change along the motion");
            return self.report(Diagnostic::error(value.span, message).help(
                "it may contain numbers and parameters; what changes is given by `kinetic` and `potential`",
            ));
        }
        Some(expr)
    }

    /// What is known to be negative is no mass; an effect may take mass away.
    fn refuse_negative(&mut self, expr: ExprId, at: Option<&Expr>, role: &str) -> Option<()> {
        let negative = self.model.graph.as_constant(expr).filter(|&x| x < 0.0);
        match (negative, at) {
            (Some(value), Some(at)) if self.effect.is_none() => self.report(Diagnostic::error(
                at.span,
                format!("{role} is not negative, found {value}"),
            )),
            _ => Some(()),
        }
    }

    /// A tensor that no body has, at the nominal parameters. Where two moments are zero by
    /// definition the third is that of a planar motion, which nothing else feels; what an
    /// effect adds is no body.
    fn refuse_impossible(&mut self, tensor: &[[ExprId; 3]; 3], at: Span, body: &str) -> Option<()> {
        let graph = &self.model.graph;
        let entries = tensor.concat();
        let planar = entries
            .iter()
            .filter(|&&entry| !graph.is_zero(entry))
            .count()
            <= 1;
        if planar || self.effect.is_some() {
            return Some(());
        }
        let mut symbols = vec![0.0; graph.symbol_count()];
        for parameter in &self.model.parameters {
            symbols[parameter.symbol.index()] = parameter.nominal;
        }
        let values = graph.evaluate(&entries, &symbols);
        let tensor = [0, 1, 2].map(|i| [0, 1, 2].map(|j| values[3 * i + j]));
        let Some(found) = Impossible::of(&tensor) else {
            return Some(());
        };
        let what = format!("body `{body}`: {}", found.what);
        let varies = entries
            .iter()
            .any(|&entry| graph.as_constant(entry).is_none());
        let (finding, help) = match found.rounding() {
            Some(rounding) => (Diagnostic::warning(at, what), rounding),
            None if varies => (
                Diagnostic::warning(at, what),
                format!("so it is with the nominal parameters; {MEND}"),
            ),
            None => (
                Diagnostic::error(at, what),
                format!("{MEND}; a planar motion feels one moment: `diag(0, 0, iz)`"),
            ),
        };
        let refused = finding.severity == Severity::Error;
        self.report::<()>(finding.label(found.why).help(help));
        (!refused).then_some(())
    }

    /// `gravity (0, 0, -g);` statements add up. The first one in a model replaces
    /// what a robot description takes for granted.
    pub(super) fn lower_gravity(&mut self, components: &[Expr; 3]) -> Option<()> {
        let acceleration = Dimension::LENGTH.rate().rate();
        let mut values = Vec::with_capacity(3);
        for component in components {
            let value = self.lower(component)?;
            self.expect_dimension(value, acceleration, component.span, "gravity")?;
            let moving = self.model.contains_position(value.expr)
                || self.model.contains_velocity(value.expr);
            if moving {
                let message = "gravity is the same everywhere: it contains no coordinate";
                return self.report(Diagnostic::error(component.span, message));
            }
            self.refuse_memory(value.expr, component.span, "gravity")?;
            values.push(value.expr);
        }
        for (axis, value) in values.into_iter().enumerate() {
            let total = self.model.tree.gravity[axis];
            self.model.tree.gravity[axis] = self.model.graph.add(total, value);
        }
        Some(())
    }

    /// `gravity.x` in a template: that of the model it is applied to.
    pub(super) fn gravity_component(&mut self, axis: usize, span: Span) -> Option<Quantity> {
        if self.effect.is_none() {
            let message = "gravity can be read in effect templates only";
            return self.report(
                Diagnostic::error(span, message).help("give its components names of their own"),
            );
        }
        Some(Quantity {
            expr: self.model.tree.gravity[axis],
            measure: Measure::Known(Dimension::LENGTH.rate().rate()),
        })
    }

    /// `force at(tip) in hub = (fx, fy, fz);`
    pub(super) fn lower_point_force(&mut self, force: &syntax::PointForce) -> Option<()> {
        let frame = self.find_frame(&force.at.text, force.at.span)?;
        let axes = match &force.axes {
            Some(name) => Some(self.find_frame(&name.text, name.span)?),
            None => None,
        };
        let newton = Dimension::ENERGY / Dimension::LENGTH;
        let (dimension, role) = if force.torque {
            (Dimension::ENERGY, "a torque")
        } else {
            (newton, "a force")
        };
        let mut value = [self.model.graph.zero(); 3];
        for (entry, part) in value.iter_mut().zip(&force.value) {
            let quantity = self.lower(part)?;
            self.expect_dimension(quantity, dimension, part.span, role)?;
            *entry = quantity.expr;
        }
        if let Some(axes) = axes {
            value = [0, 1, 2].map(|k| {
                let parts = [0, 1, 2].map(|i| {
                    let along = self.model.reading(axes, super::Reading::Axis(i, k));
                    self.model.graph.mul(along, value[i])
                });
                self.model.graph.sum(parts)
            });
        }
        self.model.point_forces.push(PointForce {
            frame,
            value,
            torque: force.torque,
        });
        Some(())
    }

    /// `mass(body)`
    pub(super) fn lower_mass(&mut self, argument: &Expr) -> Option<Quantity> {
        let ExprKind::Name(name) = &argument.kind else {
            let message = "`mass` takes the name of a body";
            return self.report(Diagnostic::error(argument.span, message));
        };
        let body = self.find_body(name, argument.span)?;
        let massive = self.model.bodies[body].massive;
        Some(Quantity {
            expr: self.model.tree.bodies[massive].inertia.mass,
            measure: Measure::Known(Dimension::of_unit("kg").unwrap_or_default()),
        })
    }

    /// Gives something of a robot description its name as a frame.
    pub(super) fn name_frame(&mut self, name: &str, span: Span, body: usize) {
        let name = syntax::Name {
            text: name.to_string(),
            span,
        };
        self.add_frame(&name, None, FrameState::Done(body));
    }

    /// The unit of a port.
    pub(super) fn port_dimension(&self, kind: PortKind, index: usize) -> Option<Dimension> {
        match kind {
            PortKind::Coordinate | PortKind::Coordinates => self.model.coordinates[index].dimension,
            PortKind::Constraint => self.model.constraints[index].dimension,
            PortKind::Input => self.model.inputs[index].dimension,
            PortKind::Drive => self.shaft_dimension(index),
            PortKind::Sensor | PortKind::Reading => self.wrong.known[index].dimension,
            PortKind::Body | PortKind::Frame => Some(Dimension::LENGTH),
        }
    }
}
