//! Whether a model's equations can be those of a machine.
//!
//! The compiler sees to the form: names, units, brackets. That kinetic energy is positive,
//! and that no two constraints ask for different things, depends on numbers: it is tried
//! at some states, with the nominal parameters. What is found here has its place in the
//! text, as everything else.

mod constraints;
mod inertia;
mod states;

use crate::derive::System;
use crate::diagnostic::Diagnostic;
use crate::model::Model;
use crate::source::Span;
use crate::syntax::{File, Heading, StatementKind};
use states::States;

/// Everything that is implausible about a derived model.
pub(crate) fn check(model: &Model, system: &System, file: &File, findings: &mut Vec<Diagnostic>) {
    let states = States::of(model);
    let places = Places(file);
    let found = inertia::check(model, system, &states, places, findings);
    findings.extend(found);
    findings.extend(constraints::check(model, system, &states, places));
}

/// Where a model's text declares things.
#[derive(Clone, Copy)]
struct Places<'a>(&'a File);

impl Places<'_> {
    /// `None` for one that comes from a robot description.
    fn coordinate(self, name: &str) -> Option<Span> {
        self.find(|kind| match kind {
            StatementKind::Coordinate { name: found, .. } if found.text == name => Some(found.span),
            _ => None,
        })
    }

    fn parameter(self, name: &str) -> Option<Span> {
        self.find(|kind| match kind {
            StatementKind::Parameter { name: found, .. } if found.text == name => Some(found.span),
            _ => None,
        })
    }

    fn constraint(self, name: &str) -> Option<Span> {
        self.find(|kind| match kind {
            StatementKind::Constraint { name: found, .. } if found.text == name => Some(found.span),
            _ => None,
        })
    }

    /// Where to point for what the text does not declare itself.
    fn heading(self) -> Span {
        let (Heading::Model(name) | Heading::Effect { name, .. }) = &self.0.heading;
        name.span
    }

    fn find(self, is: impl Fn(&StatementKind) -> Option<Span>) -> Option<Span> {
        let mut statements = self.0.statements.iter();
        statements.find_map(|statement| is(&statement.kind))
    }
}
