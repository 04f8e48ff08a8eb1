//! `urdf "robot.urdf";` and `mjcf "robot.xml";`: a robot description as the base of a model.
//!
//! Each joint that moves becomes a coordinate of its name, in the order of
//! [`Robot::bodies`]: depth first, children as the file lists them. A revolute,
//! continuous or prismatic joint gets an input of the same name, its torque or
//! force. A planar joint `j` has coordinates `j_x`, `j_y`, `j_angle`, a floating
//! one `j_x`, `j_y`, `j_z` and the unit quaternion `j_qx`, `j_qy`, `j_qz`, `j_qw`,
//! with its unit constraint `j_unit`; with `velocities: twist` the same seven are positions,
//! and the coordinates are the twist's components `j_vx`, …, `j_wz`, without a constraint.
//! A joint that mimics another has neither. Links become bodies and frames of their name. What an
//! MJCF's actuators drive has their inputs, scaled by their gears, in place of its own.

use super::builder::Builder;
use super::names::Binding;
use super::robot_options::Options;
use super::{Coordinate, Library};
use crate::diagnostic::{Diagnostic, Severity};
use crate::dimension::Dimension;
use crate::graph::Unary;
use crate::mjcf;
use crate::robot::{self, Format, Joint, JointKind, Robot, Snapped};
use crate::source::{SourceId, Sources, Span};
use crate::syntax::{Name, RobotOption};
use crate::tree;
use crate::urdf;
use std::path::Path;

/// Standard gravity along −z, unless the model states its own, m/s².
const GRAVITY: f64 = 9.81;
/// Speed at which Coulomb friction of a description has reached 76 %, rad/s or m/s.
pub const FRICTION_SPEED: f64 = 0.01;
/// What a rotation's entries are rounded by unless `snap: off`.
const SNAP: f64 = 1e-9;

/// What the model says about its robot description.
#[derive(Debug, Clone)]
pub struct RobotBase {
    /// What the description is.
    pub format: Format,
    /// The name in `<robot name="…">` or `<mujoco model="…">`.
    pub name: String,
    /// The path as the model writes it.
    pub file: String,
    /// Its text, among those that the compilation has read.
    pub source: SourceId,
    /// The files that it includes: their paths from its folder, and their texts.
    pub included: Vec<(String, SourceId)>,
    /// What was rounded to 0 and ±1.
    pub snapped: Snapped,
    /// Which of its numbers are parameters.
    pub described: Vec<Described>,
    /// What it says of the losses in joints where they act.
    pub losses: Vec<StatedLosses>,
}

/// Friction that a description states and that acts: `damping v + friction tanh(v/0.01)`, with the
/// rate `v` of the joint; where the model states a value anew, with that.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedLosses {
    /// The joint.
    pub joint: String,
    /// The coordinate that it moves by; that of another joint, if it mimics.
    pub coordinate: usize,
    /// Whether it mimics another joint.
    pub follows: bool,
    /// Viscous: N·m·s/rad, or N·s/m.
    pub damping: f64,
    /// Coulomb: N·m, or N.
    pub friction: f64,
}

/// A parameter whose value is the description's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Described {
    /// Its name.
    pub parameter: String,
    /// The option in the statement's braces that makes it one.
    pub option: &'static str,
    /// The link or joint that the option names.
    pub of: String,
}

