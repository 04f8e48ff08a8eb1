//! `part arm(base, angle) { … }` and `use left = arm(hub, 0.3) { m = 0.5 }`

use super::ast::{PartStatement, StatementKind, UseStatement};
use super::expression::expression;
use super::statement::{in_brackets, statements, values};
use super::stream::{Parsed, Stream};
use crate::diagnostic::Diagnostic;

/// A part, behind its first word. Faults of its statements are added to `found`.
pub(super) fn part(stream: &mut Stream<'_>, found: &mut Vec<Diagnostic>) -> Parsed<StatementKind> {
    let name = stream.name("the part's name")?;
    let mut ports = Vec::new();
    in_brackets(stream, |inner| {
        ports.push(inner.name("the name of what differs from use to use")?);
        Ok(())
    })?;
    if !stream.input.peek(syn::token::Brace) {
        return stream.unexpected("`{` and the statements of the part");
    }
    let (content, brace) = stream.braces()?;
    let (statements, unreadable) = statements(&mut stream.inside(&content), found);
    stream.passed(brace.span.close());
    Ok(StatementKind::Part(Box::new(PartStatement {
        name,
        ports,
        statements,
        unreadable,
    })))
}

/// The use of a part, behind its first word. Also: whether it ends in a brace.
pub(super) fn used(stream: &mut Stream<'_>) -> Parsed<(StatementKind, bool)> {
    let name = stream.name("a name for the use: `use left = arm(…);`")?;
    if stream.input.peek(syn::token::Paren) {
        let error = Diagnostic::error(name.span, "the use of a part has a name of its own")
            .help(format!("put one in front: `use left = {}(…);`", name.text));
        return Err(Box::new(error));
    }
    stream.expect('=', "the name")?;
    let part = stream.name("the name of a part")?;
    let start = stream.here();
    let mut arguments = Vec::new();
    in_brackets(stream, |inner| {
        arguments.push(expression(inner)?);
        Ok(())
    })?;
    let brackets = start.to(stream.previous());
    let (values, braced) = values(stream, "a parameter of the part")?;
    let used = UseStatement {
        name,
        part,
        arguments,
        brackets,
        values,
    };
    Ok((StatementKind::Use(Box::new(used)), braced))
}
