//! Ports that stand for several coordinates: `effect speed_drag(axes: coordinates);`.
//!
//! In `force axes = …` the port is one after the other of them; `norm(e)` runs over all.

use super::builder::Builder;
use super::quantity::{Measure, Quantity};
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::{Expr, Name, PortKind};

impl Builder<'_> {
    /// The coordinates that a port stands for; all in one unit.
    pub(super) fn bind_set(&mut self, port: &str, places: &[Name]) -> Option<()> {
        let mut members = Vec::new();
        for place in places {
            let index = self.find_coordinate(place)?;
            if members.contains(&index) {
                let message = format!("`{}` is named twice", place.text);
                return self.report(Diagnostic::error(place.span, message));
            }
            let unit = |index: usize| self.model.coordinates[index].dimension;
            let first = *members.first().unwrap_or(&index);
            if unit(first) != unit(index) {
                let name = &self.model.coordinates[first].name;
                let message = format!("`{name}` and `{}` have different units", place.text);
                return self.report(Diagnostic::error(place.span, message));
            }
            members.push(index);
        }
        self.pending_sets.insert(port.to_string(), members);
        Some(())
    }

    /// The member that a set stands for just now.
    pub(super) fn lower_set_member(&mut self, name: &str, span: Span) -> Option<Quantity> {
        let members = self.scope.sets.get(name).cloned().unwrap_or_default();
        match self.scope.member.and_then(|place| members.get(place)) {
            Some(&index) => self.position(index),
            None => self.report(
                Diagnostic::error(span, format!("`{name}` stands for several coordinates")).help(
                    format!("use it in `norm(…)` or in `force {name} = …`, not in `let`"),
                ),
            ),
        }
    }

    /// `norm(e)`: `√(Σ e²)` over the members of the template's set.
    pub(super) fn lower_norm(&mut self, argument: &Expr, span: Span) -> Option<Quantity> {
        let Some(count) = self.scope.sets.values().map(Vec::len).next() else {
            return self.report(
                Diagnostic::error(span, "`norm` runs over the coordinates of a port")
                    .help("declare one: `effect drag(axes: coordinates);`"),
            );
        };
        let outer = self.scope.member;
        let mut entries = Vec::with_capacity(count);
        let mut measure = Measure::Bare;
        for place in 0..count {
            self.scope.member = Some(place);
            let entry = self.lower(argument);
            self.scope.member = outer;
            let entry = entry?;
            measure = entry.measure;
            entries.push(entry.expr);
        }
        let expr = self.length(&entries);
        Some(Quantity { expr, measure })
    }

    /// `force axes = value`: on each member.
    pub(super) fn lower_set_force(&mut self, set: &str, value: &Expr) -> Option<()> {
        let members = self.scope.sets.get(set).cloned().unwrap_or_default();
        for (place, index) in members.into_iter().enumerate() {
            self.scope.member = Some(place);
            let quantity = self.lower(value);
            self.scope.member = None;
            self.add_force(index, quantity?, set, value.span)?;
        }
        Some(())
    }

    /// Whether a name is a port for several coordinates.
    pub(super) fn is_set(&self, name: &str) -> bool {
        matches!(self.scope.ports.get(name), Some((PortKind::Coordinates, _)))
    }
}
