//! One emitted function: its signature, documentation and body.

use super::Unit;
use super::documentation::{Doc, of_quantity};
use super::language::{Rust, numbers_as_stated};
use super::layout::{Array, Writer};
use crate::emit::body::{Body, Statement, Term};
use crate::emit::plan::{Function, Quantity};
use crate::emit::symbols::Role;
use crate::emit::written::Language;
use crate::graph::Precedence;

/// The type of a quantity: `[T; n]` or `[[T; n]; m]`.
fn shape(quantity: &Quantity) -> String {
    let rows = quantity.rows.len();
    match &quantity.columns {
        None => format!("[T; {rows}]"),
        Some(columns) => format!("[[T; {}]; {rows}]", columns.len()),
    }
}

impl Unit<'_> {
    /// A function that computes one quantity.
    pub(super) fn single(&self, w: &mut Writer, function: &Function<'_>) {
        let quantity = function.quantities[0];
        let body = function.body(self.compiled, &self.symbols);
        w.doc(&of_quantity(quantity));
        self.function(w, function.name, &body, &shape(quantity), |w| {
            w.array("", &self.array(quantity, &body.results, &body), "");
        });
    }

    /// A function that computes several quantities from the same temporaries, and
    /// the struct that it returns.
    pub(super) fn fused(&self, w: &mut Writer, function: &Function<'_>) {
        w.doc(&Doc::of("Everything that the equation of motion needs."));
        w.line("#[derive(Clone, Copy, Debug, PartialEq)]");
        w.block("pub struct EquationOfMotion<T> {", "}", |w| {
            for quantity in &function.quantities {
                w.doc(&of_quantity(quantity));
                w.line(format!("pub {}: {},", quantity.name, shape(quantity)));
            }
        });
        w.blank();
        let body = function.body(self.compiled, &self.symbols);
        w.doc(&Doc::of(
            "Everything that the equation of motion needs; shared terms are computed once.",
        ));
        self.function(w, function.name, &body, "EquationOfMotion<T>", |w| {
            w.block("EquationOfMotion {", "}", |w| {
                let mut results = body.results.as_slice();
                for quantity in &function.quantities {
                    let (own, rest) = results.split_at(quantity.entries.len());
                    results = rest;
                    let value = self.array(quantity, own, &body);
                    w.array(&format!("{}: ", quantity.name), &value, ",");
                }
            });
        });
    }

    fn function(
        &self,
        w: &mut Writer,
        name: &str,
        body: &Body,
        result: &str,
        last: impl FnOnce(&mut Writer),
    ) {
        if let Some(attribute) = numbers_as_stated(&body.constants) {
            w.line(attribute);
        }
        let name = format!("pub fn {name}<T: Scalar>");
        w.function(&name, &self.arguments(body), result, |w| {
            self.prologue(w, body);
            self.statements(w, body);
            last(w);
        });
    }

    /// `p: &Parameters<T>` and `x: &Point<T, n, k, s>`, with `_` in front of what is
    /// not read.
    fn arguments(&self, body: &Body) -> [String; 2] {
        let parameter = |role: Role| matches!(role, Role::Parameter(_));
        let mark = |read: bool| if read { "" } else { "_" };
        let p = mark(body.reads_any(parameter));
        let x = mark(body.reads_any(|role| !parameter(role)));
        [
            format!("{p}p: &Parameters<T>"),
            format!("{x}x: &{}", self.point()),
        ]
    }

    /// Takes out of the point what the body reads.
    fn prologue(&self, w: &mut Writer, body: &Body) {
        for (name, role) in self.symbols.read_by(body) {
            let place = match role {
                Role::Time => "t".to_string(),
                Role::Position(i) => format!("q[{i}]"),
                Role::Velocity(i) => format!("v[{i}]"),
                Role::Input(i) => format!("u[{i}]"),
                Role::State(i) => format!("z[{i}]"),
                Role::Parameter(_) => continue,
            };
            w.line(format!("let {name} = x.{place};"));
        }
    }

    fn statements(&self, w: &mut Writer, body: &Body) {
        let (rust, locals) = (
            Rust {
                symbols: &self.symbols,
            },
            &body.locals,
        );
        for statement in &body.statements {
            match statement {
                Statement::Let { local, value } => {
                    w.line(format!(
                        "let {} = {};",
                        locals[*local],
                        rust.write(value, locals).text
                    ));
                }
                Statement::SinCos {
                    sine,
                    cosine,
                    argument,
                } => {
                    let argument = rust.write(argument, locals).within(Precedence::Atom);
                    let (sine, cosine) = (&locals[*sine], &locals[*cosine]);
                    w.line(format!("let ({sine}, {cosine}) = {argument}.sin_cos();"));
                }
            }
        }
    }

    /// The results in the shape of their quantity.
    fn array(&self, quantity: &Quantity, results: &[Term], body: &Body) -> Array {
        let rust = Rust {
            symbols: &self.symbols,
        };
        let entry = |term: &Term| Array::of(rust.write(term, &body.locals).text);
        let entries: Vec<Array> = results.iter().map(entry).collect();
        match &quantity.columns {
            None => Array::Row(entries),
            Some(columns) => Array::Row(
                entries
                    .chunks(columns.len())
                    .map(|row| Array::Row(row.to_vec()))
                    .collect(),
            ),
        }
    }
}
