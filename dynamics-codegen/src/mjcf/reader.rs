//! Reading elements: their attributes as numbers, with what their class says, and what is wrong.

use super::defaults::{ClassId, Classes, Kind};
use super::document::{Element, Files, Given};
use super::ignored::Ignored;
use super::schema::ElementRule;
use super::settings::Settings;
use crate::diagnostic::Diagnostic;
use crate::robot::text::{shown, suggest};
use crate::robot::value::{self, Form, Range};
use crate::robot::{Options, Snapped, Vector3};
use crate::source::Span;

/// What all of a description is read with.
pub(super) struct Reader<'p, 'a, 't> {
    pub classes: Classes<'a, 't>,
    pub settings: Settings,
    pub findings: &'p mut Vec<Diagnostic>,
    pub ignored: Ignored,
    pub snapped: Snapped,
    /// Whether an inertia that no body can have is a warning.
    pub impossible: bool,
    /// Whether equalities are read.
    pub equalities: bool,
}

impl<'p, 'a, 't> Reader<'p, 'a, 't> {
    /// With the settings and the classes of the file.
    pub fn new(
        files: &'a Files<'t>,
        options: Options<'_>,
        findings: &'p mut Vec<Diagnostic>,
    ) -> Self {
        let classes = Classes::read(files.root(), findings);
        let mut reader = Self {
            classes,
            settings: Settings::default(),
            findings,
            ignored: Ignored::default(),
            snapped: Snapped::within(options.snap.unwrap_or(0.0)),
            impossible: options.impossible,
            equalities: options.equalities,
        };
        reader.read_settings(files.root());
        reader
    }

    /// Says what was ignored.
    pub fn report_ignored(&mut self) {
        self.findings.extend(self.ignored.report());
    }

    /// Something is wrong.
    pub fn report(&mut self, finding: Diagnostic) {
        self.findings.push(finding);
    }

    /// Looks at the names of an element's attributes; `owner` is how messages call it.
    pub fn check_attributes(&mut self, element: Element, rule: &ElementRule, owner: &str) {
        for given in element.attributes() {
            let name = given.attribute.name();
            if given.attribute.namespace().is_some() {
                continue;
            }
            let at = given.places.span(given.attribute.range_qname());
            if rule.ignored.contains(&name) {
                self.ignored
                    .add(format!("`{name}` of <{}>", rule.name), 1, at);
            } else if !rule.known().any(|known| known == name) {
                self.unknown_attribute(name, at, rule, owner);
            }
        }
    }

    fn unknown_attribute(&mut self, name: &str, at: Span, rule: &ElementRule, owner: &str) {
        let name = shown(name);
        match suggest(&name, rule.known()) {
            Some(near) => self.report(
                Diagnostic::error(at, format!("{owner} has no attribute `{name}`"))
                    .label(format!("did you mean `{near}`?")),
            ),
            None => self
                .ignored
                .add(format!("`{name}` of <{}>", rule.name), 1, at),
        }
    }
}

/// An element with the class whose defaults it has.
#[derive(Clone)]
pub(super) struct Part<'a, 't> {
    pub element: Element<'a, 't>,
    pub class: ClassId,
    kind: Kind,
    /// How messages call it.
    pub owner: String,
}

impl<'a, 't> Part<'a, 't> {
    /// An element of a class; `owner` is how messages call it.
    pub fn new(element: Element<'a, 't>, class: ClassId, owner: String) -> Self {
        Self {
            element,
            class,
            kind: Kind::of(element.name()),
            owner,
        }
    }

    /// An attribute: the element's own, or that of its class.
    pub fn given(&self, reader: &Reader<'_, 'a, 't>, name: &str) -> Option<Given<'a, 't>> {
        let own = self.element.given(name);
        own.or_else(|| reader.classes.given(self.class, self.kind, name))
    }

    /// An attribute that has passed the check of its form.
    fn checked(
        &self,
        reader: &mut Reader<'_, 'a, 't>,
        name: &str,
        form: Form,
        meaning: &str,
    ) -> Option<Given<'a, 't>> {
        let given = self.given(reader, name)?;
        let called = format!("`{name}` of {}", self.owner);
        let wrong = value::check(given.places, &given.attribute, form, &called, meaning);
        match wrong {
            Some(error) => {
                reader.report(error);
                None
            }
            None => Some(given),
        }
    }

    /// From so many to so many numbers.
    pub fn numbers(
        &self,
        reader: &mut Reader<'_, 'a, 't>,
        name: &str,
        [least, most]: [usize; 2],
        meaning: &str,
    ) -> Option<Vec<f64>> {
        let given = self.checked(reader, name, Form::Between(least, most), meaning)?;
        let words = given.value().split_whitespace();
        words.map(|word| word.parse().ok()).collect()
    }

    /// Three numbers.
    pub fn vector(
        &self,
        reader: &mut Reader<'_, 'a, 't>,
        name: &str,
        meaning: &str,
    ) -> Option<Vector3> {
        self.numbers(reader, name, [3, 3], meaning)?.try_into().ok()
    }

    /// A number.
    pub fn number(
        &self,
        reader: &mut Reader<'_, 'a, 't>,
        name: &str,
        range: Range,
        meaning: &str,
    ) -> Option<f64> {
        let given = self.checked(reader, name, Form::Number(range), meaning)?;
        given.value().trim().parse().ok()
    }

    /// One of some words.
    pub fn word(
        &self,
        reader: &mut Reader<'_, 'a, 't>,
        name: &str,
        words: &'static [&'static str],
    ) -> Option<&'static str> {
        let given = self.checked(reader, name, Form::Word(words), "")?;
        words.iter().find(|word| **word == given.value()).copied()
    }

    /// A name.
    pub fn name(
        &self,
        reader: &mut Reader<'_, 'a, 't>,
        name: &str,
        meaning: &str,
    ) -> Option<Given<'a, 't>> {
        self.checked(reader, name, Form::Name, meaning)
    }

    /// `true` or `false`.
    pub fn truth(&self, reader: &mut Reader<'_, 'a, 't>, name: &str) -> Option<bool> {
        let word = self.word(reader, name, &["true", "false"])?;
        Some(word == "true")
    }
}