impl Builder<'_> {
    /// Reads the description and declares what it holds.
    pub(super) fn declare_robot(
        &mut self,
        format: Format,
        file: &Name,
        options: &[RobotOption],
        sources: &mut Sources,
        library: &Library,
    ) {
        let read = self.read_robot(format, file, options, sources, library);
        if read.is_none() {
            self.unreadable_base = true;
        }
    }

    fn read_robot(
        &mut self,
        format: Format,
        file: &Name,
        options: &[RobotOption],
        sources: &mut Sources,
        library: &Library,
    ) -> Option<()> {
        if self.model.robot.is_some() {
            let message = "a model has one robot description";
            return self.report(Diagnostic::error(file.span, message));
        }
        let base = options.iter().find(|option| option.name.text == "base");
        if let Some(base) = base.filter(|_| format == Format::Mjcf) {
            let message = "an MJCF says itself what its bodies stand on";
            return self.report(Diagnostic::error(base.name.span, message).help(
                "a body with a `<freejoint/>` floats; `lock` with that joint's name holds it",
            ));
        }
        let options = self.robot_options(options)?;
        if let Some(at) = options.equalities.filter(|_| format == Format::Urdf) {
            let message = "a URDF has no equalities";
            return self.report(Diagnostic::error(at, message).help(
                "write what holds as a constraint: `constraint loop_x: position(a).x == position(b).x;`",
            ));
        }
        let (shown, text) = match library.read(&file.text, robot::LIMIT) {
            Ok(found) => found,
            Err(reason) => {
                let message = format!("cannot read `{}`: {reason}", file.text);
                return self.report(
                    Diagnostic::error(file.span, message)
                        .help("the path starts from the folder of the model file"),
                );
            }
        };
        let shown_name = Path::new(&shown).file_name();
        self.description = shown_name
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let id = sources.add(shown, text);
        let mut findings = Vec::new();
        let reading = robot::Options {
            snap: options.snap.then_some(SNAP),
            locked: &options.lock,
            impossible: options.impossible,
            equalities: options.equalities.is_some(),
        };
        let robot = match format {
            Format::Urdf => urdf::read_with(sources, id, reading, &mut findings),
            Format::Mjcf => {
                let folder = Path::new(&file.text).parent().unwrap_or(Path::new(""));
                let beside = |path: &str| {
                    let path = folder.join(path);
                    library.read(&path.to_string_lossy(), robot::LIMIT)
                };
                mjcf::read_with(sources, id, reading, &beside, &mut findings)
            }
        };
        for finding in findings {
            self.report::<()>(finding);
        }
        let robot = robot?;
        self.model.robot = Some(RobotBase {
            format,
            name: robot.name.clone(),
            file: file.text.clone(),
            source: id,
            included: robot.included.clone(),
            snapped: robot.snapped,
            described: Vec::new(),
            losses: Vec::new(),
        });
        self.has_kinetic = true;
        if !self.states_gravity {
            let gravity = robot.gravity.unwrap_or([0.0, 0.0, -GRAVITY]);
            let graph = &mut self.model.graph;
            self.model.tree.gravity = gravity.map(|g| graph.constant(g));
        }
        Assembly {
            builder: self,
            robot: &robot,
            options: &options,
            at: file.span,
            coordinates: vec![Vec::new(); robot.bodies.len()],
            frames: Vec::new(),
        }
        .assemble()
    }
}

/// A robot on its way into a model.
pub(super) struct Assembly<'a, 'b> {
    pub builder: &'a mut Builder<'b>,
    pub robot: &'a Robot,
    pub options: &'a Options,
    /// The statement.
    at: Span,
    /// Per body: indices of the coordinates of its joint.
    pub coordinates: Vec<Vec<usize>>,
    /// Per body: its frame among the tree's bodies.
    pub frames: Vec<usize>,
}

impl Assembly<'_, '_> {
    fn assemble(mut self) -> Option<()> {
        let limit = super::builder::MAX_SIZE;
        let moving = self.robot.degrees_of_freedom();
        if moving > limit {
            let message = format!("the robot has {moving} moving joints; a model may have {limit}");
            self.builder.too_large = true;
            return self
                .builder
                .report(Diagnostic::error(self.robot.span, message).also(self.at, "needed here"));
        }
        self.check_names()?;
        for index in 0..self.robot.bodies.len() {
            let joint = self.joint(index);
            self.body(index, joint);
        }
        self.close();
        if let Some(at) = self.options.twist
            && self.builder.model.poses.is_empty()
        {
            let error = Diagnostic::error(at, "nothing floats: there is no twist to move by");
            let help = "let the root float, `base: floating;`, or leave this out";
            return self.builder.report(error.help(help));
        }
        Some(())
    }

