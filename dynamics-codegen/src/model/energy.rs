//! Kinetic energy, potential energy and dissipation, and what they may not contain.

use super::builder::Builder;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::ExprId;
use crate::source::Span;
use crate::syntax::Expr;

impl Builder<'_> {
    /// `kinetic e;`: added to the kinetic energy.
    pub(super) fn lower_kinetic(&mut self, value: &Expr) -> Option<()> {
        self.has_kinetic = true;
        let energy = self.energy(value, Dimension::ENERGY, "kinetic energy")?;
        self.model.kinetic = self.model.graph.add(self.model.kinetic, energy);
        Some(())
    }

    /// `potential e;`: added to the potential energy.
    pub(super) fn lower_potential(&mut self, value: &Expr) -> Option<()> {
        let energy = self.energy(value, Dimension::ENERGY, "potential energy")?;
        self.refuse_velocity(energy, value.span, "potential energy")?;
        self.model.potential = self.model.graph.add(self.model.potential, energy);
        Some(())
    }

    /// `dissipation p;`: added to the Rayleigh dissipation, a power.
    pub(super) fn lower_dissipation(&mut self, value: &Expr) -> Option<()> {
        let power = self.energy(value, Dimension::ENERGY.rate(), "dissipation")?;
        self.model.dissipation = self.model.graph.add(self.model.dissipation, power);
        Some(())
    }

    fn energy(&mut self, value: &Expr, dimension: Dimension, role: &str) -> Option<ExprId> {
        let quantity = self.lower(value)?;
        self.expect_dimension(quantity, dimension, value.span, role)?;
        self.refuse_inputs(quantity.expr, value.span, role)?;
        Some(quantity.expr)
    }

    fn refuse_velocity(&mut self, expr: ExprId, span: Span, role: &str) -> Option<()> {
        let found = self
            .model
            .coordinates
            .iter()
            .find(|c| self.model.graph.depends_on(&[expr], c.velocity));
        match found.map(|c| c.name.clone()) {
            None if self.model.contains_velocity(expr) => self.report(Diagnostic::error(
                span,
                format!("{role} contains the velocity of a frame"),
            )),
            None => Some(()),
            Some(name) => self.report(Diagnostic::error(
                span,
                format!("{role} contains the velocity `dot({name})`"),
            )),
        }
    }

    pub(super) fn refuse_inputs(&mut self, expr: ExprId, span: Span, role: &str) -> Option<()> {
        let found = self
            .model
            .inputs
            .iter()
            .find(|u| self.model.graph.depends_on(&[expr], u.symbol));
        match found.map(|u| u.name.clone()) {
            None => self.refuse_memory(expr, span, role),
            Some(name) => self.report(
                Diagnostic::error(span, format!("{role} contains the input `{name}`"))
                    .help("an input acts through `force`"),
            ),
        }
    }
}
