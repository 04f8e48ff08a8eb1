//! The text as an XML tree whose nodes know their places, within bounds.
//!
//! Nothing here or in the passes that follow recurses over the tree.

use super::format::Format;
use super::text::shown;
use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, Span};
use roxmltree::{Attribute, Document, Error, Node, ParsingOptions, TextPos};
use std::ops::Range;

/// The largest file that is read, in bytes.
pub(crate) const MAX_BYTES: usize = 16 << 20;
/// The largest number of XML nodes.
const MAX_NODES: u32 = 1_000_000;
/// The most quotation marks between two `<`: the parser's time grows with the
/// square of the number of attributes of one element.
const MAX_QUOTES: usize = 2000;

/// Turns places in the tree into places in the sources.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Places<'t> {
    pub source: SourceId,
    pub text: &'t str,
}

impl Places<'_> {
    /// A byte range.
    pub fn span(&self, range: Range<usize>) -> Span {
        Span {
            source: self.source,
            start: range.start,
            end: range.end,
        }
    }

    /// The first line of an element's opening tag.
    pub fn tag(&self, node: Node) -> Span {
        let start = node.range().start;
        let after = node
            .attributes()
            .map(|a| a.range().end)
            .max()
            .unwrap_or(start);
        let end = self.text[after..]
            .find('>')
            .map_or(node.range().end, |at| after + at + 1);
        let line = self.text[start..end].find('\n').unwrap_or(end - start);
        let shown = self.text[start..start + line].trim_end().len();
        self.span(start..start + shown)
    }

    /// The value of an attribute, without its quotation marks; the whole
    /// attribute if the value is empty.
    pub fn value(&self, attribute: &Attribute) -> Span {
        let range = attribute.range_value();
        if range.is_empty() {
            return self.span(attribute.range());
        }
        self.span(range)
    }

    /// The value of an attribute if it is there, the opening tag otherwise.
    pub fn value_or_tag(&self, node: Node, attribute: &str) -> Span {
        match node.attribute_node(attribute) {
            Some(attribute) => self.value(&attribute),
            None => self.tag(node),
        }
    }

    /// The prefix with which an element's name is written, if any.
    pub fn prefix(&self, node: Node) -> Option<&str> {
        let name = &self.text[node.range().start + 1..node.range().end];
        let length = name.find(|c: char| c.is_whitespace() || "/>".contains(c))?;
        name[..length].split_once(':').map(|(prefix, _)| prefix)
    }

    /// A byte position out of a row and a column (in characters, from 1).
    fn position(&self, at: TextPos) -> Span {
        let mut start = 0;
        for _ in 1..at.row {
            start += self.text[start..].find('\n').map_or(0, |n| n + 1);
        }
        let line = &self.text[start..];
        let skip = (at.col as usize).saturating_sub(1);
        let column = line.char_indices().nth(skip).map_or(line.len(), |(i, _)| i);
        let start = start + column;
        if start >= self.text.len() {
            return self.end();
        }
        let rest = &self.text[start..];
        let word = rest.find(char::is_whitespace).unwrap_or(rest.len());
        self.span(start..start + word.clamp(1, 40).min(rest.len()))
    }

    /// The end of the text.
    fn end(&self) -> Span {
        let end = self.text.trim_end().len();
        let last = self.text[..end]
            .chars()
            .next_back()
            .map_or(0, char::len_utf8);
        self.span(end - last..end)
    }

    /// The beginning of the text.
    fn beginning(&self) -> Span {
        self.span(0..self.text.find('\n').unwrap_or(self.text.len()).min(40))
    }
}

/// Parses the text.
pub(crate) fn parse<'t>(
    places: Places<'t>,
    format: Format,
) -> Result<Document<'t>, Box<Diagnostic>> {
    if places.text.len() > MAX_BYTES {
        let mib = places.text.len() >> 20;
        return Err(Diagnostic::error(
            places.beginning(),
            format!(
                "the file is too large: {mib} MiB, at most {} MiB are read",
                MAX_BYTES >> 20
            ),
        )
        .help(format!(
            "{} holds numbers and names; keep meshes in files of their own",
            format.one()
        ))
        .into());
    }
    check_attribute_count(places)?;
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(places.text, options)
        .map_err(|error| Box::new(explain(places, format, &error)))?;
    check_depth(places, format, &document)?;
    Ok(document)
}

