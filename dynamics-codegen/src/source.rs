//! Source texts and places in them.

use std::ops::Range;

/// Identifies one text among [`Sources`]; while the uses of a part are looked at, also as which
/// use the text is read, so that what is wrong with one use can be told from the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SourceId {
    // As small as a place in the syntax tree should be.
    text: u32,
    /// Zero: as it stands.
    reading: u32,
}

impl SourceId {
    fn of(text: usize) -> Self {
        let text = u32::try_from(text).expect("fewer than 2^32 texts");
        Self { text, reading: 0 }
    }

    /// The same text, read as the use with this number; zero is the text as it stands.
    pub(crate) fn read_as(self, reading: usize) -> Self {
        let reading = u32::try_from(reading).expect("fewer than 2^32 uses");
        Self { reading, ..self }
    }

    /// As which use the text is read.
    pub(crate) fn reading(self) -> usize {
        self.reading as usize
    }
}

/// A place: a byte range in one source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Span {
    /// Which text.
    pub source: SourceId,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// The smallest place that holds both.
    pub fn to(self, other: Self) -> Self {
        Self {
            source: self.source,
            start: self.start.min(other.start),
            end: self.end.max(other.end),
        }
    }
}

/// A named text: a model file, an effect template, a URDF.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// What the user calls it, usually the path as given.
    pub name: String,
    /// The whole text.
    pub text: String,
}

/// All texts that one compilation has read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sources(Vec<Source>);

impl Sources {
    /// No text yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a text.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> SourceId {
        self.0.push(Source {
            name: name.into(),
            text: text.into(),
        });
        SourceId::of(self.0.len() - 1)
    }

    /// All texts, in the order in which they were read.
    pub fn iter(&self) -> impl Iterator<Item = &Source> {
        self.0.iter()
    }

    /// What identifies the texts, in the same order.
    pub fn ids(&self) -> impl Iterator<Item = SourceId> + use<> {
        (0..self.0.len()).map(SourceId::of)
    }

    /// The text behind an identifier.
    pub fn get(&self, id: SourceId) -> &Source {
        &self.0[id.text as usize]
    }

    /// The characters at a place.
    pub fn slice(&self, span: Span) -> &str {
        let text = &self.get(span.source).text;
        text.get(self.clamp(span)).unwrap_or("")
    }

    /// One-based line and column (in characters) of a place.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let before = &self.get(span.source).text[..self.clamp(span).start];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        (line, column)
    }

    /// The range of `span`, cut to the text and to character boundaries.
    pub(crate) fn clamp(&self, span: Span) -> Range<usize> {
        let text = &self.get(span.source).text;
        let floor = |mut at: usize| {
            at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = floor(span.start);
        start..floor(span.end).max(start)
    }
}
