//! First pass: every name of the text is known before anything is lowered.

use super::builder::Builder;
use super::names::{Binding, Declared, RESERVED, Term, TermState};
use super::unit::unit_text;
use super::{Coordinate, Input};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::source::{Sources, Span};
use crate::syntax::{Expr, Name, Statement, StatementKind, Unit};
use std::collections::BTreeSet;

impl Builder<'_> {
    /// First pass: every name, so that the order of the text does not matter.
    pub(super) fn declare(
        &mut self,
        statements: &[&Statement],
        sources: &mut Sources,
        library: &super::Library,
    ) {
        self.note_restated(statements);
        self.scope.parameters = parameters(statements);
        for statement in statements {
            match &statement.kind {
                StatementKind::Robot {
                    format,
                    file,
                    options,
                } => self.declare_robot(*format, file, options, sources, library),
                StatementKind::Frame { name, value } => self.declare_frame(name, value),
                StatementKind::Body(body) => self.declare_body(body),
                StatementKind::Coordinate { name, unit } => {
                    self.declare_coordinate(name, unit.as_ref(), &statement.doc);
                }
                StatementKind::Input { name, unit } => {
                    self.declare_input(name, unit.as_ref(), &statement.doc);
                }
                StatementKind::State { name, unit, .. } => {
                    self.declare_state(name, unit.as_ref(), &statement.doc);
                }
                StatementKind::Constant { name, unit, value } => {
                    let declared = unit.as_ref().and_then(|unit| self.dimension(unit));
                    self.declare_term(name, value, declared, true);
                }
                StatementKind::Let { name, value } => self.declare_term(name, value, None, false),
                _ => {}
            }
        }
        // Numbers of tables may use constants, and values of constants tables.
        for statement in statements {
            if let StatementKind::Table(table) = &statement.kind {
                self.declare_table(table, &statement.doc, sources, library);
            }
        }
        // Nominal values and bounds may use constants.
        for statement in statements {
            if let StatementKind::Parameter {
                name,
                unit,
                nominal,
                bounds,
                prior,
                tries,
            } = &statement.kind
                && !self.is_restated(name)
            {
                self.declare_parameter(
                    name,
                    unit.as_ref(),
                    nominal.as_ref(),
                    bounds.as_ref(),
                    prior.as_deref(),
                    &statement.doc,
                );
                self.set_tries(name, tries.as_ref());
            }
        }
        self.scope.parameters.clear();
    }

    fn declare_coordinate(&mut self, name: &Name, unit: Option<&Unit>, doc: &str) {
        let dimension = unit.and_then(|unit| self.dimension(unit));
        let graph = &mut self.model.graph;
        let coordinate = Coordinate {
            name: name.text.clone(),
            dimension,
            unit: unit.map_or_else(String::new, unit_text),
            position: graph.symbol(format!("q_{}", name.text)),
            velocity: graph.symbol(format!("dq_{}", name.text)),
            doc: doc.to_string(),
        };
        let zero = graph.zero();
        let binding = Binding::Coordinate(self.model.coordinates.len());
        if self.bind(name, binding) {
            self.model.coordinates.push(coordinate);
            self.model.forces.push(zero);
        }
    }

    fn declare_input(&mut self, name: &Name, unit: Option<&Unit>, doc: &str) {
        if let Some(first) = self.scope.inputs.get(&name.text) {
            let first = first.span;
            self.duplicate(name, first);
            return;
        }
        let dimension = unit.and_then(|unit| self.dimension(unit));
        let symbol = self.model.graph.symbol(format!("u_{}", name.text));
        let arrives = self.model.graph.var(symbol);
        let input = Input {
            name: name.text.clone(),
            dimension,
            unit: unit.map_or_else(String::new, unit_text),
            symbol,
            arrives,
            doc: doc.to_string(),
            assumed: false,
        };
        self.push_input(input, name.span);
    }

    /// Adds an input whose name is free.
    pub(super) fn push_input(&mut self, input: Input, span: Span) {
        let declared = Declared {
            what: self.model.inputs.len(),
            span,
        };
        self.scope.inputs.insert(input.name.clone(), declared);
        self.channels.push(input.arrives);
        self.model.inputs.push(input);
    }

    fn declare_term(
        &mut self,
        name: &Name,
        value: &Expr,
        declared: Option<Dimension>,
        constant: bool,
    ) {
        let binding = Binding::Term(self.scope.terms.len());
        if self.bind(name, binding) {
            let state = TermState::Waiting;
            self.scope.terms.push(Term {
                name: name.clone(),
                value: value.clone(),
                declared,
                state,
                constant,
            });
        }
    }

    /// Binds a plain word; `false` (and a finding) if it is taken.
    pub(super) fn bind(&mut self, name: &Name, what: Binding) -> bool {
        if RESERVED.contains(&name.text.as_str()) {
            let message = format!(
                "`{}` has a meaning of its own and cannot be redefined",
                name.text
            );
            self.report::<()>(Diagnostic::error(name.span, message));
            return false;
        }
        let taken = self
            .scope
            .names
            .get(&name.text)
            .map(|declared| declared.span);
        if let Some(first) = taken {
            self.duplicate(name, first);
            return false;
        }
        self.scope.names.insert(
            name.text.clone(),
            Declared {
                what,
                span: name.span,
            },
        );
        true
    }

    pub(super) fn duplicate(&mut self, name: &Name, first: Span) {
        self.report::<()>(
            Diagnostic::error(name.span, format!("`{}` is defined twice", name.text))
                .label("again here")
                .also(first, "first here"),
        );
    }
}

/// The names of the parameters that are declared.
fn parameters(statements: &[&Statement]) -> BTreeSet<String> {
    let names = statements
        .iter()
        .filter_map(|statement| match &statement.kind {
            StatementKind::Parameter { name, .. } => Some(name.text.clone()),
            _ => None,
        });
    names.collect()
}
