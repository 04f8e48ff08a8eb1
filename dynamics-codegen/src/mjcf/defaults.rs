//! `<default>`: attributes that elements have unless they state their own.

use super::document::{Element, Given};
use crate::diagnostic::Diagnostic;
use crate::robot::text::{shown, suggest};
use crate::source::Span;
use std::collections::BTreeMap;

/// How deep classes may be nested: looking an attribute up takes as many steps.
const MAX_DEPTH: usize = 50;

/// Elements that have the same defaults. Those of all actuators are one: `<motor>` and
/// `<position>` are two ways to write `<general>`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Joint,
    Geom,
    Actuator,
    /// Of anything else: none.
    None,
}

impl Kind {
    pub fn of(element: &str) -> Self {
        match element {
            "joint" => Self::Joint,
            "geom" => Self::Geom,
            name if super::schema::ACTUATORS.contains(&name) => Self::Actuator,
            _ => Self::None,
        }
    }
}

/// A class, by its index among [`Classes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ClassId(usize);

struct Class<'a, 't> {
    parent: Option<usize>,
    own: BTreeMap<(Kind, &'a str), Given<'a, 't>>,
}

/// All classes. A class has what its parent had when it was read, as in MuJoCo: what a later
/// section adds to the outermost class is not that of classes before.
pub(super) struct Classes<'a, 't> {
    all: Vec<Class<'a, 't>>,
    names: BTreeMap<&'a str, (usize, Span)>,
    /// The outermost class as it is after all sections.
    main: usize,
}

impl<'a, 't> Classes<'a, 't> {
    /// Reads the `<default>` sections of `root`.
    pub fn read(root: Element<'a, 't>, findings: &mut Vec<Diagnostic>) -> Self {
        let mut classes = Self {
            all: vec![Class {
                parent: None,
                own: BTreeMap::new(),
            }],
            names: BTreeMap::new(),
            main: 0,
        };
        let sections = root.children().into_iter();
        for section in sections.filter(|child| child.name() == "default") {
            classes.section(section, findings);
        }
        classes
    }

    fn section(&mut self, section: Element<'a, 't>, findings: &mut Vec<Diagnostic>) {
        let main = self.add(Some(self.main), section);
        self.main = main;
        if let Some(name) = section.given("class") {
            self.names.insert(name.value(), (main, name.span()));
        }
        let mut waiting: Vec<(Element, usize, usize)> = inner(section, main, 1);
        while let Some((element, parent, depth)) = waiting.pop() {
            if depth > MAX_DEPTH {
                let message = format!("classes are nested more than {MAX_DEPTH} deep");
                findings.push(Diagnostic::error(element.tag(), message));
                continue;
            }
            let own = self.add(Some(parent), element);
            self.name(element, own, findings);
            waiting.extend(inner(element, own, depth + 1));
        }
    }

    fn add(&mut self, parent: Option<usize>, element: Element<'a, 't>) -> usize {
        let mut own = BTreeMap::new();
        for child in element.children() {
            let kind = Kind::of(child.name());
            if kind != Kind::None {
                let stated = child.attributes();
                own.extend(stated.map(|given| ((kind, given.attribute.name()), given)));
            }
        }
        self.all.push(Class { parent, own });
        self.all.len() - 1
    }

    fn name(&mut self, element: Element<'a, 't>, own: usize, findings: &mut Vec<Diagnostic>) {
        let Some(name) = element.given("class") else {
            findings.push(
                Diagnostic::error(element.tag(), "a <default> inside another has no `class`")
                    .help("name it, `<default class=\"leg\">`, so that elements can say that they are of it"),
            );
            return;
        };
        if let Some((_, first)) = self.names.insert(name.value(), (own, name.span())) {
            let message = format!("two classes are called `{}`", shown(name.value()));
            let error = Diagnostic::error(name.span(), message).label("the second");
            findings.push(error.also(first, "the first").help("rename one of them"));
        }
    }

    /// The class that an element names in `attribute`, or `inherited`.
    pub fn of(
        &self,
        element: Element<'a, 't>,
        attribute: &str,
        inherited: ClassId,
        findings: &mut Vec<Diagnostic>,
    ) -> ClassId {
        let Some(given) = element.given(attribute) else {
            return inherited;
        };
        let name = given.value();
        if let Some(&(class, _)) = self.names.get(name) {
            return ClassId(class);
        }
        if name == "main" {
            return self.main();
        }
        let message = format!("no class of defaults is called `{}`", shown(name));
        let error = Diagnostic::error(given.span(), message);
        findings.push(match suggest(name, self.names.keys().copied()) {
            Some(near) => error.help(format!("did you mean `{}`?", shown(near))),
            None => error.help(format!(
                "write it in <default>: `<default class=\"{}\"> … </default>`",
                shown(name)
            )),
        });
        inherited
    }

    /// The class of what names none.
    pub fn main(&self) -> ClassId {
        ClassId(self.main)
    }

    /// An attribute of elements of a class.
    pub fn given(&self, class: ClassId, kind: Kind, name: &str) -> Option<Given<'a, 't>> {
        let mut at = Some(class.0);
        while let Some(class) = at.map(|index| &self.all[index]) {
            if let Some(given) = class.own.get(&(kind, name)) {
                return Some(*given);
            }
            at = class.parent;
        }
        None
    }
}

/// The classes in an element, the first last: with the class and the depth that they are in.
fn inner<'a, 't>(
    element: Element<'a, 't>,
    parent: usize,
    depth: usize,
) -> Vec<(Element<'a, 't>, usize, usize)> {
    let all = element.children().into_iter().rev();
    let classes = all.filter(|child| child.name() == "default");
    classes.map(|child| (child, parent, depth)).collect()
}
