//! From nested elements to the bodies of a robot, parents before children.

use super::defaults::ClassId;
use super::document::Element;
use super::equality::Named;
use super::inertia::{Owner, Placed};
use super::joint::Motion;
use super::naming::Names;
use super::reader::{Part, Reader};
use super::schema::{
    BODY, ElementRule, FRAME, GEOM, IN_BODY, MACROS, READ_IN_BODY, READ_SECTIONS, SECTIONS,
};
use crate::diagnostic::Diagnostic;
use crate::robot::text::{shown, suggest};
use crate::robot::{Body, Format, Frame, Inertia, Joint, JointKind, Placement, Robot, Vector3};

/// What MuJoCo calls the body that does not move.
const WORLD: &str = "world";

/// Reads the whole file.
pub(super) fn read<'a, 't>(reader: &mut Reader<'_, 'a, 't>, root: Element<'a, 't>) -> Robot {
    let mut tree = Tree {
        bodies: Names::new("bodies"),
        joints: Names::new("joints"),
        robot: Robot {
            format: Format::Mjcf,
            name: root
                .given("model")
                .map_or("", |name| name.value())
                .to_string(),
            span: root.tag(),
            bodies: Vec::new(),
            frames: Vec::new(),
            snapped: reader.snapped,
            gravity: Some(reader.settings.gravity),
            actuators: Vec::new(),
            closures: Vec::new(),
            included: Vec::new(),
        },
        drawn: Vec::new(),
        reader,
    };
    let worlds = tree.sections(root);
    tree.world(root, &worlds);
    let Tree {
        mut robot,
        joints,
        drawn,
        ..
    } = tree;
    robot.actuators = reader.actuators(root, &robot, &joints);
    robot.closures = reader.closures(
        root,
        &Named {
            robot: &robot,
            drawn: &drawn,
        },
    );
    robot.snapped = reader.snapped;
    robot.frames = (robot.bodies.iter().enumerate())
        .filter(|(_, body)| !body.link.is_empty())
        .map(|(index, body)| Frame {
            link: body.link.clone(),
            joint: body.joint.as_ref().map(|joint| joint.name.clone()),
            span: body.span,
            body: index,
            placement: Placement::IDENTITY,
        })
        .collect();
    robot
}

struct Tree<'r, 'p, 'a, 't> {
    reader: &'r mut Reader<'p, 'a, 't>,
    bodies: Names,
    joints: Names,
    robot: Robot,
    /// Of each body.
    drawn: Vec<Drawn>,
}

/// As the file draws a body.
#[derive(Clone, Copy)]
pub(super) struct Drawn {
    /// Its place in the world.
    pub pose: Placement,
    /// The coordinate of its joint, rad or m.
    pub coordinate: f64,
}

/// A body that is yet to be read.
struct Waiting<'a, 't> {
    element: Element<'a, 't>,
    /// The index of the body that it is fixed to, or moves on.
    parent: usize,
    /// The frames that it stands in, in that body.
    outer: Placement,
    class: ClassId,
    /// Whether anything moves what it stands on.
    moves: bool,
    /// Whether it stands on the world.
    outermost: bool,
}

/// What a body holds, frames undone.
#[derive(Default)]
struct Contents<'a, 't> {
    joints: Vec<Placed<'a, 't>>,
    geoms: Vec<Placed<'a, 't>>,
    inertial: Option<Placed<'a, 't>>,
    bodies: Vec<(Element<'a, 't>, Placement, ClassId)>,
}

impl<'a, 't> Tree<'_, '_, 'a, 't> {
    /// Looks at the sections; those of the world.
    fn sections(&mut self, root: Element<'a, 't>) -> Vec<Element<'a, 't>> {
        let mut worlds = Vec::new();
        for section in root.children() {
            let name = section.name();
            if name == "worldbody" {
                worlds.push(section);
            } else if SECTIONS.contains(&name) {
                let count = section.children().len().max(1);
                self.reader
                    .ignored
                    .add(format!("<{name}>"), count, section.tag());
            } else if !READ_SECTIONS.contains(&name) {
                let known = [&READ_SECTIONS[..], &SECTIONS[..]].concat();
                self.reader.unknown_element(section, "<mujoco>", &known);
            }
        }
        worlds
    }

