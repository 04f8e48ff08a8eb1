//! What makes long functions shorter: numbers that they read often have names, and one declaration
//! holds many constants. A file whose functions all fit into one part has neither: there every line
//! speaks for itself.

use super::language::real;
use super::{Lines, comment};
use crate::emit::body::Body;
use std::collections::BTreeMap;

/// A number that occurs less often is written where it is used.
const OFTEN: usize = 8;
/// As is one that takes no more characters than this.
const SHORT: usize = 6;
/// Longest line of a list of declarations.
const WIDTH: usize = 100;

/// Names of numbers, by their bits: `N1_`, `N2_`, … No local variable has a capital letter, and no
/// macro of a standard header ends in `_`.
#[derive(Debug, Clone, Default)]
pub(super) struct Numbers {
    names: BTreeMap<u64, String>,
}

impl Numbers {
    /// Names for what occurs often in bodies that are written in several parts.
    pub fn of<'a>(long: impl IntoIterator<Item = &'a Body>) -> Self {
        let mut occurrences: BTreeMap<u64, usize> = BTreeMap::new();
        for body in long {
            for value in body.constants_of(0..body.statements.len()) {
                *occurrences.entry(value.to_bits()).or_insert(0) += 1;
            }
        }
        occurrences.retain(|&bits, &mut often| {
            let value = f64::from_bits(bits);
            often >= OFTEN && value.is_finite() && format!("{value:?}").len() > SHORT
        });
        // Those that are read most often have the shortest names.
        let mut often: Vec<(u64, usize)> = occurrences.into_iter().collect();
        often.sort_by_key(|&(bits, often)| (std::cmp::Reverse(often), bits));
        let names = often.into_iter().enumerate();
        Self {
            names: names
                .map(|(index, (bits, _))| (bits, format!("N{}_", index + 1)))
                .collect(),
        }
    }

    /// The name of a number that has one.
    pub fn name(&self, value: f64) -> Option<&str> {
        self.names.get(&value.to_bits()).map(String::as_str)
    }

    /// Their definitions, the ones read most often first.
    pub fn define(&self, w: &mut Lines, prefix: &str) {
        if self.names.is_empty() {
            return;
        }
        comment(w, 0, "Numbers that occur often.");
        let mut names: Vec<(&u64, &String)> = self.names.iter().collect();
        names.sort_by_key(|(_, name)| (name.len(), *name));
        for (&bits, name) in names {
            let value = real(f64::from_bits(bits));
            w.line(&format!("static const {prefix}_real {name} = {value};"));
        }
        w.blank();
    }
}

/// Constants as one declaration, each on a line of its own.
pub(super) fn declare(w: &mut Lines, prefix: &str, constants: &[(&str, String)]) {
    let Some((last, before)) = constants.split_last() else {
        return;
    };
    w.line(&format!("    const {prefix}_real"));
    for (name, value) in before {
        w.line(&format!("        {name} = {value},"));
    }
    w.line(&format!("        {} = {};", last.0, last.1));
}

/// Constants as one declaration, as many on a line as fit: what is only read from somewhere.
pub(super) fn declare_side_by_side(w: &mut Lines, prefix: &str, constants: &[(&str, String)]) {
    let mut line = format!("    const {prefix}_real");
    for (index, (name, value)) in constants.iter().enumerate() {
        let end = if index + 1 < constants.len() {
            ','
        } else {
            ';'
        };
        let constant = format!("{name} = {value}{end}");
        if line.len() + 1 + constant.len() > WIDTH {
            w.line(&line);
            line = " ".repeat(7);
        }
        line.push(' ');
        line.push_str(&constant);
    }
    if !constants.is_empty() {
        w.line(&line);
    }
}
