//! `contact` statements, and what expressions read of a contact.

use super::{AXES, Contact, Plane, Shape};
use crate::diagnostic::{Diagnostic, nearest};
use crate::dimension::Dimension;
use crate::graph::ExprId;
use crate::model::builder::{Builder, MAX_SIZE};
use crate::model::quantity::{Measure, Quantity};
use crate::source::Span;
use crate::syntax::{ContactStatement, Expr, ExprKind, Name};

/// What contacts are between.
const SHAPES: [&str; 5] = ["point", "sphere", "disc_x", "disc_y", "disc_z"];
const PLANES: [&str; 3] = ["plane_x", "plane_y", "plane_z"];

impl Builder<'_> {
    /// `contact foot: sphere(ankle, r) on plane_z(world) { friction: mu; restitution: e; }`
    pub(in crate::model) fn lower_unilateral(
        &mut self,
        statement: &ContactStatement,
        doc: &str,
    ) -> Option<()> {
        let name = &statement.name;
        self.refuse_taken_contact(name)?;
        let shape = self.lower_shape(&statement.shape, &name.text);
        let plane = self.lower_plane(&statement.plane, &name.text);
        let friction = self.coefficient(statement.friction.as_ref(), "friction", f64::INFINITY);
        let restitution = self.coefficient(statement.restitution.as_ref(), "restitution", 1.0);
        let (shape, plane) = (shape?, plane?);
        let (friction, restitution) = (friction?, restitution?);
        let (arm, gap, velocity) = self.model.touch(shape, plane);
        self.model.contacts.push(Contact {
            name: name.text.clone(),
            shape,
            plane,
            arm,
            gap,
            velocity,
            friction,
            restitution,
            doc: doc.to_string(),
        });
        Some(())
    }

    fn refuse_taken_contact(&mut self, name: &Name) -> Option<()> {
        if self.model.contacts.iter().any(|c| c.name == name.text) {
            let message = format!("there are two contacts named `{}`", name.text);
            return self.report(Diagnostic::error(name.span, message));
        }
        if self.model.contacts.len() == MAX_SIZE {
            let message = format!("the model has more than {MAX_SIZE} contacts");
            return self.report(Diagnostic::error(name.span, message));
        }
        Some(())
    }

    fn lower_shape(&mut self, value: &Expr, contact: &str) -> Option<Shape> {
        let (function, arguments) = self.part(value, "a shape", &SHAPES)?;
        let wanted = if function == "point" { 1 } else { 2 };
        if arguments.len() != wanted {
            let takes = match wanted {
                1 => "a frame",
                _ => "a frame and a radius",
            };
            let message = format!("`{function}` takes {takes}, found {}", arguments.len());
            return self.report(Diagnostic::error(value.span, message));
        }
        let frame = self.frame_of_contact(&arguments[0], contact);
        let radius = match arguments.get(1) {
            Some(radius) => Some(self.radius(radius)?),
            None => None,
        };
        let frame = frame?;
        Some(match (radius, axis_of(&function)) {
            (None, _) => Shape::Point { frame },
            (Some(radius), None) => Shape::Sphere { frame, radius },
            (Some(radius), Some(axis)) => Shape::Disc {
                frame,
                axis,
                radius,
            },
        })
    }

    fn lower_plane(&mut self, value: &Expr, contact: &str) -> Option<Plane> {
        let (function, arguments) = self.part(value, "a plane", &PLANES)?;
        let [frame] = arguments else {
            let message = format!("`{function}` takes one frame, found {}", arguments.len());
            return self.report(Diagnostic::error(value.span, message));
        };
        let frame = self.frame_of_contact(frame, contact)?;
        let normal = axis_of(&function).unwrap_or(2);
        Some(Plane { frame, normal })
    }

    /// A call of one of the functions that a contact is made of.
    fn part<'e>(
        &mut self,
        value: &'e Expr,
        what: &str,
        known: &[&'static str],
    ) -> Option<(String, &'e [Expr])> {
        let all = known.join(", ");
        let ExprKind::Call(function, arguments) = &value.kind else {
            let error = Diagnostic::error(value.span, format!("expected {what}"));
            return self.report(error.help(format!("one of: {all}")));
        };
        if !known.contains(&function.text.as_str()) {
            let message = format!("`{}` is not {what}", function.text);
            let error = Diagnostic::error(function.span, message);
            return self.report(match nearest(&function.text, known.iter().copied()) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("one of: {all}")),
            });
        }
        Some((function.text.clone(), arguments))
    }

    /// The name of a frame, or a product of transforms.
    fn frame_of_contact(&mut self, value: &Expr, contact: &str) -> Option<usize> {
        match &value.kind {
            ExprKind::Name(name) => self.find_frame(name, value.span),
            _ => self.lower_frame(value, contact),
        }
    }

    fn radius(&mut self, value: &Expr) -> Option<ExprId> {
        let radius = self.constant_of_motion(value, "m", "a radius")?;
        match self.model.graph.as_constant(radius) {
            Some(number) if number <= 0.0 => {
                let error = Diagnostic::error(value.span, "a radius is above zero");
                self.report(error.help("a shape without extent is a `point`"))
            }
            _ => Some(radius),
        }
    }

    /// A pure number from zero up to `most`; zero if not stated.
    fn coefficient(&mut self, value: Option<&Expr>, word: &str, most: f64) -> Option<ExprId> {
        let Some(value) = value else {
            return Some(self.model.graph.zero());
        };
        let role = format!("the `{word}` of a contact");
        let expr = self.constant_of_motion(value, "1", &role)?;
        match self.model.graph.as_constant(expr) {
            Some(number) if number < 0.0 || number > most => {
                let range = match most {
                    1.0 => "between 0 and 1",
                    _ => "not below zero",
                };
                let message = format!("{role} is {range}, found {number}");
                self.report(Diagnostic::error(value.span, message))
            }
            _ => Some(expr),
        }
    }

    /// `gap(foot)`, `slip_x(foot)`.
    pub(in crate::model) fn lower_of_contact(
        &mut self,
        function: &str,
        argument: &Expr,
        span: Span,
    ) -> Option<Quantity> {
        let ExprKind::Name(text) = &argument.kind else {
            let message = format!("`{function}` takes the name of a contact");
            return self.report(Diagnostic::error(argument.span, message));
        };
        let mut contacts = self.model.contacts.iter();
        let Some(contact) = contacts.find(|c| c.name == *text) else {
            let known: Vec<String> = self.model.contacts.iter().map(|c| c.name.clone()).collect();
            let name = Name {
                text: text.clone(),
                span: argument.span,
            };
            return self.unknown_place(&name, "contact", &known);
        };
        let (plane, gap, velocity) = (contact.plane, contact.gap, contact.velocity);
        if function == "gap" {
            let measure = Measure::Known(Dimension::LENGTH);
            return Some(Quantity { expr: gap, measure });
        }
        let axes = plane.axes();
        let along = axis_of(function).and_then(|axis| axes[..2].iter().position(|&a| a == axis));
        match along {
            Some(place) => Some(Quantity {
                expr: velocity[place],
                measure: Measure::Known(Dimension::LENGTH.rate()),
            }),
            None => {
                let [first, second] = [axes[0], axes[1]].map(|axis| AXES[axis]);
                let message = format!("`{function}` is across the plane of `{text}`");
                self.report(Diagnostic::error(span, message).help(format!(
                    "along it are `slip_{first}` and `slip_{second}`; across it, `dot(gap({text}))`"
                )))
            }
        }
    }
}

/// The axis at the end of a name: `plane_z`.
fn axis_of(function: &str) -> Option<usize> {
    let (_, letter) = function.rsplit_once('_')?;
    AXES.iter().position(|&axis| axis == letter)
}
