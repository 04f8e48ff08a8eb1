//! A drive as a place of effects: the shaft that an input turns, geared to coordinates in fixed ratios.
//!
//! A motor between two bodies whose angles are both counted from a third acts on both coordinates:
//! `force wheel = u; force pitch = -u;`. What turns in its bearing is the difference. With the ratios
//! `r_i = ∂Q_i/∂u` the shaft turns at `Σ r_i dot(q_i)`, which with `u` is the power that it does, and a
//! force on it acts on every coordinate `r_i` times.

use super::Model;
use super::builder::Builder;
use super::quantity::{Measure, Quantity};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::ExprId;
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name, PortKind};

impl Model {
    /// The inputs that turn a shaft of their own, geared to two coordinates or more in fixed ratios. What
    /// acts on a single coordinate is that coordinate's.
    pub fn drives(&self) -> Vec<usize> {
        let mut graph = self.graph.clone();
        let turns = |&input: &usize| {
            let symbol = self.inputs[input].symbol;
            let ratios = graph.derivatives(&self.forces, symbol);
            let moved = ratios.iter().filter(|&&ratio| !graph.is_zero(ratio));
            moved.count() > 1 && self.are_ratios(&ratios) && !self.acts_at_a_point(input)
        };
        (0..self.inputs.len()).filter(turns).collect()
    }

    /// Whether nothing that changes while the machine moves is in them.
    fn are_ratios(&self, ratios: &[ExprId]) -> bool {
        let parameters: Vec<_> = self.parameters.iter().map(|p| p.symbol).collect();
        let mut read = self.graph.symbols_in(ratios).into_iter();
        read.all(|symbol| parameters.contains(&symbol))
    }

    fn acts_at_a_point(&self, input: usize) -> bool {
        let symbol = self.inputs[input].symbol;
        let mut forces = self.point_forces.iter();
        forces.any(|force| self.graph.depends_on(&force.value, symbol))
    }
}

impl Builder<'_> {
    /// The input whose shaft an effect acts on.
    pub(super) fn find_drive(&mut self, name: &Name) -> Option<usize> {
        let input = self.find_input(name)?;
        self.ratios(input, name.span).map(|_| input)
    }

    /// What the shaft's place is measured in: with the input it makes an energy.
    pub(super) fn shaft_dimension(&self, input: usize) -> Option<Dimension> {
        let of_input = self.model.inputs[input].dimension?;
        Some(Dimension::ENERGY / of_input)
    }

    /// `r_i` of every coordinate.
    fn ratios(&mut self, input: usize, span: Span) -> Option<Vec<ExprId>> {
        let symbol = self.model.inputs[input].symbol;
        let ratios = self.model.graph.derivatives(&self.model.forces, symbol);
        let is_moved = |&ratio: &ExprId| !self.model.graph.is_zero(ratio);
        let drives = ratios.iter().any(is_moved);
        if drives && self.model.are_ratios(&ratios) && !self.model.acts_at_a_point(input) {
            return Some(ratios);
        }
        let name = &self.model.inputs[input].name;
        let message = format!("the input `{name}` does not drive coordinates in fixed ratios");
        self.report(Diagnostic::error(span, message).help(
            "what it drives has no speed of its own: apply an effect on a coordinate instead",
        ))
    }

    /// `dot(shaft)`: nothing if the argument is none.
    pub(super) fn lower_shaft_speed(&mut self, argument: &Expr) -> Option<Option<Quantity>> {
        let ExprKind::Name(name) = &argument.kind else {
            return Some(None);
        };
        let Some(input) = self.shaft(name) else {
            return Some(None);
        };
        let ratios = self.ratios(input, argument.span)?;
        let graph = &mut self.model.graph;
        let mut speed = graph.zero();
        for (coordinate, &ratio) in self.model.coordinates.iter().zip(&ratios) {
            let velocity = graph.var(coordinate.velocity);
            let share = graph.mul(ratio, velocity);
            speed = graph.add(speed, share);
        }
        let measure = Measure::of(self.shaft_dimension(input)).rate();
        Some(Some(Quantity {
            expr: speed,
            measure,
        }))
    }

    /// `force shaft = f;`
    pub(super) fn lower_shaft_force(
        &mut self,
        input: usize,
        on: &Name,
        value: &Expr,
    ) -> Option<()> {
        let force = self.lower(value)?;
        if let Some(dimension) = self.model.inputs[input].dimension {
            let role = format!("a force on `{}`", on.text);
            self.expect_dimension(force, dimension, value.span, &role)?;
        }
        for (coordinate, ratio) in self.ratios(input, on.span)?.into_iter().enumerate() {
            if !self.model.graph.is_zero(ratio) {
                let share = Quantity {
                    expr: self.model.graph.mul(ratio, force.expr),
                    measure: Measure::Unchecked,
                };
                self.add_force(coordinate, share, &on.text, value.span)?;
            }
        }
        Some(())
    }

    /// The input whose shaft a port stands for.
    pub(super) fn shaft(&self, name: &str) -> Option<usize> {
        match self.scope.ports.get(name) {
            Some(&(PortKind::Drive, input)) => Some(input),
            _ => None,
        }
    }
}
