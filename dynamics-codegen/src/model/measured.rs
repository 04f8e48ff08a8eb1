//! What a log shows in place of a position, or of what a sensor shows: `measured x = x + offset;`.

use super::Model;
use super::builder::{Builder, MAX_SIZE};
use crate::diagnostic::Diagnostic;
use crate::graph::ExprId;
use crate::syntax::{Expr, Name, PortKind};
use std::collections::HashMap;

impl Model {
    /// What the sensor of a coordinate reads: its position unless the model says otherwise; of
    /// a twist's component, which has none, zero.
    pub fn measured_position(&mut self, coordinate: usize) -> ExprId {
        let stated = self.measured.iter().find(|(index, _)| *index == coordinate);
        match stated {
            Some((_, expr)) => *expr,
            // A twist's component has no position of its own.
            None if self.pose_of(coordinate).is_some() => self.graph.zero(),
            None => self.graph.var(self.coordinates[coordinate].position),
        }
    }
}

impl Builder<'_> {
    /// `measured x = value`: what was read so far, and its rate, become the argument.
    pub(super) fn lower_measured(&mut self, name: &Name, value: &Expr) -> Option<()> {
        // Each statement derives what all before it have made of the position.
        self.measurements += 1;
        if self.measurements > MAX_SIZE {
            let message = format!("the model says more than {MAX_SIZE} times what is measured");
            return self.report(Diagnostic::error(name.span, message));
        }
        let (kind, index) = self.find_reading(name)?;
        if kind == PortKind::Sensor {
            return self.lower_reading(index, value);
        }
        if self.model.pose_of(index).is_some() {
            let message = format!("`{}` is a velocity: a position is measured", name.text);
            return self.report(Diagnostic::error(name.span, message));
        }
        let quantity = self.lower(value)?;
        if let Some(dimension) = self.model.coordinates[index].dimension {
            let role = format!("what is measured of `{}`", name.text);
            self.expect_dimension(quantity, dimension, value.span, &role)?;
        }
        self.refuse_inputs(quantity.expr, value.span, "a measurement")?;
        let so_far = self.model.measured_position(index);
        let (position, velocity) = {
            let coordinate = &self.model.coordinates[index];
            (coordinate.position, coordinate.velocity)
        };
        let mut replacements = HashMap::from([(position, so_far)]);
        if !self.model.contains_velocity(so_far) {
            let seeds = self.model.time_seeds();
            let rate = self.model.graph.directional(&[so_far], &seeds)[0];
            replacements.insert(velocity, rate);
        }
        let expr = self.model.graph.substitute(&[quantity.expr], &replacements)[0];
        self.model.measured.retain(|(stated, _)| *stated != index);
        self.model.measured.push((index, expr));
        Some(())
    }
}
