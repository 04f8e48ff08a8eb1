//! Doc comments.

use crate::emit::plan::{Entry, Quantity};
use crate::emit::text::{markdown_lines, one_line};

/// Lines of a doc comment.
#[derive(Debug, Clone, Default)]
pub(super) struct Doc(Vec<String>);

impl Doc {
    /// One line of ours: Markdown.
    pub fn of(line: impl Into<String>) -> Self {
        Self(vec![line.into()])
    }

    /// Text of a model, or a line of ours if it says nothing.
    pub fn text_or(text: &str, otherwise: &str) -> Self {
        let lines = markdown_lines(text);
        if lines.is_empty() {
            Self::of(otherwise)
        } else {
            Self(lines)
        }
    }

    /// A line of ours behind an empty one, unless it is the first.
    pub fn paragraph(&mut self, line: impl Into<String>) {
        if !self.0.is_empty() {
            self.0.push(String::new());
        }
        self.0.push(line.into());
    }

    /// A line of ours.
    pub fn line(&mut self, line: impl Into<String>) {
        self.0.push(line.into());
    }

    /// Text of a model.
    pub fn text(&mut self, text: &str) {
        self.0.extend(markdown_lines(text));
    }

    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(String::as_str)
    }
}

/// What a quantity is, with its shape and its units.
pub(super) fn of_quantity(quantity: &Quantity) -> Doc {
    let mut doc = Doc::of(format!("{}, {}.", quantity.meaning, quantity.size()));
    for (index, note) in quantity.notes(entry_list).into_iter().enumerate() {
        match index {
            0 => doc.paragraph(note),
            _ => doc.line(note),
        }
    }
    doc
}

/// A name of a model in a line of Markdown.
pub(super) fn code(name: &str) -> String {
    let name = one_line(name);
    if name.contains('`') || name.is_empty() {
        markdown_lines(&name).join(" ")
    } else {
        format!("`{name}`")
    }
}

/// x (m), theta (rad), the names as code.
fn entry_list(entries: &[Entry]) -> String {
    let items = entries.iter().map(|entry| match entry.unit.as_str() {
        "" => code(&entry.name),
        unit => format!("{} ({unit})", code(&entry.name)),
    });
    items.collect::<Vec<_>>().join(", ")
}