    fn world(&mut self, root: Element<'a, 't>, worlds: &[Element<'a, 't>]) {
        let span = worlds.first().map_or(root.tag(), Element::tag);
        if worlds.is_empty() {
            let error = Diagnostic::error(span, "the file has no <worldbody>");
            self.reader.report(
                error.help("bodies stand in it: write <worldbody> <body> … </body> </worldbody>"),
            );
        }
        self.robot.bodies.push(Body {
            link: WORLD.to_string(),
            span,
            joint: None,
            inertia: Inertia::ZERO,
            inertial: None,
        });
        self.drawn.push(Drawn {
            pose: Placement::IDENTITY,
            coordinate: 0.0,
        });
        self.bodies.state(WORLD, span, self.reader.findings);
        self.state_names(worlds);
        let mut waiting = Vec::new();
        let main = self.reader.classes.main();
        for &element in worlds.iter().rev() {
            let inner = self.contents(element, main);
            for (part, _) in inner.joints.iter().chain(&inner.inertial) {
                let message = format!("{} stands in <worldbody>, which does not move", part.owner);
                let error = Diagnostic::error(part.element.tag(), message);
                self.reader.report(error.help("write it in a <body>"));
            }
            self.ignore_geoms(&inner.geoms);
            self.wait(&mut waiting, inner.bodies, 0, (false, true));
        }
        while let Some(next) = waiting.pop() {
            self.body(next, &mut waiting);
        }
    }

    /// Notes the names that bodies and joints have, so that others can be invented.
    fn state_names(&mut self, worlds: &[Element<'a, 't>]) {
        let mut waiting: Vec<Element> = worlds.iter().rev().copied().collect();
        while let Some(element) = waiting.pop() {
            let names = match element.name() {
                "body" => Some(&mut self.bodies),
                "joint" | "freejoint" => Some(&mut self.joints),
                _ => None,
            };
            if let Some((names, given)) = names.zip(element.given("name")) {
                names.state(given.value(), given.span(), self.reader.findings);
            }
            waiting.extend(element.children().into_iter().rev());
        }
    }

    fn wait(
        &self,
        waiting: &mut Vec<Waiting<'a, 't>>,
        inner: Vec<(Element<'a, 't>, Placement, ClassId)>,
        parent: usize,
        (moves, outermost): (bool, bool),
    ) {
        let all = inner.into_iter().rev();
        waiting.extend(all.map(|(element, outer, class)| Waiting {
            element,
            parent,
            outer,
            class,
            moves,
            outermost,
        }));
    }

    /// What stands in a body, with the frames around it multiplied out.
    fn contents(&mut self, body: Element<'a, 't>, class: ClassId) -> Contents<'a, 't> {
        let mut found = Contents::default();
        let of = |element: Element<'a, 't>, placement, class| {
            let all = element.children().into_iter().rev();
            all.map(move |child| (child, placement, class))
        };
        let mut waiting: Vec<_> = of(body, Placement::IDENTITY, class).collect();
        while let Some((element, outer, class)) = waiting.pop() {
            let name = element.name();
            match name {
                "body" => found.bodies.push((element, outer, class)),
                "frame" => {
                    let (placement, class) = self.frame(element, class, &FRAME);
                    let placement = self.product(&outer, &placement);
                    waiting.extend(of(element, placement, class));
                }
                "joint" | "freejoint" | "geom" | "inertial" => {
                    let reader = &mut *self.reader;
                    let class = reader.classes.of(element, "class", class, reader.findings);
                    let owner = called(element);
                    let part = (Part::new(element, class, owner), outer);
                    match name {
                        "geom" => found.geoms.push(part),
                        "inertial" => self.inertial(&mut found, part),
                        _ => found.joints.push(part),
                    }
                }
                _ if MACROS.contains(&name) => self.refuse_macro(element),
                _ if IN_BODY.contains(&name) => {
                    let what = format!("<{name}>");
                    self.reader.ignored.add(what, 1, element.tag());
                }
                _ => {
                    let known = [&READ_IN_BODY[..], &IN_BODY[..], &MACROS[..]].concat();
                    self.reader.unknown_element(element, "a body", &known);
                }
            }
        }
        found
    }

