//! The files of a description as one tree of elements that know their places.

use crate::diagnostic::Diagnostic;
use crate::robot::Format;
use crate::robot::text::shown;
use crate::robot::xml::{self, Places};
use crate::source::{SourceId, Sources, Span};
use roxmltree::{Attribute, Document, Node};
use std::collections::BTreeMap;
use std::io;

/// Reads a file by its path from the description's folder: what messages call it, and its text.
pub type Beside<'a> = dyn Fn(&str) -> io::Result<(String, String)> + 'a;

/// The element that another file stands in for.
const INCLUDE: &str = "include";

/// How many files one may include, themselves including others.
const MAX_INCLUDED: usize = 100;

/// A file that another includes.
#[derive(Debug, Clone)]
pub(super) struct Included {
    /// The path as written.
    pub path: String,
    pub source: SourceId,
    /// Which file includes it, and where its `<include>` begins there.
    by: (SourceId, usize),
}

/// Reads what a file includes, and what that includes, into `sources`. A file that is no XML
/// includes nothing: [`Files::parse`] says what is wrong with it.
pub(super) fn load(
    sources: &mut Sources,
    main: SourceId,
    beside: &Beside<'_>,
    findings: &mut Vec<Diagnostic>,
) -> Vec<Included> {
    let mut included: Vec<Included> = Vec::new();
    let mut next = 0;
    let mut source = main;
    loop {
        for (path, at, start) in includes(sources, source, findings) {
            match include(sources, &path, &included, beside) {
                Ok(found) => included.push(Included {
                    source: found,
                    by: (source, start),
                    path,
                }),
                Err((message, help)) => {
                    findings.push(Diagnostic::error(at, message).help(help));
                }
            }
        }
        match included.get(next) {
            Some(file) => source = file.source,
            None => return included,
        }
        next += 1;
    }
}

/// The `<include file="…"/>` of a file: the path, its place, and where the element begins.
fn includes(
    sources: &Sources,
    source: SourceId,
    findings: &mut Vec<Diagnostic>,
) -> Vec<(String, Span, usize)> {
    let text = &sources.get(source).text;
    let places = Places { source, text };
    let Ok(document) = xml::parse(places, Format::Mjcf) else {
        return Vec::new();
    };
    let all = document.descendants();
    let all = all.filter(|node| node.tag_name().name() == INCLUDE);
    let mut found = Vec::new();
    for node in all {
        let at = places.value_or_tag(node, "file");
        match node.attribute("file") {
            Some(path) => found.push((path.to_string(), at, node.range().start)),
            None => findings.push(
                Diagnostic::error(at, "<include> has no `file`")
                    .label("expected file=\"…\": the path of an MJCF"),
            ),
        }
    }
    found
}

/// Reads a file that is included, or says why not and how to mend it.
fn include(
    sources: &mut Sources,
    path: &str,
    included: &[Included],
    beside: &Beside<'_>,
) -> Result<SourceId, (String, &'static str)> {
    let name = shown(path);
    if included.iter().any(|file| file.path == path) {
        let message = format!("`{name}` is included twice");
        return Err((message, "MuJoCo includes a file once: take a copy of it"));
    }
    if included.len() == MAX_INCLUDED {
        let message = format!("more than {MAX_INCLUDED} files are included");
        return Err((message, "put what they hold into fewer files"));
    }
    let read = beside(path).map_err(|reason| {
        let message = format!("cannot read `{name}`: {reason}");
        (
            message,
            "the path starts from the folder of the file that is read first",
        )
    });
    let (shown, text) = read?;
    Ok(sources.add(shown, text))
}

/// All files, parsed.
pub(super) struct Files<'t> {
    documents: Vec<(Places<'t>, Document<'t>)>,
    /// Which file stands in for an `<include>`: by the file that it stands in and its place.
    included: BTreeMap<(usize, usize), usize>,
}

impl<'t> Files<'t> {
    /// Parses a file and those that it includes.
    ///
    /// # Errors
    /// What is wrong with the first that is no XML.
    pub fn parse(
        sources: &'t Sources,
        main: SourceId,
        included: &[Included],
    ) -> Result<Self, Box<Diagnostic>> {
        let ids: Vec<SourceId> = std::iter::once(main)
            .chain(included.iter().map(|file| file.source))
            .collect();
        let mut documents = Vec::with_capacity(ids.len());
        for &source in &ids {
            let text = &sources.get(source).text;
            let places = Places { source, text };
            documents.push((places, xml::parse(places, Format::Mjcf)?));
        }
        let index = |source: SourceId| ids.iter().position(|&id| id == source).unwrap_or(0);
        let entry = |(number, file): (usize, &Included)| {
            let (source, start) = file.by;
            ((index(source), start), number + 1)
        };
        Ok(Self {
            documents,
            included: included.iter().enumerate().map(entry).collect(),
        })
    }

    /// The outermost element of the file that is read first.
    pub fn root(&self) -> Element<'_, 't> {
        self.root_of(0)
    }

    fn root_of(&self, file: usize) -> Element<'_, 't> {
        Element {
            files: self,
            file,
            node: self.documents[file].1.root_element(),
        }
    }
}

/// An element.
#[derive(Clone, Copy)]
pub(super) struct Element<'a, 't> {
    files: &'a Files<'t>,
    file: usize,
    node: Node<'a, 't>,
}

/// An attribute as written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given<'a, 't> {
    pub places: Places<'t>,
    pub attribute: Attribute<'a, 't>,
}

impl<'a> Given<'a, '_> {
    pub fn value(&self) -> &'a str {
        self.attribute.value()
    }

    pub fn span(&self) -> Span {
        self.places.value(&self.attribute)
    }
}

impl<'a, 't> Element<'a, 't> {
    pub fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }

    fn places(&self) -> Places<'t> {
        self.files.documents[self.file].0
    }

    /// The opening tag.
    pub fn tag(&self) -> Span {
        self.places().tag(self.node)
    }

    pub fn given(&self, name: &str) -> Option<Given<'a, 't>> {
        let attribute = self.node.attribute_node(name)?;
        let places = self.places();
        Some(Given { places, attribute })
    }

    /// All attributes.
    pub fn attributes(&self) -> impl Iterator<Item = Given<'a, 't>> + use<'a, 't> {
        let places = self.places();
        let all = self.node.attributes();
        all.map(move |attribute| Given { places, attribute })
    }

    /// The elements in it, with those of included files in place of `<include>`.
    pub fn children(&self) -> Vec<Self> {
        let mut found = Vec::new();
        let mut waiting = vec![(*self, self.node.first_child())];
        while let Some((element, next)) = waiting.pop() {
            let Some(node) = next else { continue };
            waiting.push((element, node.next_sibling()));
            if !node.is_element() {
                continue;
            }
            let child = Self { node, ..element };
            let place = (child.file, node.range().start);
            if let Some(&file) = self.files.included.get(&place) {
                let root = self.files.root_of(file);
                waiting.push((root, root.node.first_child()));
            } else if child.name() != INCLUDE {
                found.push(child);
            }
        }
        found
    }
}
