//! Parts: mechanisms that are written once and used several times.
//!
//! Before any name is looked up, every use becomes the statements of its part, with the use's
//! name in front of the names that the part defines: `left.q` is the coordinate `left_q`. What
//! the part names and does not define itself is the model's. All else in this crate sees
//! statements like any others; places of faults tell the uses apart, since a
//! [`SourceId`](crate::source::SourceId) also says as which use its text is read.

mod definition;
mod rename;
mod told;
mod values;

use crate::diagnostic::{Diagnostic, nearest};
use crate::model::{PartUse, RESERVED, TRANSFORMS};
use crate::source::{Sources, Span};
use crate::syntax::{
    self, Expr, ExprKind, File, Name, PartStatement, Statement, StatementKind, UseStatement,
};
use rename::{Scope, path};
use std::collections::{BTreeMap, BTreeSet};
pub(crate) use told::Readings;
pub use values::value_in_use;

/// Parts may use one another this deep.
const MAX_DEPTH: usize = 32;

/// A model with the uses of its parts written out.
pub(crate) struct Expanded {
    /// No statement is a part or a use.
    pub file: File,
    /// The uses, in the order of the text.
    pub uses: Vec<PartUse>,
    /// Who reads the part that a place stands in.
    pub readings: Readings,
}

/// Writes out all uses of parts. What is wrong with them is added to `findings`.
pub(crate) fn expand(file: File, sources: &Sources, findings: &mut Vec<Diagnostic>) -> Expanded {
    let concerns = |s: &Statement| matches!(s.kind, StatementKind::Part(_) | StatementKind::Use(_));
    let File {
        heading,
        doc,
        statements,
        unreadable,
    } = file;
    let mut expansion = Expansion {
        sources,
        findings,
        parts: BTreeMap::new(),
        top: names_of_uses(&statements),
        used: BTreeSet::new(),
        path: Vec::new(),
        statements: Vec::new(),
        unreadable,
        uses: Vec::new(),
        readings: Readings::default(),
        size: 0,
    };
    if statements.iter().any(concerns) {
        expansion.define(&statements);
        let model = Scope::model(expansion.top.clone());
        expansion.all(&statements, &model);
        expansion.warn_of_unused();
    } else {
        expansion.statements = statements;
    }
    Expanded {
        file: File {
            heading,
            doc,
            statements: expansion.statements,
            unreadable: expansion.unreadable,
        },
        uses: expansion.uses,
        readings: expansion.readings,
    }
}

/// The names of the uses among some statements.
fn names_of_uses(statements: &[Statement]) -> BTreeSet<String> {
    let names = statements.iter().filter_map(|s| match &s.kind {
        StatementKind::Use(used) => Some(used.name.text.clone()),
        _ => None,
    });
    names.collect()
}

/// The writing out, under way.
struct Expansion<'a, 'f> {
    sources: &'f Sources,
    findings: &'f mut Vec<Diagnostic>,
    parts: BTreeMap<&'a str, &'a PartStatement>,
    /// The uses in the model itself.
    top: BTreeSet<String>,
    /// The parts that something uses.
    used: BTreeSet<&'a str>,
    /// The parts that are being written out, each used by the one before.
    path: Vec<&'a str>,
    statements: Vec<Statement>,
    unreadable: Vec<Name>,
    uses: Vec<PartUse>,
    readings: Readings,
    /// About how long the model is with the uses written out.
    size: usize,
}

