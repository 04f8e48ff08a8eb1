//! One emitted function: its signature, documentation and body.

use super::documentation::{Doc, of_quantity};
use super::language::{Rust, numbers_as_stated};
use super::layout::{Array, Writer};
use super::{Unit, result_name};
use crate::emit::body::{Body, Circular, Statement, Term};
use crate::emit::plan::{Function, Quantity};
use crate::emit::solved::Solved;
use crate::emit::split::{Part, Parts};
use crate::emit::symbols::{Argument, Role};
use crate::emit::written::Language;
use crate::graph::Precedence;
use std::collections::BTreeSet;

/// The type of a quantity: `[T; n]` or `[[T; n]; m]`.
fn shape(quantity: &Quantity) -> String {
    let lengths = quantity.shape().into_iter().rev();
    lengths.fold("T".to_string(), |inner, length| {
        format!("[{inner}; {length}]")
    })
}

/// What a function returns.
fn result(function: &Function) -> String {
    match function.fused {
        true => format!("{}<T>", result_name(function)),
        false => shape(&function.quantities[0]),
    }
}

/// The arguments of a function, as far as they are `wanted`.
fn handed(function: &Function, wanted: impl Fn(Argument) -> bool) -> Vec<&'static str> {
    let all = [
        ("p", Argument::Parameters),
        ("x", Argument::Point),
        ("a", Argument::Acceleration),
        ("lambda", Argument::Multipliers),
    ];
    let own = all.into_iter();
    let own = own.filter(|&(_, argument)| function.takes(argument) && wanted(argument));
    own.map(|(name, _)| name).collect()
}