    /// Joints that `inputs`, `origins`, `losses` and `friction` name and links that `parameters` names.
    fn check_names(&mut self) -> Option<()> {
        let joints: Vec<&str> = (self.robot.bodies.iter())
            .filter_map(|body| body.joint.as_ref().map(|joint| joint.name.as_str()))
            .filter(|name| !name.is_empty())
            .collect();
        let links: Vec<&str> = (self.robot.bodies.iter().map(|b| b.link.as_str()))
            .filter(|name| !name.is_empty())
            .collect();
        let inputs = self.options.inputs.iter().flat_map(|chosen| &chosen.names);
        let origins = self.options.origins.names.iter();
        let losses = self.options.losses.names().iter();
        let friction = self.options.friction.names.iter();
        let wanted = inputs.clone().chain(origins).chain(losses).chain(friction);
        let wanted = wanted.map(|name| (name, &joints, "joint"));
        let parameters = self.options.parameters.names.iter();
        let wanted = wanted.chain(parameters.map(|name| (name, &links, "link")));
        let mut clean = true;
        for (name, known, what) in wanted {
            if known.contains(&name.text.as_str()) {
                continue;
            }
            clean = false;
            let message = format!("the robot has no {what} named `{}`", name.text);
            let error = Diagnostic::error(name.span, message);
            let near = self.builder.near(&name.text, known.iter().copied());
            self.builder.report::<()>(match near {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None if known.len() > 20 => error,
                None => error.help(format!("it has: {}", known.join(", "))),
            });
        }
        let locked = |name: &&Name| self.options.lock.iter().any(|l| l.joint == name.text);
        if let Some(name) = inputs.clone().find(locked) {
            let message = format!("`{}` is locked: nothing drives it", name.text);
            return self
                .builder
                .report(Diagnostic::error(name.span, message).help("take it out of `inputs`"));
        }
        clean.then_some(())
    }

    fn joint(&mut self, index: usize) -> tree::Joint {
        let Some(joint) = &self.robot.bodies[index].joint else {
            return if self.options.floating {
                let name = self.robot.bodies[index].link.clone();
                self.floating(index, &name, self.robot.bodies[index].span)
            } else {
                tree::Joint::Fixed
            };
        };
        let (name, span) = (joint.name.as_str(), joint.span);
        match joint.kind {
            JointKind::Fixed => tree::Joint::Fixed,
            JointKind::Revolute { axis } => tree::Joint::Revolute {
                axis,
                coordinate: self.single(index),
            },
            JointKind::Prismatic { axis } => tree::Joint::Prismatic {
                axis,
                coordinate: self.single(index),
            },
            JointKind::Planar { axis } => {
                let coordinates =
                    [("x", "m"), ("y", "m"), ("angle", "rad")].map(|(suffix, unit)| {
                        self.coordinate(index, &format!("{name}_{suffix}"), unit, span)
                    });
                for coordinate in &coordinates {
                    self.losses(joint, coordinate.index, None);
                }
                tree::Joint::Planar {
                    normal: axis,
                    coordinates,
                }
            }
            JointKind::Ball => self.ball(index, joint),
            JointKind::Floating { .. } => {
                let name = name.to_string();
                self.floating(index, &name, span)
            }
        }
    }

    /// A joint with one freedom: its own coordinate, or that of the joint it follows.
    fn single(&mut self, index: usize) -> tree::Coordinate {
        let Some(joint) = &self.robot.bodies[index].joint else {
            unreachable!("only joints have freedoms")
        };
        if let Some(mimic) = joint.mimic {
            let source = self.coordinates[mimic.source].first().copied();
            // The source stands before the follower unless the file says otherwise.
            let source = source.unwrap_or_else(|| self.own(mimic.source));
            let coordinate = &self.builder.model.coordinates[source];
            let (position, velocity) = (coordinate.position, coordinate.velocity);
            let graph = &mut self.builder.model.graph;
            let (q, v) = (graph.var(position), graph.var(velocity));
            let scaled = graph.scale(mimic.multiplier, q);
            let offset = graph.constant(mimic.offset);
            let follower = tree::Coordinate {
                q: graph.add(scaled, offset),
                v: graph.scale(mimic.multiplier, v),
                index: source,
                ratio: mimic.multiplier,
            };
            self.losses(joint, source, Some(mimic.multiplier));
            self.energies(joint, &follower);
            return follower;
        }
        let own = match self.coordinates[index].first() {
            Some(&own) => own,
            None => self.own(index),
        };
        let coordinate = &self.builder.model.coordinates[own];
        tree::Coordinate {
            q: self.builder.model.graph.var(coordinate.position),
            v: self.builder.model.graph.var(coordinate.velocity),
            index: own,
            ratio: 1.0,
        }
    }

