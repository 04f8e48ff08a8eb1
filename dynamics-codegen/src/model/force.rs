//! Generalised forces, and what arrives of an input.

use super::builder::Builder;
use super::quantity::Quantity;
use crate::dimension::Dimension;
use crate::source::Span;
use crate::syntax::{Expr, Name};

impl Builder<'_> {
    /// `force x = f;`: on a coordinate, on each of a set, or along a contact.
    pub(super) fn lower_force(&mut self, on: &Name, value: &Expr) -> Option<()> {
        if self.is_set(&on.text) {
            return self.lower_set_force(&on.text, value);
        }
        if let Some(constraint) = self.contact_named(&on.text) {
            return self.lower_sliding_force(constraint, value);
        }
        if let Some(input) = self.shaft(&on.text) {
            return self.lower_shaft_force(input, on, value);
        }
        let index = self.find_coordinate(on)?;
        let quantity = self.lower(value)?;
        self.add_force(index, quantity, &on.text, value.span)
    }

    /// Adds to the force on a coordinate, which the text calls `called`, what stands
    /// at `span`.
    pub(super) fn add_force(
        &mut self,
        index: usize,
        force: Quantity,
        called: &str,
        span: Span,
    ) -> Option<()> {
        if let Some(dimension) = self.model.coordinates[index].dimension {
            let role = format!("a force on `{called}`");
            self.expect_dimension(force, Dimension::ENERGY / dimension, span, &role)?;
        }
        let sum = self.model.graph.add(self.model.forces[index], force.expr);
        self.model.forces[index] = sum;
        self.note_driven(index, force.expr);
        Some(())
    }

    /// `input u = f(u)`: what arrived so far becomes the argument.
    pub(super) fn lower_channel(&mut self, name: &Name, value: &Expr) -> Option<()> {
        let index = self.find_input(name)?;
        let quantity = self.lower(value)?;
        if let Some(dimension) = self.model.inputs[index].dimension {
            let role = format!("what arrives at `{}`", name.text);
            self.expect_dimension(quantity, dimension, value.span, &role)?;
        }
        self.refuse_momentary(quantity.expr, value.span, "what arrives")?;
        let replacement = self.what_arrives(index, quantity.expr, value.span)?;
        self.channels[index] = self.model.graph.substitute(&[quantity.expr], &replacement)[0];
        Some(())
    }
}