impl Unit<'_> {
    /// A function that computes one quantity.
    pub(super) fn single(&self, w: &mut Writer, function: &Function) {
        let quantity = &function.quantities[0];
        w.doc(&of_quantity(quantity));
        if let Some(solved) = &function.solved {
            return self.solving(w, function, solved, &shape(quantity));
        }
        let body = function.body(&self.plan.model, &self.symbols, ".");
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
        self.entries(w, function, &name);
        w.blank();
        w.doc(&Doc::of(format!(
            "{}; shared terms are computed once.",
            function.meaning
        )));
        if let Some(solved) = &function.solved {
            return self.solving(w, function, solved, &format!("{name}<T>"));
        }
        let body = function.body(&self.plan.model, &self.symbols, ".");
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

    /// `impl Entries`: the struct as one list of numbers.
    fn entries(&self, w: &mut Writer, function: &Function, name: &str) {
        w.implementation("::dynamics::Entries<T>", &format!("{name}<T>"), |w| {
            let length: usize = function.quantities.iter().map(Quantity::len).sum();
            w.line(format!("const LENGTH: usize = {length};"));
            w.blank();
            w.line("#[inline(always)]");
            let start =
                "fn each_of<const R: usize>(results: [&Self; R], take: &mut impl FnMut([&T; R])) {";
            w.block(start, "}", |w| {
                for quantity in &function.quantities {
                    w.line(format!(
                        "let part = results.map(|result| &result.{});",
                        quantity.name
                    ));
                    w.line("::dynamics::Entries::each_of(part, take);");
                }
            });
        });
    }

    /// A function that solves in loops.
    fn solving(&self, w: &mut Writer, function: &Function, solved: &Solved, result: &str) {
        let name = format!("pub fn {}<T: Scalar>", function.name);
        let arguments = self.arguments(function, |_| true);
        w.function(&name, &arguments, result, |w| {
            self.solution(w, function, solved);
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
        let parts = Parts::of(body, &self.symbols);
        let name = format!("pub fn {}<T: Scalar>", function.name);
        let giver = self.plan.giver(function);
        let arguments = self.arguments(function, |argument| {
            body.reads_any(|role| role.argument() == argument)
                || giver.is_some_and(|giver| giver.takes(argument))
        });
        let (own, before) = parts.parts.split_last().expect("there is a last part");
        w.function(&name, &arguments, result, |w| {
            if let Some(giver) = giver {
                let handed = handed(giver, |argument| giver.takes(argument));
                w.line(format!(
                    "let given = {}({});",
                    giver.name,
                    handed.join(", ")
                ));
            }
            if parts.are_several() {
                w.line(format!("let mut w = [T::zero(); {}];", parts.places));
                for (index, part) in before.iter().enumerate() {
                    let mut handed = handed(function, |argument| part.reads_of(argument));
                    handed.extend(part.reads_given.then_some("&given"));
                    handed.push("&mut w");
                    let handed = handed.join(", ");
                    w.line(format!("{}_part_{}({handed});", function.name, index + 1));
                }
            }
            self.part(w, body, own);
            last(w);
        });
        for (index, part) in before.iter().enumerate() {
            w.blank();
            self.part_function(w, function, body, (index + 1, part, &parts));
        }
    }

    /// A part of a long body as a function of its own.
    fn part_function(
        &self,
        w: &mut Writer,
        function: &Function,
        body: &Body,
        (number, part, parts): (usize, &Part, &Parts),
    ) {
        w.doc(&Doc::of(format!(
            "Part {number} of {} of [`{}`]; `w` carries temporaries from part to part.",
            parts.parts.len(),
            function.name
        )));
        w.line("#[inline(never)]");
        let constants = body.constants_of(part.statements.clone());
        if let Some(attribute) = numbers_as_stated(&constants) {
            w.line(attribute);
        }
        let mut arguments = self.arguments(function, |argument| part.reads_of(argument));
        arguments.retain(|argument| !argument.starts_with('_'));
        if let Some(giver) = self.plan.giver(function).filter(|_| part.reads_given) {
            arguments.push(format!("given: &{}", result(giver)));
        }
        arguments.push(format!("w: &mut [T; {}]", parts.places));
        let name = format!("fn {}_part_{number}<T: Scalar>", function.name);
        w.procedure(&name, &arguments, |w| {
            self.part(w, body, part);
            for &(local, place) in &part.gives {
                w.line(format!("w[{place}] = {};", body.locals[local]));
            }
        });
    }

    /// Arguments, carried temporaries and statements of a part.
    fn part(&self, w: &mut Writer, body: &Body, part: &Part) {
        self.prologue(w, &part.reads);
        for &(local, place) in &part.takes {
            w.line(format!("let {} = w[{place}];", body.locals[local]));
        }
        self.statements(w, body, &body.statements[part.statements.clone()]);
    }

    /// `p: &Parameters<T>`, `x: &Point<T, n, k, s>`, `a` and `lambda`, with `_` in front of what is
    /// not read.
    fn arguments(&self, function: &Function, reads: impl Fn(Argument) -> bool) -> Vec<String> {
        let mark = |argument: Argument| if reads(argument) { "" } else { "_" };
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
    fn prologue(&self, w: &mut Writer, reads: &BTreeSet<Role>) {
        for (name, role) in self.symbols.read_by(reads) {
            if let Some(place) = role.place(".") {
                w.line(format!("let {name} = {place};"));
            }
        }
    }

    fn statements(&self, w: &mut Writer, body: &Body, statements: &[Statement]) {
        let (rust, locals) = (
            Rust {
                symbols: &self.symbols,
            },
            &body.locals,
        );
        for statement in statements {
            match statement {
                Statement::Let { local, value } => {
                    w.binding(&locals[*local], &rust.write(value, locals).text);
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
                    for group in group.chunks(4) {
                        self.circular(w, group, body);
                    }
                }
            }
        }
    }

    /// Up to four sines and cosines side by side.
    fn circular(&self, w: &mut Writer, group: &[Circular], body: &Body) {
        let rust = Rust {
            symbols: &self.symbols,
        };
        let write = |c: &Circular| rust.write(&c.argument, &body.locals);
        let pair = |c: &Circular| format!("({}, {})", body.locals[c.sine], body.locals[c.cosine]);
        if let [only] = group {
            let argument = write(only).within(Precedence::Atom);
            return w.line(format!("let {} = {argument}.sin_cos();", pair(only)));
        }
        let arguments: Vec<String> = group.iter().map(|c| write(c).text).collect();
        let function = format!("T::sin_cos_{}", group.len());
        w.call("let circular = ", &function, &arguments, ";");
        for (index, c) in group.iter().enumerate() {
            w.line(format!("let {} = circular[{index}];", pair(c)));
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
