//! `<equality>`: points of bodies that coincide, and joints that follow from others.

use super::document::Element;
use super::naming::Names;
use super::reader::{Part, Reader};
use super::schema::{CONNECT, COUPLING, EQUALITIES, EQUALITIES_IGNORED};
use super::tree::Drawn;
use crate::diagnostic::Diagnostic;
use crate::robot::text::{shown, suggest};
use crate::robot::{Closure, ClosureKind, JointKind, Robot};

/// Where equalities find what they name.
pub(super) struct Named<'r> {
    /// The bodies and their joints.
    pub robot: &'r Robot,
    /// As the file draws each.
    pub drawn: &'r [Drawn],
}

impl<'a, 't> Reader<'_, 'a, 't> {
    /// The equalities of all sections that are active, between bodies or between joints of one freedom.
    pub fn closures(&mut self, root: Element<'a, 't>, named: &Named<'_>) -> Vec<Closure> {
        let sections = root.children().into_iter();
        let sections = sections.filter(|section| section.name() == "equality");
        if !self.equalities {
            for section in sections {
                let count = section.children().len().max(1);
                let what = "<equality> without `equalities: hold`".to_string();
                self.ignored.add(what, count, section.tag());
            }
            return Vec::new();
        }
        let elements: Vec<Element> = sections.flat_map(|section| section.children()).collect();
        let mut names = Names::new("equalities");
        for element in &elements {
            if let Some(name) = element.given("name") {
                names.state(name.value(), name.span(), self.findings);
            }
        }
        let mut found = Vec::new();
        for element in elements {
            let (kind, at) = (element.name(), element.tag());
            if EQUALITIES_IGNORED.contains(&kind) {
                self.ignored.add(format!("<{kind}> of <equality>"), 1, at);
                continue;
            }
            if !EQUALITIES.contains(&kind) {
                let known = [&EQUALITIES[..], &EQUALITIES_IGNORED[..]].concat();
                self.unknown_element(element, "<equality>", &known);
                continue;
            }
            let class = self.classes.main();
            let class = self.classes.of(element, "class", class, self.findings);
            let owner = match element.given("name") {
                Some(name) => format!("{kind} `{}`", shown(name.value())),
                None => format!("a {kind} of <equality>"),
            };
            let part = Part::new(element, class, owner);
            let rule = if kind == "connect" {
                &CONNECT
            } else {
                &COUPLING
            };
            self.check_attributes(element, rule, &part.owner);
            if part.truth(self, "active") == Some(false) || !self.settings.equality {
                continue;
            }
            let closure = match kind {
                "connect" => self.connected(&part, named),
                _ => self.coupled(&part, named),
            };
            let Some((wish, kind)) = closure else {
                continue;
            };
            let name = match element.given("name") {
                Some(name) => name.value().to_string(),
                None => names.invent(&wish, at),
            };
            found.push(Closure {
                name,
                span: at,
                kind,
            });
        }
        found
    }

    /// A point of one body that is one of another, or of the world, with a name for it.
    fn connected(
        &mut self,
        part: &Part<'a, 't>,
        named: &Named<'_>,
    ) -> Option<(String, ClosureKind)> {
        if part.given(self, "site1").is_some() {
            let what = "<connect> between sites".to_string();
            self.ignored.add(what, 1, part.element.tag());
            return None;
        }
        let robot = named.robot;
        let find = |name: &str| robot.bodies.iter().position(|body| body.link == name);
        let all = || robot.bodies.iter().map(|body| body.link.as_str());
        let first = self.referred(part, "body1", "body", (find, all()))?;
        let second = match part.given(self, "body2") {
            Some(_) => self.referred(part, "body2", "body", (find, all()))?,
            None => 0,
        };
        let Some(anchor) = part.vector(self, "anchor", "a point in the axes of `body1`, in m")
        else {
            if part.given(self, "anchor").is_none() {
                self.lacks(part, "anchor", "a point in the axes of `body1`, in m");
            }
            return None;
        };
        let [one, other] = [first, second].map(|body| named.drawn[body].pose);
        let kind = ClosureKind::Points {
            bodies: [first, second],
            points: [anchor, other.inverse().then(&one).point(anchor)],
        };
        let [one, other] = [first, second].map(|body| robot.bodies[body].link.as_str());
        Some((format!("{one}_on_{other}"), kind))
    }

    /// A joint that is where a polynomial of another, or a number, says, with a name for it.
    fn coupled(&mut self, part: &Part<'a, 't>, named: &Named<'_>) -> Option<(String, ClosureKind)> {
        let robot = named.robot;
        let joint = |index: usize| robot.bodies[index].joint.as_ref();
        let find = |name: &str| {
            (0..robot.bodies.len()).find(|&i| joint(i).is_some_and(|joint| joint.name == name))
        };
        let all = || robot.bodies.iter().filter_map(|body| body.joint.as_ref());
        let all = || all().map(|joint| joint.name.as_str());
        let first = self.referred(part, "joint1", "joint", (find, all()))?;
        let second = match part.given(self, "joint2") {
            Some(_) => Some(self.referred(part, "joint2", "joint", (find, all()))?),
            None => None,
        };
        let is_single = |&index: &usize| {
            let kind = joint(index).map(|joint| joint.kind);
            matches!(
                kind,
                Some(JointKind::Revolute { .. } | JointKind::Prismatic { .. })
            )
        };
        if !is_single(&first) || !second.iter().all(is_single) {
            let what = "<joint> of <equality> between joints of several freedoms".to_string();
            self.ignored.add(what, 1, part.element.tag());
            return None;
        }
        let meaning = "up to five coefficients of a polynomial";
        let stated = part.numbers(self, "polycoef", [1, 5], meaning);
        let stated = stated.unwrap_or_else(|| vec![0.0, 1.0]);
        let mut polynomial = [0.0; 5];
        polynomial[..stated.len()].copy_from_slice(&stated);
        let kind = ClosureKind::Joints {
            follower: (first, named.drawn[first].coordinate),
            leader: second.map(|second| (second, named.drawn[second].coordinate)),
            polynomial,
        };
        let name = joint(first).map_or("", |joint| joint.name.as_str());
        Some((format!("{name}_coupled"), kind))
    }

    /// The index of what an attribute names.
    fn referred<'n>(
        &mut self,
        part: &Part<'a, 't>,
        attribute: &str,
        what: &str,
        (find, all): (
            impl Fn(&str) -> Option<usize>,
            impl Iterator<Item = &'n str>,
        ),
    ) -> Option<usize> {
        let Some(given) = part.given(self, attribute) else {
            self.lacks(part, attribute, &format!("the name of a {what}"));
            return None;
        };
        let found = find(given.value());
        if found.is_none() {
            let name = shown(given.value());
            let message = format!(
                "{} names the {what} `{name}`, which does not exist",
                part.owner
            );
            let error = Diagnostic::error(given.span(), message);
            self.report(match suggest(given.value(), all) {
                Some(near) => error.help(format!("did you mean `{}`?", shown(near))),
                None => error.label(format!("no <{what}> has this name")),
            });
        }
        found
    }

    fn lacks(&mut self, part: &Part<'a, 't>, attribute: &str, meaning: &str) {
        let message = format!("{} has no `{attribute}`", part.owner);
        let error = Diagnostic::error(part.element.tag(), message);
        self.report(error.label(format!("expected {meaning}")));
    }
}
