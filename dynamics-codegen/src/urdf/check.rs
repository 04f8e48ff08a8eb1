//! The form of the file: elements, attributes and values against the schema.

use super::records::{is_element, is_own};
use super::schema::{AttributeRule, ElementRule, Occurs, ROBOT};
use crate::diagnostic::Diagnostic;
use crate::robot::Format;
use crate::robot::text::{shown, suggest};
use crate::robot::value::{self, Form};
use crate::robot::xml::{Places, unexpanded};
use crate::source::Span;
use roxmltree::{Document, Node};
use std::collections::BTreeMap;

/// Everything that is wrong with the form.
pub(super) fn check(places: Places, document: &Document, findings: &mut Vec<Diagnostic>) {
    let root = document.root_element();
    let mut pass = Pass {
        places,
        findings,
        ignored: BTreeMap::new(),
    };
    pass.element(root, &ROBOT, "");
    // The schema is a tree of fixed depth, so walking it needs no recursion
    // over the file: an element is looked into only where the schema names it.
    for (part, rule) in children(root, &ROBOT) {
        let owner = owner(part);
        pass.element(part, rule, &owner);
        for (inner, rule) in children(part, rule) {
            pass.element(inner, rule, &owner);
            for (innermost, rule) in children(inner, rule) {
                pass.element(innermost, rule, &owner);
            }
        }
    }
    pass.report_ignored();
}

/// Whether the document is a robot at all; reports the first thing that says it
/// is something else.
pub(super) fn is_urdf(places: Places, document: &Document) -> Result<(), Box<Diagnostic>> {
    check_xacro(places, document)?;
    let root = document.root_element();
    let name = root.tag_name().name();
    if name == "robot" {
        return Ok(());
    }
    let error = Diagnostic::error(
        places.tag(root),
        format!("the outermost element is <{}>, not <robot>", shown(name)),
    );
    let help = match name {
        "mujoco" => "this is MJCF: write `mjcf \"…\";` in place of `urdf \"…\";`",
        "sdf" => "this is SDFormat; convert it to URDF",
        _ => Format::Urdf.shape(),
    };
    Err(Box::new(error.help(help)))
}

/// Refuses text that xacro should have expanded.
fn check_xacro(places: Places, document: &Document) -> Result<(), Box<Diagnostic>> {
    for node in document.descendants().filter(Node::is_element) {
        if places.prefix(node) == Some("xacro") {
            return Err(unexpanded(
                places.tag(node),
                &format!("<xacro:{}>", shown(node.tag_name().name())),
            )
            .into());
        }
        for attribute in node.attributes() {
            let value = attribute.value();
            if let Some(opening) = ["${", "$("].into_iter().find(|o| value.contains(o)) {
                return Err(unexpanded(
                    places.value(&attribute),
                    &format!("`{opening}…{}`", if opening == "${" { "}" } else { ")" }),
                )
                .into());
            }
        }
    }
    Ok(())
}

/// The children of `node` that the schema names, with their rules.
fn children<'a, 'd>(
    node: Node<'a, 'd>,
    rule: &'static ElementRule,
) -> impl Iterator<Item = (Node<'a, 'd>, &'static ElementRule)> + use<'a, 'd> {
    node.children()
        .filter_map(move |child| Some((child, known(child, rule)?.1)))
}

/// What the schema says about a child of an element with this rule.
fn known(child: Node, rule: &'static ElementRule) -> Option<(Occurs, &'static ElementRule)> {
    rule.children
        .iter()
        .find(|(_, rule)| is_element(child, rule.name))
        .copied()
}

/// How messages call a link or a joint.
fn owner(node: Node) -> String {
    let kind = node.tag_name().name();
    match node
        .attribute("name")
        .filter(|name| !name.trim().is_empty())
    {
        Some(name) => format!("{kind} `{}`", shown(name)),
        None => format!("a {kind} without a name"),
    }
}

/// One element or attribute that nothing is known about.
struct Ignored {
    first: Span,
    count: usize,
}

struct Pass<'p, 't> {
    places: Places<'t>,
    findings: &'p mut Vec<Diagnostic>,
    ignored: BTreeMap<String, Ignored>,
}

