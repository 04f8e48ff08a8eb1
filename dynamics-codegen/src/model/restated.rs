//! `parameter link_2_mass = 1.3;`: another value for what a robot description says, and what is
//! believed of it (`prior normal(1.3, 0.1)`).
//!
//! The statement has no unit: that of the parameter is known. Bodies are built as soon as the
//! description is read, so the values must be known before.

use super::Belief;
use super::builder::Builder;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::{Expr, Name, Prior, Statement, StatementKind};
use std::collections::BTreeMap;

/// Values that the model states anew, and whether the description took each.
#[derive(Debug, Default)]
pub(super) struct Restated {
    values: BTreeMap<String, Stated>,
    taken: Vec<Span>,
}

#[derive(Debug)]
struct Stated {
    span: Span,
    value: Expr,
    prior: Option<Prior>,
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
                prior,
                tries: None,
            } = &statement.kind
            {
                let values = &mut self.restated.values;
                let stated = || Stated {
                    span: name.span,
                    value: value.clone(),
                    prior: prior.as_deref().cloned(),
                };
                values.entry(name.text.clone()).or_insert_with(stated);
            }
        }
    }

    /// The value of a link's or joint's parameter, the model's own or the description's, and what is
    /// believed of it.
    pub(super) fn stated_for_robot(
        &mut self,
        name: &str,
        lower: f64,
        described: f64,
    ) -> (f64, Option<Belief>) {
        let Some(stated) = self.restated.values.remove(name) else {
            return (described, None);
        };
        self.restated.taken.push(stated.span);
        let value = self.number(&stated.value).unwrap_or(described);
        let belief = stated.prior.and_then(|prior| self.belief(&prior));
        if value < lower {
            let message = format!("the value {value} of `{name}` is below {lower}");
            self.report::<()>(Diagnostic::error(stated.value.span, message));
            return (described, belief);
        }
        (value, belief)
    }

    /// Whether the description took the value of the statement that has this name.
    pub(super) fn is_restated(&self, name: &Name) -> bool {
        self.restated.taken.contains(&name.span)
    }
}
