//! `contact foot: sphere(ankle, r) on plane_z(world) { friction: mu; restitution: 0.5; }`

use super::ast::{ContactStatement, StatementKind};
use super::body::settings;
use super::expression::expression;
use super::stream::{Parsed, Stream};

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
    let words = "`friction` or `restitution`";
    let ([friction, restitution], braced) = settings(stream, "contact", words, ENTRIES)?;
    let statement = ContactStatement {
        name,
        shape,
        plane,
        friction,
        restitution,
    };
    Ok((StatementKind::Contact(Box::new(statement)), braced))
}