impl Pass<'_, '_> {
    fn element(&mut self, node: Node, rule: &'static ElementRule, owner: &str) {
        self.attributes(node, rule, owner);
        self.missing_attributes(node, rule, owner);
        self.unknown_children(node, rule, owner);
        self.child_counts(node, rule, owner);
        self.stray_text(node, rule);
    }

    /// How messages call an attribute of an element.
    fn name(rule: &ElementRule, attribute: &str, owner: &str) -> String {
        match owner {
            "" => format!("`{attribute}` of <{}>", rule.name),
            _ if rule.is_part() && attribute == "name" => format!("`name` of a <{}>", rule.name),
            _ if rule.is_part() => format!("`{attribute}` of {owner}"),
            _ => format!("{owner}: `{attribute}` of <{}>", rule.name),
        }
    }

    fn attributes(&mut self, node: Node, rule: &'static ElementRule, owner: &str) {
        for attribute in node.attributes() {
            if attribute.namespace().is_some() {
                continue;
            }
            match rule.attributes.iter().find(|a| a.name == attribute.name()) {
                Some(a) => {
                    let name = Self::name(rule, a.name, owner);
                    let wrong = value::check(self.places, &attribute, a.form, &name, a.meaning);
                    self.findings.extend(wrong);
                }
                None => self.unknown_attribute(node, &attribute, rule, owner),
            }
        }
    }

    fn unknown_attribute(
        &mut self,
        node: Node,
        attribute: &roxmltree::Attribute,
        rule: &'static ElementRule,
        owner: &str,
    ) {
        let range = attribute.range_qname();
        let name = shown(attribute.name());
        match meant_attribute(node, attribute, rule) {
            Some(near) => self.findings.push(
                Diagnostic::error(
                    self.places.span(range),
                    format!("{} is unknown", Self::name(rule, &name, owner)),
                )
                .label(format!("did you mean `{near}`?")),
            ),
            None => self.ignore(
                format!("the attribute `{name}` of <{}>", rule.name),
                self.places.span(range),
            ),
        }
    }

    fn missing_attributes(&mut self, node: Node, rule: &'static ElementRule, owner: &str) {
        // What is there under a wrong name has been reported.
        let misspelt: Vec<&str> = node
            .attributes()
            .filter_map(|attribute| meant_attribute(node, &attribute, rule))
            .collect();
        let missing: Vec<&AttributeRule> = rule
            .attributes
            .iter()
            .filter(|a| a.required && !node.has_attribute(a.name))
            .filter(|a| !misspelt.contains(&a.name))
            .collect();
        let Some(first) = missing.first() else {
            return;
        };
        let names: Vec<String> = missing.iter().map(|a| format!("`{}`", a.name)).collect();
        let element = match owner {
            "" => format!("<{}>", rule.name),
            _ if rule.is_part() => owner.to_string(),
            _ => format!("{owner}: <{}>", rule.name),
        };
        let mut error = Diagnostic::error(
            self.places.tag(node),
            format!("{element} has no {}", names.join(", ")),
        )
        .label(format!("expected {}=\"…\": {}", first.name, first.meaning));
        if rule.name == "inertia" {
            error = error.help("all six are needed; one that is zero is written as \"0\"");
        }
        if let Form::Word(words) = first.form {
            error = error.help(format!("one of {}", words.join(", ")));
        }
        self.findings.push(error);
    }

