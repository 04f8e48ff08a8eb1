//! Constraints that come and go: `constraint table when touching: …`.

use super::builder::Builder;
use crate::syntax::Expr;

impl Builder<'_> {
    /// The condition of the constraint that was lowered last.
    pub(super) fn lower_switch(&mut self, when: Option<&Expr>) -> Option<()> {
        let when = when?;
        let quantity = self.lower(when)?;
        self.refuse_momentary(quantity.expr, when.span, "a condition")?;
        self.model.constraints.last_mut()?.active = Some(quantity.expr);
        Some(())
    }
}