    /// The coordinate and the input of a joint with one freedom.
    fn own(&mut self, index: usize) -> usize {
        let Some(joint) = &self.robot.bodies[index].joint else {
            unreachable!("only joints have freedoms")
        };
        let turns = matches!(joint.kind, JointKind::Revolute { .. });
        let (unit, effort) = if turns { ("rad", "N*m") } else { ("m", "N") };
        let coordinate = self.coordinate(index, &joint.name, unit, joint.span);
        self.drive(index, joint, effort, coordinate.index);
        self.losses(joint, coordinate.index, None);
        self.energies(joint, &coordinate);
        coordinate.index
    }

    pub(super) fn coordinate(
        &mut self,
        body: usize,
        name: &str,
        unit: &str,
        span: Span,
    ) -> tree::Coordinate {
        let model = &mut self.builder.model;
        let dimension = match unit {
            "1" => Some(Dimension::ONE),
            unit => Dimension::of_unit(unit),
        };
        let position = model.graph.symbol(format!("q_{name}"));
        let velocity = model.graph.symbol(format!("dq_{name}"));
        let zero = model.graph.zero();
        let index = model.coordinates.len();
        model.coordinates.push(Coordinate {
            name: name.to_string(),
            dimension,
            unit: unit.to_string(),
            position,
            velocity,
            doc: String::new(),
        });
        model.forces.push(zero);
        let (q, v) = (model.graph.var(position), model.graph.var(velocity));
        let name = Name {
            text: name.to_string(),
            span,
        };
        self.builder.bind(&name, Binding::Coordinate(index));
        self.coordinates[body].push(index);
        tree::Coordinate {
            q,
            v,
            index,
            ratio: 1.0,
        }
    }

    /// What a description states of friction, viscous and Coulomb; a joint that follows turns
    /// `follows` times as far as its coordinate.
    pub(super) fn losses(&mut self, joint: &Joint, on: usize, follows: Option<f64>) {
        let acts = self.options.losses.includes(&joint.name);
        let Some(losses) = joint.losses.filter(|_| acts) else {
            return;
        };
        let ratio = follows.unwrap_or(1.0);
        let [(damping, viscous), (friction, dry)] = self.loss(joint, losses, follows.is_some());
        if let Some(robot) = &mut self.builder.model.robot {
            robot.losses.push(StatedLosses {
                joint: joint.name.clone(),
                coordinate: on,
                follows: follows.is_some(),
                damping: viscous,
                friction: dry,
            });
        }
        let model = &mut self.builder.model;
        let graph = &mut model.graph;
        let rate = graph.var(model.coordinates[on].velocity);
        let rate = graph.scale(ratio, rate);
        let square = graph.mul(rate, rate);
        let half = graph.scale(0.5, damping);
        let power = graph.mul(half, square);
        model.dissipation = graph.add(model.dissipation, power);
        let steep = graph.scale(1.0 / FRICTION_SPEED, rate);
        let direction = graph.unary(Unary::Tanh, steep);
        let against = graph.scale(-ratio, friction);
        let friction = graph.mul(against, direction);
        model.forces[on] = graph.add(model.forces[on], friction);
    }

    fn body(&mut self, index: usize, joint: tree::Joint) {
        let body = &self.robot.bodies[index];
        let parent = body
            .joint
            .as_ref()
            .map_or(0, |joint| self.frames[joint.parent]);
        let inertia = self.inertia(index);
        let placement = self.placement(index);
        let model = &mut self.builder.model;
        model.tree.bodies.push(tree::Body {
            name: match &body.joint {
                Some(joint) if body.link.is_empty() => joint.name.clone(),
                _ => body.link.clone(),
            },
            parent: Some(parent),
            placement,
            joint,
            inertia,
        });
        let frame = model.tree.bodies.len() - 1;
        self.frames.push(frame);
        if body.link.is_empty() {
            return;
        }
        model.bodies.push(super::NamedBody {
            name: body.link.clone(),
            frame,
            massive: frame,
            doc: String::new(),
        });
        self.builder.name_frame(&body.link, body.span, frame);
    }
}

impl Builder<'_> {
    /// Whether an error was found so far.
    pub(super) fn failed(&self) -> bool {
        self.findings()
            .iter()
            .any(|finding| finding.severity == Severity::Error)
    }
}