    fn unknown_children(&mut self, node: Node, rule: &'static ElementRule, owner: &str) {
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if !is_own(child) {
                self.ignore(
                    format!("the element <{}>, from another namespace,", shown(name)),
                    self.places.tag(child),
                );
                continue;
            }
            if known(child, rule).is_some() || rule.ignored.contains(&name) {
                continue;
            }
            self.unknown_child(node, child, rule, owner);
        }
    }

    fn unknown_child(&mut self, node: Node, child: Node, rule: &'static ElementRule, owner: &str) {
        let at = self.places.tag(child);
        let name = shown(child.tag_name().name());
        match meant_element(node, child, rule) {
            Some(near) => {
                let owner = if owner.is_empty() { "<robot>" } else { owner };
                self.findings.push(
                    Diagnostic::error(at, format!("the element <{name}> in {owner} is unknown"))
                        .label(format!("did you mean <{near}>?")),
                );
            }
            None => self.ignore(format!("the element <{name}> in <{}>", rule.name), at),
        }
    }

    fn child_counts(&mut self, node: Node, rule: &'static ElementRule, owner: &str) {
        for (occurs, child_rule) in rule.children {
            if *occurs == Occurs::Often {
                continue;
            }
            let mut found = node.children().filter(|c| is_element(*c, child_rule.name));
            let first = found.next();
            let misspelt = node
                .children()
                .any(|c| meant_element(node, c, rule) == Some(child_rule.name));
            if misspelt {
                continue;
            }
            if first.is_none() && *occurs == Occurs::Once {
                let inside = if rule.is_part() {
                    owner.to_string()
                } else {
                    format!("{owner}: <{}>", rule.name)
                };
                self.findings.push(
                    Diagnostic::error(
                        self.places.tag(node),
                        format!("{inside} has no <{}>", child_rule.name),
                    )
                    .help(example(child_rule)),
                );
            }
            if let (Some(first), Some(second)) = (first, found.next()) {
                self.findings.push(
                    Diagnostic::error(
                        self.places.tag(second),
                        format!("{owner} has more than one <{}>", child_rule.name),
                    )
                    .label("the second")
                    .also(self.places.tag(first), "the first")
                    .help("keep one of the two"),
                );
            }
        }
    }

    fn stray_text(&mut self, node: Node, rule: &ElementRule) {
        let stray = node
            .children()
            .find(|c| c.is_text() && c.text().is_some_and(|t| !t.trim().is_empty()));
        if let Some(text) = stray {
            let range = text.range();
            let slice = &self.places.text[range.clone()];
            let start = range.start + (slice.len() - slice.trim_start().len());
            let word = slice
                .trim_start()
                .lines()
                .next()
                .unwrap_or("")
                .trim_end()
                .len();
            self.ignore(
                format!("text in <{}>", rule.name),
                self.places.span(start..start + word),
            );
        }
    }

    fn ignore(&mut self, what: String, at: Span) {
        let entry = self.ignored.entry(what).or_insert(Ignored {
            first: at,
            count: 0,
        });
        entry.count += 1;
    }

    fn report_ignored(self) {
        for (what, Ignored { first, count }) in self.ignored {
            let times = match count {
                1 => String::new(),
                _ => format!(" ({count} times; the first is shown)"),
            };
            self.findings.push(Diagnostic::warning(
                first,
                format!("{what} has no meaning in URDF and is ignored{times}"),
            ));
        }
    }
}

/// The attribute that an unknown one was probably meant to be, if the element
/// does not have that one already.
fn meant_attribute(
    node: Node,
    unknown: &roxmltree::Attribute,
    rule: &'static ElementRule,
) -> Option<&'static str> {
    let name = unknown.name();
    let mut known = rule.attributes.iter().map(|a| a.name);
    if unknown.namespace().is_some() || known.any(|known| known == name) {
        return None;
    }
    let absent = rule.attributes.iter().map(|a| a.name);
    suggest(name, absent.filter(|name| !node.has_attribute(*name)))
}

/// The element that an unknown child was probably meant to be, if there may be
/// one more of that.
fn meant_element(node: Node, unknown: Node, rule: &'static ElementRule) -> Option<&'static str> {
    let name = unknown.tag_name().name();
    if !unknown.is_element()
        || !is_own(unknown)
        || known(unknown, rule).is_some()
        || rule.ignored.contains(&name)
    {
        return None;
    }
    let has = |name: &str| node.children().any(|c| is_element(c, name));
    let wanted = rule.children.iter();
    let wanted = wanted.filter(|(occurs, rule)| *occurs == Occurs::Often || !has(rule.name));
    suggest(name, wanted.map(|(_, rule)| rule.name))
}

/// How an element is written.
fn example(rule: &ElementRule) -> String {
    if rule.attributes.is_empty() {
        return format!("write <{0}> … </{0}>", rule.name);
    }
    let attributes: Vec<String> = rule
        .attributes
        .iter()
        .filter(|a| a.required)
        .map(|a| format!("{}=\"…\"", a.name))
        .collect();
    format!("write <{} {}/>", rule.name, attributes.join(" "))
}
