//! `contact foot: sphere(ankle, r) on plane_z(world) { friction: mu; restitution: 0.5; }`

use super::ast::{ContactStatement, StatementKind};
use super::body::in_braces;
use super::expression::expression;
use super::stream::{Parsed, Stream};
use crate::diagnostic::{Diagnostic, nearest};

/// What `{ … }` of a contact may hold.
const ENTRIES: [&str; 2] = ["friction", "restitution"];

/// A contact, behind its first word. Also: whether it ends in a brace.
pub(super) fn contact(stream: &mut Stream<'_>) -> Parsed<(StatementKind, bool)> {
    let name = stream.name("the contact's name")?;
    stream.expect(':', "the contact's name")?;
    let shape = expression(stream)?;
    if !stream.eat_word("on") {
        return stream.unexpected("`on` and a plane: `on plane_z(world)`");
    }
    let plane = expression(stream)?;
    let (mut friction, mut restitution) = (None, None);
    let braced = in_braces(stream, false, |inner| {
        let key = inner.name("`friction` or `restitution`")?;
        inner.expect(':', "this word")?;
        let entry = match key.text.as_str() {
            "friction" => &mut friction,
            "restitution" => &mut restitution,
            other => {
                let error = Diagnostic::error(key.span, format!("a contact has no `{other}`"));
                return Err(Box::new(match nearest(other, ENTRIES) {
                    Some(near) => error.help(format!("did you mean `{near}`?")),
                    None => error.help(format!("it has: {}", ENTRIES.join(", "))),
                }));
            }
        };
        if entry.replace(expression(inner)?).is_some() {
            let message = format!("`{}` is given twice", key.text);
            return Err(Box::new(Diagnostic::error(key.span, message)));
        }
        Ok(())
    })?;
    let statement = ContactStatement {
        name,
        shape,
        plane,
        friction,
        restitution,
    };
    Ok((StatementKind::Contact(Box::new(statement)), braced))
}
