//! Errors and warnings that point at the place and say how to mend it.
//!
//! They are collected, not thrown at the first: a file with three mistakes
//! shows three.

use crate::source::{Source, Sources, Span};
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::borrow::Cow;
use std::fmt::{self, Write};

/// Nobody reads more findings than this at once.
const MAX_SHOWN: usize = 32;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; the result stands.
    Warning,
    /// No result.
    Error,
}

/// A place with a word about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What about it; may be empty.
    pub text: String,
}

/// One finding about a source text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in one line.
    pub message: String,
    /// The place itself.
    pub primary: Label,
    /// Other places that explain it.
    pub secondary: Vec<Label>,
    /// How to mend it.
    pub help: Vec<String>,
}

impl Diagnostic {
    /// An error at a place.
    pub fn error(span: Span, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            message: message.into(),
            primary: Label {
                span,
                text: String::new(),
            },
            secondary: Vec::new(),
            help: Vec::new(),
        }
    }

    /// A warning at a place.
    pub fn warning(span: Span, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            ..Self::error(span, message)
        }
    }

    /// Says something at the underlined place.
    #[must_use]
    pub fn label(mut self, text: impl Into<String>) -> Self {
        self.primary.text = text.into();
        self
    }

    /// Points at a further place.
    #[must_use]
    pub fn also(mut self, span: Span, text: impl Into<String>) -> Self {
        self.secondary.push(Label {
            span,
            text: text.into(),
        });
        self
    }

    /// Says how to mend it.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help.push(text.into());
        self
    }

    /// The finding with the control characters of names in it shown.
    fn visible(&self) -> Self {
        let label = |label: &Label| Label {
            span: label.span,
            text: visible(&label.text).into_owned(),
        };
        Self {
            severity: self.severity,
            message: visible(&self.message).into_owned(),
            primary: label(&self.primary),
            secondary: self.secondary.iter().map(label).collect(),
            help: self
                .help
                .iter()
                .map(|help| visible(help).into_owned())
                .collect(),
        }
    }
}

/// All that was found about some sources, with the texts needed to show it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// The texts.
    pub sources: Sources,
    /// The findings, in the order in which they were made.
    pub diagnostics: Vec<Diagnostic>,
}

impl Report {
    /// Whether there is an error among the findings.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|d| d.severity == Severity::Error)
    }

    /// The findings as text, as a compiler would print them, without colours.
    pub fn render(&self) -> String {
        self.render_with(&Renderer::plain())
    }

    /// The findings as text with terminal colours.
    pub fn render_styled(&self) -> String {
        self.render_with(&Renderer::styled())
    }

    fn render_with(&self, renderer: &Renderer) -> String {
        let mut ordered: Vec<&Diagnostic> = self.diagnostics.iter().collect();
        ordered.sort_by_key(|d| (d.primary.span.source, d.primary.span.start));
        let mut pieces: Vec<String> = ordered
            .iter()
            .take(MAX_SHOWN)
            .map(|d| self.render_one(renderer, &d.visible()))
            .collect();
        if ordered.len() > MAX_SHOWN {
            pieces.push(format!("… and {} more", ordered.len() - MAX_SHOWN));
        }
        pieces.join("\n\n")
    }

    fn render_one(&self, renderer: &Renderer, diagnostic: &Diagnostic) -> String {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = level
            .primary_title(diagnostic.message.as_str())
            .element(self.snippet(
                &diagnostic.primary,
                &diagnostic.secondary,
                AnnotationKind::Primary,
            ));
        for label in &diagnostic.secondary {
            if label.span.source != diagnostic.primary.span.source {
                group = group.element(self.snippet(label, &[], AnnotationKind::Context));
            }
        }
        let mut groups = vec![group];
        for help in &diagnostic.help {
            groups.push(Group::with_title(
                Level::HELP.secondary_title(help.as_str()),
            ));
        }
        renderer.render(&groups)
    }

    /// The text around a label, with those of `others` that stand in the same source.
    fn snippet<'a>(
        &'a self,
        label: &'a Label,
        others: &'a [Label],
        kind: AnnotationKind,
    ) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
        let Source { name, text } = self.sources.get(label.span.source);
        let annotation = |label: &'a Label, kind: AnnotationKind| {
            let annotation = kind.span(self.sources.clamp(label.span));
            if label.text.is_empty() {
                annotation
            } else {
                annotation.label(label.text.as_str())
            }
        };
        Snippet::source(visible_source(text))
            .path(visible(name))
            .annotation(annotation(label, kind))
            .annotations(
                others
                    .iter()
                    .filter(|other| other.span.source == label.span.source)
                    .map(|other| annotation(other, AnnotationKind::Context)),
            )
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render())
    }
}

impl std::error::Error for Report {}

/// A text with its control characters shown instead of obeyed: a terminal that prints a name
/// out of a file is not to be steered by it. Ends of lines and tabs stay; everything else is
/// written as in JSON (`\\u001b`), so that JSON keeps its meaning.
///
/// ```
/// use dynamics_codegen::diagnostic::visible;
///
/// assert_eq!(visible("arm\u{1b}[2J"), "arm\\u001b[2J");
/// ```
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_hidden) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let ends_line = c == '\r' && rest.peek() == Some(&'\n');
        if ends_line || !is_hidden(c) {
            shown.push(c);
        } else {
            // Writing to a string cannot fail; all of them have four digits.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        }
    }
    shown.into()
}

/// A text that places point into, with what its renderer sends to the terminal as it is (the
/// control characters of Latin-1) replaced by a sign of the same length.
pub fn visible_source(text: &str) -> Cow<'_, str> {
    let is_sent = |c: char| ('\u{80}'..='\u{9f}').contains(&c);
    match text.contains(is_sent) {
        true => text.replace(is_sent, "¤").into(),
        false => text.into(),
    }
}

/// Whether a terminal may act on a character, or show the others in another order.
fn is_hidden(c: char) -> bool {
    let reorders = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    (c.is_control() && c != '\n' && c != '\t') || reorders
}

/// The entry of `known` that is most like `name`, if one is near enough to be
/// a slip of the pen.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = name.chars().count();
    // Of a one-letter name, no letter would be left.
    let limit = length.div_ceil(3).min(length.saturating_sub(1));
    known
        .into_iter()
        .map(|candidate| (edit_distance(name, candidate), candidate))
        .filter(|&(distance, _)| distance <= limit)
        .min()
        .map(|(_, candidate)| candidate)
}

/// How many letters to insert, delete, replace or swap with their neighbour (optimal
/// string alignment), by rows.
fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=b.len()).collect();
    for i in 0..a.len() {
        let mut row = vec![i + 1];
        for j in 0..b.len() {
            let replaced = above[j] + usize::from(a[i] != b[j]);
            let mut least = replaced.min(above[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j] {
                least = least.min(before[j - 1] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut above, row);
    }
    above[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_is_a_slip_away() {
        assert_eq!(nearest("theat", ["theta", "x"]), Some("theta"));
        assert_eq!(nearest("omega", ["theta", "x"]), None);
        assert_eq!(nearest("y", ["x"]), None);
        assert_eq!(nearest("sni", ["cos", "sin"]), Some("sin"));
    }
}
