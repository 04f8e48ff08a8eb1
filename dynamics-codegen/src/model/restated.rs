//! `parameter link_2_mass = 1.3;`: another value for what a robot description says.
//!
//! The statement has no unit: that of the parameter is known. Bodies are built as soon as the
//! description is read, so the values must be known before.

use super::builder::Builder;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::{Expr, Name, Statement, StatementKind};
use std::collections::BTreeMap;

/// Values that the model states anew, and whether the description took each.
#[derive(Debug, Default)]
pub(super) struct Restated {
    values: BTreeMap<String, (Span, Expr)>,
    taken: Vec<Span>,
}

impl Builder<'_> {
    /// Notes what may be meant for the robot description.
    pub(super) fn note_restated(&mut self, statements: &[&Statement]) {
        for statement in statements {
            if let StatementKind::Parameter {
                name,
                unit: None,
                nominal: Some(value),
                bounds: None,
                prior: None,
                tries: None,
            } = &statement.kind
            {
                let values = &mut self.restated.values;
                let stated = || (name.span, value.clone());
                values.entry(name.text.clone()).or_insert_with(stated);
            }
        }
    }

    /// The value of a link's or joint's parameter: the model's own, or the description's.
    pub(super) fn stated_for_robot(&mut self, name: &str, lower: f64, described: f64) -> f64 {
        let Some((span, expr)) = self.restated.values.remove(name) else {
            return described;
        };
        self.restated.taken.push(span);
        let value = self.number(&expr).unwrap_or(described);
        if value < lower {
            let message = format!("the value {value} of `{name}` is below {lower}");
            self.report::<()>(Diagnostic::error(expr.span, message));
            return described;
        }
        value
    }

    /// Whether the description took the value of the statement that has this name.
    pub(super) fn is_restated(&self, name: &Name) -> bool {
        self.restated.taken.contains(&name.span)
    }
}
