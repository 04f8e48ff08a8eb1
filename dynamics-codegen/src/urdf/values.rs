//! The numbers, as urdf-rs reads them.
//!
//! urdf-rs sees a text of our making that holds what bears on motion and has
//! passed every check: no names (it would have to unescape them), no visuals
//! (a missing mesh size is no concern here), no comments, no nesting beyond the
//! schema's. Its links and joints stand in the order of the file, so an index
//! is all that connects them with their places.

use super::records::{child, is_element};
use super::schema::{ElementRule, ROBOT};
use crate::robot::value::{Form, parse_version};
use roxmltree::{Document, Node};
use std::fmt::Write;

/// Reads the values of a document that has passed [`check`](super::check::check).
///
/// # Errors
/// The words of urdf-rs, should it object to what the checks let pass.
pub(super) fn read(document: &Document) -> Result<urdf_rs::Robot, String> {
    let mut text = String::new();
    write_robot(document.root_element(), &mut text);
    urdf_rs::read_from_string(&text).map_err(|error| error.to_string())
}

fn write_robot(robot: Node, out: &mut String) {
    open(robot, &ROBOT, out);
    for (part, part_rule) in known_children(robot, &ROBOT) {
        open(part, part_rule, out);
        for (inner, inner_rule) in known_children(part, part_rule) {
            open(inner, inner_rule, out);
            for (innermost, innermost_rule) in known_children(inner, inner_rule) {
                open(innermost, innermost_rule, out);
                close(innermost_rule, out);
            }
            close(inner_rule, out);
        }
        close(part_rule, out);
    }
    close(&ROBOT, out);
}

fn known_children<'a, 'd>(
    node: Node<'a, 'd>,
    rule: &'static ElementRule,
) -> impl Iterator<Item = (Node<'a, 'd>, &'static ElementRule)> {
    node.children().filter_map(|child| {
        let found = rule
            .children
            .iter()
            .find(|(_, r)| is_element(child, r.name));
        found.map(|(_, rule)| (child, *rule))
    })
}

fn open(node: Node, rule: &ElementRule, out: &mut String) {
    let _ = write!(out, "<{}", rule.name);
    for attribute in rule.attributes {
        let Some(value) = node.attribute(attribute.name) else {
            continue;
        };
        let words: Vec<&str> = value.split_whitespace().collect();
        match attribute.form {
            Form::Name => {
                let _ = write!(out, " {}=\"_\"", attribute.name);
            }
            // Read by ourselves: urdf-rs turns quaternions near a pitch of
            // ±π/2 into rounded angles. The version only changes the defaults
            // of limits, which are stated below.
            Form::Text | Form::Version | Form::Vector(4) => {}
            Form::Word(_) | Form::Number(_) | Form::Vector(_) | Form::Between(..) => {
                let _ = write!(out, " {}=\"{}\"", attribute.name, words.join(" "));
            }
        }
    }
    if rule.name == "limit" {
        write_limit_defaults(node, out);
    }
    out.push('>');
}

/// What an unstated limit means: unlimited, save for the range before version 1.2.
fn write_limit_defaults(limit: Node, out: &mut String) {
    let range = if version(limit.document()) >= (1, 2) {
        [("lower", "-inf"), ("upper", "inf")]
    } else {
        [("lower", "0"), ("upper", "0")]
    };
    for (name, value) in range
        .into_iter()
        .chain([("effort", "inf"), ("velocity", "inf")])
    {
        if !limit.has_attribute(name) {
            let _ = write!(out, " {name}=\"{value}\"");
        }
    }
}

/// The version of the format, 1.0 if the file states none.
pub(super) fn version(document: &Document) -> (u32, u32) {
    let stated = document.root_element().attribute("version");
    stated.and_then(parse_version).unwrap_or((1, 0))
}

fn close(rule: &ElementRule, out: &mut String) {
    let _ = write!(out, "</{}>", rule.name);
}

/// The quaternion `(x, y, z, w)` of an element's `<origin>`, if it has one.
pub(super) fn quaternion(element: Node) -> Option<[f64; 4]> {
    let text = child(element, "origin")?.attribute("quat_xyzw")?;
    let numbers: Vec<f64> = text
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    numbers.try_into().ok()
}
