//! `table drag(speed: m/s): N { 0: 0; 1: 0.3; 2: 1.4; }` and `table drag(speed: m/s): N = "drag.csv";`

use super::ast::{StatementKind, TableContent, TableStatement};
use super::body::in_braces;
use super::expression::{expression, unit};
use super::statement::in_brackets;
use super::stream::{Parsed, Stream};

/// A table, behind its first word. Also: whether it ends in a brace.
pub(super) fn table(stream: &mut Stream<'_>) -> Parsed<(StatementKind, bool)> {
    let name = stream.name("the table's name")?;
    let mut arguments = Vec::new();
    in_brackets(stream, |inner| {
        let argument = inner.name("what the table is a function of")?;
        arguments.push((argument, inner.eat(':').then(|| unit(inner)).transpose()?));
        Ok(())
    })?;
    let unit = stream.eat(':').then(|| unit(stream)).transpose()?;
    let (content, braced) = if stream.eat('=') {
        let file = stream.text("the path of a table in quotes: `= \"drag.csv\"`")?;
        (TableContent::File(file), false)
    } else {
        let mut rows = Vec::new();
        if !stream.input.peek(syn::token::Brace) {
            return stream.unexpected("numbers in braces, or `=` and the path of a file");
        }
        in_braces(stream, true, |inner| {
            let first = expression(inner)?;
            inner.expect(':', "this number")?;
            let mut values = vec![expression(inner)?];
            while inner.eat(',') {
                values.push(expression(inner)?);
            }
            rows.push((first, values));
            Ok(())
        })?;
        (TableContent::Rows(rows), true)
    };
    let table = TableStatement {
        name,
        arguments,
        unit,
        content,
    };
    Ok((StatementKind::Table(Box::new(table)), braced))
}