    fn inertial(&mut self, found: &mut Contents<'a, 't>, part: Placed<'a, 't>) {
        let Some((first, _)) = &found.inertial else {
            found.inertial = Some(part);
            return;
        };
        let error = Diagnostic::error(part.0.element.tag(), "a body has more than one <inertial>")
            .label("the second")
            .also(first.element.tag(), "the first");
        self.reader.report(error.help("keep one of the two"));
    }

    fn refuse_macro(&mut self, element: Element<'a, 't>) {
        let name = element.name();
        let message = format!("<{name}> writes bodies that do not stand in the file");
        self.reader.report(
            Diagnostic::error(element.tag(), message)
                .label("it is not read")
                .help("let MuJoCo write them out: read the file and save it by `mujoco.mj_saveLastXML`"),
        );
    }

    /// Where a body or frame stands in what is around it, and the class of what is in it.
    fn frame(
        &mut self,
        element: Element<'a, 't>,
        class: ClassId,
        rule: &ElementRule,
    ) -> (Placement, ClassId) {
        let owner = called(element);
        let reader = &mut *self.reader;
        reader.check_attributes(element, rule, &owner);
        let class = reader
            .classes
            .of(element, "childclass", class, reader.findings);
        let placement = reader.pose(&Part::new(element, class, owner));
        (placement, class)
    }

    fn product(&mut self, outer: &Placement, inner: &Placement) -> Placement {
        let mut product = outer.then(inner);
        self.reader.snapped.rotation(&mut product.rotation);
        product
    }

    fn body(&mut self, next: Waiting<'a, 't>, waiting: &mut Vec<Waiting<'a, 't>>) {
        let element = next.element;
        let (own, class) = self.frame(element, next.class, &BODY);
        let placement = self.product(&next.outer, &own);
        let name = match element.given("name") {
            Some(_) => {
                let part = Part::new(element, class, "a body".to_string());
                let name = part.name(self.reader, "name", "a name");
                name.map(|given| given.value().to_string())
            }
            None => Some(self.bodies.invent("body", element.tag())),
        };
        let name = name.unwrap_or_default();
        let inner = self.contents(element, class);
        let motions = self.motions(&next, &name, &inner.joints, placement);
        let moves = next.moves || !motions.is_empty();
        let (inertia, inertial) = match moves {
            // What stands on the world takes no part in the motion, whatever its mass.
            false => (Inertia::ZERO, None),
            true => {
                let inertial = inner.inertial.as_ref();
                let owner = Owner {
                    name: &shown(&name),
                    tag: element.tag(),
                    pos: own.translation,
                };
                self.reader.inertia(&owner, inertial, &inner.geoms)
            }
        };
        for (part, _) in &inner.geoms {
            self.reader
                .check_attributes(part.element, &GEOM, &part.owner);
        }
        if inner.inertial.is_some() || !moves {
            self.ignore_geoms(&inner.geoms);
        }
        let body = Body {
            span: element
                .given("name")
                .map_or(element.tag(), |name| name.span()),
            link: name,
            joint: None,
            inertia,
            inertial,
        };
        let index = self.attach(body, next.parent, placement, motions);
        self.wait(waiting, inner.bodies, index, (moves, false));
    }

    fn ignore_geoms(&mut self, geoms: &[Placed<'a, 't>]) {
        for (part, _) in geoms {
            self.reader
                .ignored
                .add("<geom>".to_string(), 1, part.element.tag());
        }
    }

    /// The joints of a body, with their names.
    fn motions(
        &mut self,
        next: &Waiting<'a, 't>,
        body: &str,
        joints: &[Placed<'a, 't>],
        home: Placement,
    ) -> Vec<(String, Part<'a, 't>, Motion)> {
        let mut motions = Vec::new();
        for (part, outer) in joints {
            if self.reader.is_free(part) && !(next.outermost && joints.len() == 1) {
                let error = Diagnostic::error(
                    part.element.tag(),
                    format!("{} is free, but not alone or not on the world", part.owner),
                );
                self.reader.report(
                    error.help("a free joint is the only one of a body that stands in <worldbody>"),
                );
                continue;
            }
            let Some(motion) = self.reader.joint(part, outer, home) else {
                continue;
            };
            let name = match part.element.given("name") {
                Some(_) => {
                    let name = part.name(self.reader, "name", "a name");
                    name.map(|given| given.value().to_string())
                }
                None => Some(self.joints.invent(body, part.element.tag())),
            };
            if let Some(name) = name {
                motions.push((name, part.clone(), motion));
            }
        }
        motions
    }