/// Refuses elements with a flood of attributes before the parser meets them.
fn check_attribute_count(places: Places) -> Result<(), Box<Diagnostic>> {
    let mut quotes = 0;
    let mut open = 0;
    for (at, byte) in places.text.bytes().enumerate() {
        match byte {
            b'<' => (quotes, open) = (0, at),
            b'"' | b'\'' => quotes += 1,
            _ => {}
        }
        if quotes > MAX_QUOTES {
            return Err(Diagnostic::error(
                places.span(open..open + 1),
                format!("more than {} attributes in one element", MAX_QUOTES / 2),
            )
            .into());
        }
    }
    Ok(())
}

/// Refuses trees deeper than any description.
fn check_depth(places: Places, format: Format, document: &Document) -> Result<(), Box<Diagnostic>> {
    let mut depth: Vec<u32> = Vec::new();
    for node in document.descendants() {
        // Document order: a node's parent has been seen, and identifiers count up from 0.
        let own = node
            .parent()
            .map_or(0, |parent| depth[parent.id().get_usize()] + 1);
        debug_assert_eq!(depth.len(), node.id().get_usize());
        depth.push(own);
        if own > format.depth() {
            return Err(Diagnostic::error(
                places.tag(node),
                format!("elements are nested more than {} deep", format.depth()),
            )
            .help(format.nesting())
            .into());
        }
    }
    Ok(())
}

/// A parser's error in our words and at its place.
fn explain(places: Places, format: Format, error: &Error) -> Diagnostic {
    let at = places.position(error.pos());
    match error {
        Error::DtdDetected => {
            let start = places.text.find("<!DOCTYPE").unwrap_or(0);
            Diagnostic::error(
                places.span(start..(start + 9).min(places.text.len())),
                "a document type declaration is refused",
            )
            .label("entities declared here could expand without bound")
            .help(format!(
                "{} needs none: delete the <!DOCTYPE …> declaration and write the values out",
                format.one()
            ))
        }
        Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
            unexpanded(at, "a `xacro:` element")
        }
        Error::UnknownNamespace(prefix, _) => Diagnostic::error(
            at,
            format!("the prefix `{}:` is not declared", shown(prefix)),
        )
        .help(format!(
            "declare it in <{1} xmlns:{0}=\"…\">, or write the name without a prefix",
            shown(prefix),
            format.root()
        )),
        Error::UnexpectedCloseTag(expected, actual, _) => Diagnostic::error(
            at,
            format!(
                "</{}> closes <{}>, which is still open",
                shown(actual),
                shown(expected)
            ),
        )
        .help(format!(
            "close it with </{0}> first, or open it as <{0} …/>",
            shown(expected)
        )),
        Error::UnknownEntityReference(name, _) => {
            Diagnostic::error(at, format!("the entity `&{};` is not known", shown(name)))
                .help("XML knows &amp; &lt; &gt; &quot; &apos;")
        }
        Error::DuplicatedAttribute(name, _) => Diagnostic::error(
            at,
            format!("the attribute `{}` is stated twice", shown(name)),
        )
        .help("delete one of the two"),
        Error::NodesLimitReached => Diagnostic::error(
            places.beginning(),
            format!("the file has more than {MAX_NODES} XML nodes"),
        ),
        Error::NoRootNode => {
            Diagnostic::error(places.beginning(), "the file contains no XML element")
                .help(format.shape())
        }
        Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
            Diagnostic::error(places.end(), "the file ends in the middle of an element")
                .label("the rest is missing")
                .help(format!(
                    "close every element; the last line is </{}>",
                    format.root()
                ))
        }
        other => Diagnostic::error(at, format!("this is not XML: {}", without_place(other))),
    }
}

/// The message for text that xacro should have replaced.
pub(crate) fn unexpanded(at: Span, what: &str) -> Diagnostic {
    Diagnostic::error(
        at,
        format!("{what} is left in the text: this is xacro, not URDF"),
    )
    .help("expand it first: xacro robot.urdf.xacro > robot.urdf")
}

/// The parser's own words, without its own line and column.
fn without_place(error: &Error) -> String {
    let text = error.to_string();
    let place = format!(" at {}", error.pos());
    shown(&text.replace(&place, ""))
}