impl<'a> Expansion<'a, '_> {
    fn report(&mut self, finding: Diagnostic) {
        self.findings.push(finding);
    }

    /// All statements of the model or of a part that `scope` reads.
    fn all(&mut self, statements: &'a [Statement], scope: &Scope) {
        for statement in statements {
            let span = scope.span(statement.span);
            match &statement.kind {
                StatementKind::Part(_) if scope.is_model() => {}
                StatementKind::Part(_) => self.report(
                    Diagnostic::error(span, "a part is not defined inside another")
                        .help("define it beside this one, in the model: parts may use one another"),
                ),
                StatementKind::Use(used) => {
                    if self.write_out(used, &statement.doc, scope).is_none() {
                        // What it was going to define is not to be complained about.
                        self.unreadable.push(scope.declare(&used.name));
                    }
                }
                StatementKind::Robot { .. } if !scope.is_model() => self.report(
                    Diagnostic::error(
                        span,
                        "a robot description stands in the model, not in a part",
                    )
                    .help("give the part the frames that it needs: `part hand(wrist) { … }`"),
                ),
                StatementKind::Table(_) if !scope.is_model() => self.report(
                    Diagnostic::error(span, "a table stands in the model, not in a part")
                        .help("define it beside the part, which may name it"),
                ),
                StatementKind::Gravity(_) if !scope.is_model() => self.report(
                    Diagnostic::error(span, "gravity is the model's, not a part's")
                        .help("state it once, outside of the part"),
                ),
                _ => self.push(scope.statement(statement), scope),
            }
        }
    }

    fn push(&mut self, statement: Statement, scope: &Scope) {
        self.size += scope.cost(statement.span);
        self.statements.push(statement);
    }

    /// The statements of a part, as its use reads them. `None` if there is an error, which is
    /// reported.
    fn write_out(&mut self, used: &'a UseStatement, doc: &str, outer: &Scope) -> Option<()> {
        let name = outer.declare(&used.name);
        let part = self.part(used, outer)?;
        self.check(used, part, &name, outer)?;
        let reading = self.readings.add(&used.name.text, name.span);
        let mut scope = Scope::of_part(part, &name.text, reading, &self.top);
        for (port, argument) in part.ports.iter().zip(&used.arguments) {
            match path(argument) {
                Some(path) => scope.bind(&port.text, outer.refer(&path)),
                None => {
                    let statement = named(scope.declare(port), outer.expr(argument));
                    self.push(statement, &scope);
                }
            }
        }
        self.uses.push(PartUse {
            name: name.text.clone(),
            part: part.name.text.clone(),
            arguments: self.sources.slice(used.brackets).to_string(),
            doc: doc.to_string(),
        });
        let first = self.statements.len();
        self.path.push(&part.name.text);
        self.all(&part.statements, &scope);
        self.path.pop();
        let lost = part.unreadable.iter().map(|lost| scope.declare(lost));
        self.unreadable.extend(lost);
        self.set_values(first, used, &name.text, outer);
        Some(())
    }

    /// The part that a use names.
    fn part(&mut self, used: &UseStatement, outer: &Scope) -> Option<&'a PartStatement> {
        let name = used.part.text.as_str();
        if let Some((&name, part)) = self.parts.get_key_value(name) {
            self.used.insert(name);
            return Some(part);
        }
        if self.unreadable.iter().any(|lost| lost.text == name) {
            return None;
        }
        let span = outer.span(used.part.span);
        let error = Diagnostic::error(span, format!("there is no part named `{name}`"));
        let known: Vec<&str> = self.parts.keys().copied().collect();
        self.report(match nearest(name, known.iter().copied()) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None if known.is_empty() => error.help(format!("define it: `part {name}(…) {{ … }}`")),
            None => error.help(format!("the parts are: {}", known.join(", "))),
        });
        None
    }

    /// Whether a use can be written out: its name, what is in its brackets, and how far it leads.
    fn check(
        &mut self,
        used: &UseStatement,
        part: &PartStatement,
        name: &Name,
        outer: &Scope,
    ) -> Option<()> {
        let taken = self.uses.iter().any(|known| known.name == name.text);
        let brackets = outer.span(used.brackets);
        let error = if self.path.contains(&part.name.text.as_str()) {
            let message = format!("the part `{}` uses itself", part.name.text);
            let path: Vec<&str> = self
                .path
                .iter()
                .copied()
                .chain([&*part.name.text])
                .collect();
            Diagnostic::error(outer.span(used.part.span), message)
                .help(format!("each uses the next: {}", path.join(", ")))
        } else if self.path.len() == MAX_DEPTH {
            let message = format!("parts use one another more than {MAX_DEPTH} deep");
            Diagnostic::error(name.span, message)
        } else if self.size > syntax::LIMIT.bytes as usize {
            let message = "with its parts written out the model is larger than a model may be";
            Diagnostic::error(name.span, message).help("use the part less often")
        } else if RESERVED.contains(&used.name.text.as_str()) {
            let message = format!("`{}` has a meaning of its own", used.name.text);
            Diagnostic::error(name.span, message)
        } else if taken {
            let message = format!("there are two uses named `{}`", used.name.text);
            Diagnostic::error(name.span, message)
        } else if part.ports.len() != used.arguments.len() {
            let ports: Vec<&str> = part.ports.iter().map(|port| port.text.as_str()).collect();
            let message = format!(
                "`{0}` is used as `{0}({1})`, found {2} in the brackets",
                part.name.text,
                ports.join(", "),
                used.arguments.len()
            );
            Diagnostic::error(brackets, message)
        } else if name.text.len() > syntax::LONGEST_WORD {
            let message = format!("a name has at most {} bytes", syntax::LONGEST_WORD);
            Diagnostic::error(name.span, message)
        } else {
            self.size += outer.cost(name.span.to(brackets));
            return Some(());
        };
        self.report(error);
        None
    }
}

/// A name for what a use gives its part where that has none: `hub * rotate_z(0.3)` is a frame,
/// `2*l` a term.
fn named(name: Name, value: Expr) -> Statement {
    let span = value.span;
    let kind = if is_frame(&value) {
        StatementKind::Frame { name, value }
    } else {
        StatementKind::Let { name, value }
    };
    Statement {
        doc: String::new(),
        span,
        kind,
    }
}

/// Whether an expression is a product of transforms.
fn is_frame(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Call(function, _) => TRANSFORMS.iter().any(|(name, _)| *name == function.text),
        ExprKind::Product(first, rest) => {
            is_frame(first) || rest.iter().any(|(_, factor)| is_frame(factor))
        }
        _ => false,
    }
}

/// A place to point at, for who asks as which use it is read.
fn in_text(span: Span) -> Span {
    Span {
        source: span.source.read_as(0),
        ..span
    }
}
