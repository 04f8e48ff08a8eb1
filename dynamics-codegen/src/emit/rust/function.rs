//! One emitted function: its signature, documentation and body.

use super::documentation::{Doc, of_quantity};
use super::language::{Rust, numbers_as_stated};
use super::layout::{Array, Writer};
use super::{Unit, result_name};
use crate::emit::body::{Body, Circular, Statement, Term};
use crate::emit::plan::{Function, Quantity};
use crate::emit::symbols::Argument;
use crate::emit::written::Language;
use crate::graph::Precedence;

/// The type of a quantity: `[T; n]` or `[[T; n]; m]`.
fn shape(quantity: &Quantity) -> String {
    let lengths = quantity.shape().into_iter().rev();
    lengths.fold("T".to_string(), |inner, length| {
        format!("[{inner}; {length}]")
    })
}

impl Unit<'_> {
    /// A function that computes one quantity.
    pub(super) fn single(&self, w: &mut Writer, function: &Function) {
        let quantity = &function.quantities[0];
        let body = function.body(&self.plan.model, &self.symbols);
        w.doc(&of_quantity(quantity));
        self.function(w, function, &body, &shape(quantity), |w| {
            w.array("", &self.array(quantity, &body.results, &body), "");
        });
    }

    /// A function that computes several quantities from the same temporaries, and
    /// the struct that it returns.
    pub(super) fn fused(&self, w: &mut Writer, function: &Function) {
        let name = result_name(function);
        w.doc(&Doc::of(format!("{}.", function.meaning)));
        w.line("#[derive(Clone, Copy, Debug, PartialEq)]");
        w.block(&format!("pub struct {name}<T> {{"), "}", |w| {
            for quantity in &function.quantities {
                w.doc(&of_quantity(quantity));
                w.line(format!("pub {}: {},", quantity.name, shape(quantity)));
            }
        });
        w.blank();
        let body = function.body(&self.plan.model, &self.symbols);
        w.doc(&Doc::of(format!(
            "{}; shared terms are computed once.",
            function.meaning
        )));
        self.function(w, function, &body, &format!("{name}<T>"), |w| {
            w.block(&format!("{name} {{"), "}", |w| {
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
        function: &Function,
        body: &Body,
        result: &str,
        last: impl FnOnce(&mut Writer),
    ) {
        if let Some(attribute) = numbers_as_stated(&body.constants) {
            w.line(attribute);
        }
        let name = format!("pub fn {}<T: Scalar>", function.name);
        w.function(&name, &self.arguments(function, body), result, |w| {
            self.prologue(w, body);
            self.statements(w, body);
            last(w);
        });
    }

    /// `p: &Parameters<T>`, `x: &Point<T, n, k, s>`, `a` and `lambda`, with `_` in front of what is
    /// not read.
    fn arguments(&self, function: &Function, body: &Body) -> Vec<String> {
        let mark = |argument: Argument| {
            let read = body.reads_any(|role| role.argument() == argument);
            if read { "" } else { "_" }
        };
        let (p, x) = (mark(Argument::Parameters), mark(Argument::Point));
        let mut arguments = vec![
            format!("{p}p: &Parameters<T>"),
            format!("{x}x: &{}", self.point()),
        ];
        let model = &self.plan.model;
        if function.takes_acceleration() {
            let a = mark(Argument::Acceleration);
            arguments.push(format!("{a}a: &[T; {}]", model.coordinates.len()));
        }
        if function.takes_multipliers() {
            let lambda = mark(Argument::Multipliers);
            arguments.push(format!("{lambda}lambda: &[T; {}]", model.constraints.len()));
        }
        arguments
    }

    /// Takes out of the point what the body reads.
    fn prologue(&self, w: &mut Writer, body: &Body) {
        for (name, role) in self.symbols.read_by(body) {
            if let Some(place) = role.place(".") {
                w.line(format!("let {name} = {place};"));
            }
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
                Statement::SinCosEach(group) => {
                    let angle = |c: &Circular| Array::of(rust.write(&c.argument, locals).text);
                    let angles = Array::Row(group.iter().map(angle).collect());
                    w.array("let angles = ", &angles, ";");
                    w.line("let circular = T::sin_cos_each(angles);");
                    for (index, Circular { sine, cosine, .. }) in group.iter().enumerate() {
                        let (sine, cosine) = (&locals[*sine], &locals[*cosine]);
                        w.line(format!("let ({sine}, {cosine}) = circular[{index}];"));
                    }
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
        let mut entries: Vec<Array> = results.iter().map(entry).collect();
        for &length in quantity.shape().iter().skip(1).rev() {
            let rows = entries.chunks(length);
            entries = rows.map(|row| Array::Row(row.to_vec())).collect();
        }
        Array::Row(entries)
    }
}
