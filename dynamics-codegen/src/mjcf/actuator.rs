//! `<actuator>`: which joints are driven, by which gear.

use super::document::Element;
use super::naming::Names;
use super::reader::{Part, Reader};
use super::schema::ACTUATORS;
use crate::diagnostic::Diagnostic;
use crate::robot::text::{shown, suggest};
use crate::robot::{Actuator, JointKind, Robot};
use crate::source::Span;
use std::collections::BTreeMap;

impl<'a, 't> Reader<'_, 'a, 't> {
    /// The actuators of all sections that pull at joints of one freedom.
    pub fn actuators(
        &mut self,
        root: Element<'a, 't>,
        robot: &Robot,
        joints: &Names,
    ) -> Vec<Actuator> {
        let sections = root.children().into_iter();
        let sections = sections.filter(|section| section.name() == "actuator");
        let elements: Vec<Element> = sections.flat_map(|section| section.children()).collect();
        let mut names = Names::new("actuators");
        for element in &elements {
            if let Some(name) = element.given("name") {
                names.state(name.value(), name.span(), self.findings);
            }
        }
        let mut bodies = BTreeMap::new();
        for (index, body) in robot.bodies.iter().enumerate() {
            if let Some(joint) = &body.joint {
                bodies.entry(joint.name.as_str()).or_insert(index);
            }
        }
        let mut found = Vec::new();
        let mut laws: BTreeMap<&str, usize> = BTreeMap::new();
        let mut first_law: Option<Span> = None;
        for element in elements {
            let Some(actuator) = self.actuator(element, robot, &bodies, joints, &mut names) else {
                continue;
            };
            if element.name() != "motor" {
                *laws.entry(element.name()).or_default() += 1;
                first_law.get_or_insert(element.tag());
            }
            found.push(actuator);
        }
        if let Some(at) = first_law {
            self.report(of_commands(&laws, at));
        }
        found
    }

    fn actuator(
        &mut self,
        element: Element<'a, 't>,
        robot: &Robot,
        bodies: &BTreeMap<&str, usize>,
        joints: &Names,
        names: &mut Names,
    ) -> Option<Actuator> {
        let kind = element.name();
        let at = element.tag();
        if !ACTUATORS.contains(&kind) {
            self.unknown_element(element, "<actuator>", &ACTUATORS);
            return None;
        }
        let class = self.classes.main();
        let class = self.classes.of(element, "class", class, self.findings);
        let owner = match element.given("name") {
            Some(name) => format!("{kind} `{}`", shown(name.value())),
            None => format!("a {kind}"),
        };
        let part = Part::new(element, class, owner);
        for name in ["armature", "damping"] {
            if let Some(given) = part.given(self, name) {
                let what = format!("`{name}` of <{kind}>");
                self.ignored.add(what, 1, given.span());
            }
        }
        let target = element.given("joint").or(element.given("jointinparent"));
        let Some(joint) = target else {
            self.ignored.add(format!("<{kind}> on no joint"), 1, at);
            return None;
        };
        let Some(&body) = bodies
            .get(joint.value())
            .filter(|_| joints.is_taken(joint.value()))
        else {
            let name = shown(joint.value());
            let message = format!(
                "{} drives the joint `{name}`, which does not exist",
                part.owner
            );
            let error = Diagnostic::error(joint.span(), message);
            self.report(match suggest(joint.value(), joints.all()) {
                Some(near) => error.help(format!("did you mean `{}`?", shown(near))),
                None => error.label("no <joint> has this name"),
            });
            return None;
        };
        let moves = robot.bodies[body].joint.as_ref().map(|joint| joint.kind);
        let several = match moves {
            Some(JointKind::Revolute { .. } | JointKind::Prismatic { .. }) => None,
            Some(JointKind::Ball) => Some("ball"),
            _ => Some("free"),
        };
        if let Some(several) = several {
            let what = format!("<{kind}> on a {several} joint");
            self.ignored.add(what, 1, at);
            return None;
        }
        let gear = part.numbers(
            self,
            "gear",
            [1, 6],
            "what the joint's torque is by the drive's",
        );
        let name = match part.element.given("name") {
            Some(_) => part.name(self, "name", "a name")?.value().to_string(),
            None => names.invent(joint.value(), at),
        };
        Some(Actuator {
            name,
            span: at,
            body,
            gear: gear.and_then(|gear| gear.first().copied()).unwrap_or(1.0),
        })
    }
}

/// What the inputs of actuators are that make a force of a command by a law of their own.
fn of_commands(laws: &BTreeMap<&str, usize>, at: Span) -> Diagnostic {
    let kinds: Vec<String> = (laws.iter())
        .map(|(kind, count)| match count {
            1 => format!("<{kind}>"),
            _ => format!("<{kind}> ({count})"),
        })
        .collect();
    let message = format!(
        "the inputs of {} are their forces, not their commands",
        kinds.join(", ")
    );
    Diagnostic::warning(at, message)
        .label("how it makes a force of its command is not read")
        .help("a log has that force, MuJoCo's `actuator_force`, in the column of the input")
}