    /// Adds a body with what carries it: a body without mass and name for every joint but the
    /// last, and for the last, too, if it is anchored beside the body's origin. The body's index.
    fn attach(
        &mut self,
        body: Body,
        parent: usize,
        placement: Placement,
        motions: Vec<(String, Part<'a, 't>, Motion)>,
    ) -> usize {
        let mut drawn = Drawn {
            pose: self.drawn[parent].pose.then(&placement),
            coordinate: 0.0,
        };
        let (mut carrier, mut place) = (parent, placement);
        // Where the origin of the frame reached so far is, from that of the body.
        let mut reached: Vector3 = [0.0; 3];
        let count = motions.len();
        for (number, (name, part, motion)) in motions.into_iter().enumerate() {
            if matches!(motion.kind, JointKind::Floating { .. }) {
                // Its coordinates are the pose in the world.
                place = Placement::IDENTITY;
            }
            drawn.coordinate = motion.drawn_at;
            let anchor = motion.anchor.unwrap_or(reached);
            let mut shift = motion.zero;
            for i in 0..3 {
                shift.translation[i] += anchor[i] - reached[i];
            }
            reached = anchor;
            let joint = Joint {
                name,
                span: part
                    .element
                    .given("name")
                    .map_or(part.element.tag(), |name| name.span()),
                parent: carrier,
                kind: motion.kind,
                placement: self.product(&place, &shift),
                limits: None,
                mimic: None,
                losses: motion.losses,
                armature: motion.armature,
                spring: motion.spring,
            };
            if number + 1 == count && reached == [0.0; 3] {
                return self.push(body, joint, drawn);
            }
            let between = Body {
                link: String::new(),
                inertia: Inertia::ZERO,
                inertial: None,
                ..body.clone()
            };
            carrier = self.push(between, joint, drawn);
            place = Placement::IDENTITY;
        }
        let back = Placement {
            translation: reached.map(|x| 0.0 - x),
            ..Placement::IDENTITY
        };
        // A weld that stands in the file is called like its body, unless a joint is.
        let named = count == 0 && !self.joints.is_taken(&body.link);
        let weld = Joint {
            name: if named {
                body.link.clone()
            } else {
                String::new()
            },
            span: body.span,
            parent: carrier,
            kind: JointKind::Fixed,
            placement: self.product(&place, &back),
            limits: None,
            mimic: None,
            losses: None,
            armature: 0.0,
            spring: None,
        };
        self.push(body, weld, drawn)
    }

    fn push(&mut self, body: Body, joint: Joint, drawn: Drawn) -> usize {
        self.drawn.push(drawn);
        self.robot.bodies.push(Body {
            joint: Some(joint),
            ..body
        });
        self.robot.bodies.len() - 1
    }
}

impl<'a, 't> Reader<'_, 'a, 't> {
    /// An element that stands where MJCF has none of its name.
    pub fn unknown_element(&mut self, element: Element<'a, 't>, place: &str, known: &[&str]) {
        let name = shown(element.name());
        match suggest(element.name(), known.iter().copied()) {
            Some(near) => self.report(
                Diagnostic::error(
                    element.tag(),
                    format!("the element <{name}> in {place} is unknown"),
                )
                .label(format!("did you mean <{near}>?")),
            ),
            None => self.ignored.add(format!("<{name}>"), 1, element.tag()),
        }
    }
}

/// How messages call an element.
fn called(element: Element) -> String {
    let kind = element.name();
    match element
        .given("name")
        .filter(|name| !name.value().is_empty())
    {
        Some(name) => format!("{kind} `{}`", shown(name.value())),
        None => format!("<{kind}>"),
    }
}
