//! Constraints: equations that coordinates or their rates obey.

use super::builder::{Builder, MAX_SIZE};
use super::{Constraint, ConstraintKind};
use crate::diagnostic::Diagnostic;
use crate::graph::ExprId;
use crate::source::Span;
use crate::syntax::{Expr, Name};

impl Builder<'_> {
    /// `constraint c: left = right;`: the residual is `left - right`.
    pub(super) fn lower_constraint(
        &mut self,
        name: &Name,
        left: &Expr,
        right: &Expr,
        doc: &str,
    ) -> Option<()> {
        let (a, b) = (self.lower(left), self.lower(right));
        let (a, b) = (a?, b?);
        let measure = self.unify(a.measure, left.span, b.measure, right.span, "equated")?;
        let span = left.span.to(right.span);
        self.check_constraint(&name.text, name.span)?;
        let residual = self.model.graph.sub(a.expr, b.expr);
        self.refuse_inputs(residual, span, "a constraint")?;
        let kind = self.constraint_kind(residual, span)?;
        let time_dependent = self.model.graph.depends_on(&[residual], self.model.time);
        let multiplier = self.model.graph.symbol(format!("lambda_{}", name.text));
        self.model.constraints.push(Constraint {
            name: name.text.clone(),
            kind,
            time_dependent,
            multiplier,
            active: None,
            residual,
            dimension: measure.known(),
            doc: doc.to_string(),
        });
        Some(())
    }

    /// There is room for one constraint more, of a name that none has.
    pub(super) fn check_constraint(&mut self, name: &str, at: Span) -> Option<()> {
        if self.model.constraints.iter().any(|c| c.name == name) {
            let message = format!("there are two constraints named `{name}`");
            return self.report(Diagnostic::error(at, message));
        }
        if self.model.constraints.len() == MAX_SIZE {
            let message = format!("the model has more than {MAX_SIZE} constraints");
            return self.report(Diagnostic::error(at, message));
        }
        Some(())
    }

    /// Whether the residual restricts rates or coordinates.
    fn constraint_kind(&mut self, residual: ExprId, span: Span) -> Option<ConstraintKind> {
        if self.model.contains_velocity(residual) {
            Some(ConstraintKind::Nonholonomic)
        } else if self.model.contains_position(residual) {
            Some(ConstraintKind::Holonomic)
        } else {
            self.report(
                Diagnostic::error(span, "this constraint contains no coordinate")
                    .help("it would have to hold by itself; a constraint restricts coordinates or their rates"),
            )
        }
    }
}
