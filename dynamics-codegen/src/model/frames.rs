//! Frames as products of transforms, lowered to joints of a tree.

use super::builder::Builder;
use super::mounted::is_inertial;
use super::names::Declared;
use super::quantity::{Measure, Quantity};
use super::sensor::MOMENTARY_VECTORS;
use crate::diagnostic::{Diagnostic, nearest};
use crate::dimension::Dimension;
use crate::graph::{ExprId, SymbolId};
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name, PortKind};
use crate::tree::{Body, Coordinate, Displacement, Inertia, Joint, Placement};
use std::collections::BTreeMap;

/// A frame may lean on this many others, one on the next.
const MAX_DEPTH: usize = 128;
/// The frame that does not move.
pub(super) const WORLD: &str = "world";
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// The transforms, with what they take.
pub(crate) const TRANSFORMS: [(&str, usize); 4] = [
    ("translate", 3),
    ("rotate_x", 1),
    ("rotate_y", 1),
    ("rotate_z", 1),
];

/// A named frame before and while it is being lowered.
#[derive(Debug, Clone)]
pub(super) struct FrameEntry {
    pub value: Option<Expr>,
    pub state: FrameState,
}

/// How far a frame has come.
#[derive(Debug, Clone, Copy)]
pub(super) enum FrameState {
    Waiting,
    Lowering,
    /// Its index among the tree's bodies.
    Done(usize),
    Failed,
}

/// The frames of one file.
#[derive(Debug, Clone, Default)]
pub(super) struct Frames {
    pub names: BTreeMap<String, Declared<usize>>,
    pub entries: Vec<FrameEntry>,
    depth: usize,
}

/// Where a chain of transforms has come to.
struct Chain {
    parent: usize,
    rotation: [[f64; 3]; 3],
    translation: [ExprId; 3],
}

impl Builder<'_> {
    /// Declares a frame; its value is lowered when first needed.
    pub(super) fn declare_frame(&mut self, name: &Name, value: &Expr) {
        if name.text == WORLD {
            let message = "`world` is the frame that does not move and cannot be redefined";
            self.report::<()>(Diagnostic::error(name.span, message));
            return;
        }
        self.add_frame(name, Some(value.clone()), FrameState::Waiting);
    }

    /// Gives a body of the tree a name as a frame.
    pub(super) fn add_frame(&mut self, name: &Name, value: Option<Expr>, state: FrameState) {
        let frames = &mut self.scope.frames;
        let taken = frames.names.get(&name.text).map(|declared| declared.span);
        if let Some(first) = taken {
            self.duplicate(name, first);
            return;
        }
        let what = frames.entries.len();
        frames.entries.push(FrameEntry { value, state });
        let declared = Declared {
            what,
            span: name.span,
        };
        frames.names.insert(name.text.clone(), declared);
    }

    /// The tree's body behind the name of a frame or body.
    pub(super) fn find_frame(&mut self, name: &str, span: Span) -> Option<usize> {
        if let Some(&(PortKind::Body, index)) = self.scope.ports.get(name) {
            return Some(self.model.bodies[index].frame);
        }
        if let Some(&(PortKind::Frame, index)) = self.scope.ports.get(name) {
            return Some(self.mounts.parent(index));
        }
        let declared = self.scope.frames.names.get(name);
        match declared.map(|declared| declared.what) {
            Some(index) => {
                let frame = self.resolve_frame(index, name, span)?;
                Some(self.mounts.parent(frame))
            }
            None if name == WORLD => Some(0),
            None => self.unknown_frame(name, span),
        }
    }

    fn unknown_frame(&mut self, name: &str, span: Span) -> Option<usize> {
        if self.unreadable_base || self.scope.is_unreadable(name) {
            return None;
        }
        let error = Diagnostic::error(span, format!("there is no frame named `{name}`"));
        let known = self.scope.frames.names.keys().map(String::as_str);
        let known: Vec<&str> = known.chain([WORLD]).collect();
        self.report(match self.near(name, known.iter().copied()) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None if known.len() > 20 => error,
            None => error.help(format!("the frames are: {}", known.join(", "))),
        })
    }

    fn resolve_frame(&mut self, index: usize, name: &str, span: Span) -> Option<usize> {
        match self.scope.frames.entries[index].state {
            FrameState::Done(body) => Some(body),
            FrameState::Failed => None,
            FrameState::Lowering => {
                let message = format!("the frame `{name}` is defined by itself");
                self.report(Diagnostic::error(span, message).label("the circle closes here"))
            }
            FrameState::Waiting if self.scope.frames.depth == MAX_DEPTH => {
                let message = format!("frames lean on each other more than {MAX_DEPTH} deep");
                self.report(Diagnostic::error(span, message))
            }
            FrameState::Waiting => {
                let value = self.scope.frames.entries[index].value.clone()?;
                self.scope.frames.entries[index].state = FrameState::Lowering;
                self.scope.frames.depth += 1;
                let body = self.lower_frame(&value, name);
                self.scope.frames.depth -= 1;
                self.scope.frames.entries[index].state =
                    body.map_or(FrameState::Failed, FrameState::Done);
                body
            }
        }
    }

    /// Every frame that is not lowered yet: what nothing uses is still checked.
    pub(super) fn resolve_frames(&mut self) {
        let names: Vec<(String, Span, usize)> = (self.scope.frames.names.iter())
            .map(|(name, declared)| (name.clone(), declared.span, declared.what))
            .collect();
        for (name, span, index) in names {
            if matches!(self.scope.frames.entries[index].state, FrameState::Waiting) {
                self.resolve_frame(index, &name, span);
            }
        }
    }

    /// A product of frames and transforms as a body of the tree.
    pub(super) fn lower_frame(&mut self, value: &Expr, name: &str) -> Option<usize> {
        let factors: Vec<&Expr> = match &value.kind {
            ExprKind::Product(first, rest) => {
                if let Some((_, divisor)) = rest.iter().find(|(divide, _)| *divide) {
                    let message = "a frame is a product of transforms; there is no quotient";
                    return self.report(Diagnostic::error(divisor.span, message));
                }
                let rest = rest.iter().map(|(_, factor)| factor);
                std::iter::once(&**first).chain(rest).collect()
            }
            _ => vec![value],
        };
        let zero = self.model.graph.zero();
        let mut chain = Chain {
            parent: 0,
            rotation: IDENTITY,
            translation: [zero; 3],
        };
        for (position, factor) in factors.into_iter().enumerate() {
            match &factor.kind {
                ExprKind::Name(parent) if position == 0 => {
                    chain.parent = self.find_frame(parent, factor.span)?;
                }
                ExprKind::Name(inner) => {
                    let message = format!("`{inner}` stands behind a transform");
                    return self.report(Diagnostic::error(factor.span, message).help(
                        "a frame begins with the frame it is attached to; transforms follow",
                    ));
                }
                ExprKind::Call(function, arguments) => {
                    self.transform(&mut chain, function, arguments, factor.span, name)?;
                }
                _ => {
                    if let Some((name, place)) = self.lost_use(factor) {
                        return self.unknown_use(&name, place);
                    }
                    let names = TRANSFORMS.map(|(name, _)| name).join(", ");
                    let error = Diagnostic::error(factor.span, "expected a frame or a transform");
                    return self.report(error.help(format!("the transforms are: {names}")));
                }
            }
        }
        Some(self.push_body(&chain, name, Joint::Fixed))
    }

    fn transform(
        &mut self,
        chain: &mut Chain,
        function: &Name,
        arguments: &[Expr],
        span: Span,
        name: &str,
    ) -> Option<()> {
        let Some(&(_, arity)) = TRANSFORMS.iter().find(|(known, _)| *known == function.text) else {
            let message = format!("there is no transform `{}`", function.text);
            let error = Diagnostic::error(function.span, message);
            let known = TRANSFORMS.map(|(known, _)| known);
            return self.report(match nearest(&function.text, known) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("the transforms are: {}", known.join(", "))),
            });
        };
        if arguments.len() != arity {
            let words = ["no argument", "one angle", "", "three distances"][arity];
            let found = arguments.len();
            let message = format!("`{}` takes {words}, found {found}", function.text);
            return self.report(Diagnostic::error(span, message));
        }
        let axis = match function.text.as_str() {
            "rotate_x" => 0,
            "rotate_y" => 1,
            "rotate_z" => 2,
            _ => {
                for (axis, argument) in arguments.iter().enumerate() {
                    self.slide(chain, axis, argument, name)?;
                }
                return Some(());
            }
        };
        self.turn(chain, axis, &arguments[0], name)
    }

    fn slide(&mut self, chain: &mut Chain, axis: usize, by: &Expr, name: &str) -> Option<()> {
        let value = self.displacement(by, Dimension::LENGTH, "a distance")?;
        if self.moves(value.expr) {
            self.push_joint(chain, axis, false, value.expr, name);
        } else {
            for row in 0..3 {
                let part = self
                    .model
                    .graph
                    .scale(chain.rotation[row][axis], value.expr);
                chain.translation[row] = self.model.graph.add(chain.translation[row], part);
            }
        }
        Some(())
    }

    fn turn(&mut self, chain: &mut Chain, axis: usize, by: &Expr, name: &str) -> Option<()> {
        let value = self.displacement(by, Dimension::ONE, "an angle")?;
        let Some(angle) = self.model.graph.as_constant(value.expr) else {
            self.push_joint(chain, axis, true, value.expr, name);
            return Some(());
        };
        let (mut sin, mut cos) = angle.sin_cos();
        // A quarter turn is one, however many digits of pi are written.
        for entry in [&mut sin, &mut cos] {
            if (*entry - entry.round()).abs() <= 1e-9 {
                *entry = entry.round();
            }
        }
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        for row in &mut chain.rotation {
            let (a, b) = (row[j], row[k]);
            row[j] = cos * a + sin * b;
            row[k] = cos * b - sin * a;
        }
        Some(())
    }

    fn displacement(&mut self, by: &Expr, dimension: Dimension, role: &str) -> Option<Quantity> {
        let value = self.lower(by)?;
        self.expect_dimension(value, dimension, by.span, role)?;
        let inputs = self.model.inputs.iter().map(|u| u.symbol);
        let mut readings = self.model.kinematics.iter().map(|k| k.symbol);
        let graph = &self.model.graph;
        if readings.any(|symbol| graph.depends_on(&[value.expr], symbol)) {
            let message = "a frame cannot depend on where another one is";
            return self.report(Diagnostic::error(by.span, message).help(
                "attach it to that frame: `frame b = a * translate(…);`, or tie the two by a constraint",
            ));
        }
        let mut forbidden = inputs.chain(self.model.coordinates.iter().map(|c| c.velocity));
        if forbidden.any(|symbol| graph.depends_on(&[value.expr], symbol)) {
            let message = "a frame depends on positions, parameters and time only";
            return self.report(Diagnostic::error(by.span, message).help(
                "what follows a velocity or an input has a place of its own: make it a `coordinate` and tie it by a constraint, `constraint follow: dot(z) == …;`",
            ));
        }
        Some(value)
    }

    /// Whether an expression changes along the motion.
    fn moves(&self, expr: ExprId) -> bool {
        let mut symbols = self.model.coordinates.iter().map(|c| c.position);
        symbols.any(|symbol| self.model.graph.depends_on(&[expr], symbol))
            || self.model.graph.depends_on(&[expr], self.model.time)
    }

    fn push_joint(&mut self, chain: &mut Chain, axis: usize, turns: bool, by: ExprId, name: &str) {
        let axis = IDENTITY[axis];
        let joint = match self.simple_coordinate(by) {
            Some(coordinate) if turns => Joint::Revolute { axis, coordinate },
            Some(coordinate) => Joint::Prismatic { axis, coordinate },
            None => Joint::Driven {
                axis,
                turns,
                displacement: Box::new(self.driven(by)),
            },
        };
        let zero = self.model.graph.zero();
        chain.parent = self.push_body(chain, name, joint);
        chain.rotation = IDENTITY;
        chain.translation = [zero; 3];
    }

    fn push_body(&mut self, chain: &Chain, name: &str, joint: Joint) -> usize {
        let zero = self.model.graph.zero();
        self.model.tree.bodies.push(Body {
            name: name.to_string(),
            parent: Some(chain.parent),
            placement: Placement {
                rotation: chain.rotation,
                translation: chain.translation,
            },
            joint,
            inertia: Inertia {
                mass: zero,
                center: [zero; 3],
                tensor: [[zero; 3]; 3],
            },
        });
        self.model.tree.bodies.len() - 1
    }

    /// `ratio·q + offset` of one coordinate, if that is what it is.
    fn simple_coordinate(&mut self, by: ExprId) -> Option<Coordinate> {
        let graph = &mut self.model.graph;
        if graph.depends_on(&[by], self.model.time) {
            return None;
        }
        let coordinates = self.model.coordinates.iter().enumerate();
        let mut used = coordinates.filter(|(_, c)| graph.depends_on(&[by], c.position));
        let ((index, coordinate), None) = (used.next()?, used.next()) else {
            return None;
        };
        let (position, velocity) = (coordinate.position, coordinate.velocity);
        let slope = graph.derivatives(&[by], position)[0];
        let ratio = graph.as_constant(slope).filter(|&ratio| ratio != 0.0)?;
        let rate = graph.var(velocity);
        Some(Coordinate {
            q: by,
            v: graph.scale(ratio, rate),
            index,
            ratio,
        })
    }

    fn driven(&mut self, by: ExprId) -> Displacement {
        let seeds = self.model.time_seeds();
        let mut map = Vec::new();
        for index in 0..self.model.coordinates.len() {
            let displacement = self.model.displacement(index);
            let graph = &mut self.model.graph;
            let moved = |(symbol, _): &(SymbolId, ExprId)| graph.depends_on(&[by], *symbol);
            if displacement.iter().any(moved) {
                map.push((index, graph.directional(&[by], &displacement)[0]));
            }
        }
        let graph = &mut self.model.graph;
        let coefficients: Vec<ExprId> = map.iter().map(|entry| entry.1).collect();
        let rates = graph.directional(&coefficients, &seeds);
        let map_rate = map.iter().map(|entry| entry.0).zip(rates).collect();
        let rate = graph.directional(&[by], &seeds)[0];
        let drift = graph.directional(&[rate], &seeds)[0];
        Displacement {
            value: by,
            rate,
            map,
            map_rate,
            drift,
        }
    }

    /// `position(tip).x`, `velocity(tip).y`, `angular_velocity(tip).z`, `axis_z(tip).x`;
    /// the first and the last also as seen from a second frame.
    pub(super) fn lower_member(&mut self, inner: &Expr, member: &Name) -> Option<Quantity> {
        if let Some((name, place)) = self.lost_use(inner) {
            return self.unknown_use(&name, place);
        }
        let Some(component) = ["x", "y", "z"].iter().position(|&c| c == member.text) else {
            let message = format!("there is no component `.{}`", member.text);
            return self
                .report(Diagnostic::error(member.span, message).help("components are x, y and z"));
        };
        if let ExprKind::Name(name) = &inner.kind
            && name == "gravity"
        {
            return self.gravity_component(component, inner.span);
        }
        let ExprKind::Call(function, arguments) = &inner.kind else {
            let message = "only what is read off a frame or body has components";
            return self.report(Diagnostic::error(inner.span, message).help(VECTORS));
        };
        self.vector(function, arguments, inner.span)
            .and_then(|vector| vector(self, component))
    }

    /// What a vector function of the language stands for, component by component.
    pub(super) fn vector(
        &mut self,
        function: &Name,
        arguments: &[Expr],
        span: Span,
    ) -> Option<Component> {
        let mut frames = Vec::new();
        for argument in arguments {
            let ExprKind::Name(name) = &argument.kind else {
                if let Some((name, place)) = self.lost_use(argument) {
                    return self.unknown_use(&name, place);
                }
                let message = format!("`{}` takes the name of a frame or body", function.text);
                return self.report(Diagnostic::error(argument.span, message));
            };
            frames.push((name.clone(), argument.span));
        }
        let axis = match function.text.as_str() {
            "axis_x" => Some(0),
            "axis_y" => Some(1),
            "axis_z" => Some(2),
            "position" | "velocity" | "angular_velocity" | "center" => None,
            momentary if MOMENTARY_VECTORS.contains(&momentary) => {
                self.refuse_outside_sensors(function)?;
                None
            }
            _ => {
                let message = format!("`{}` has no components", function.text);
                return self.report(Diagnostic::error(function.span, message).help(VECTORS));
            }
        };
        let seen_from = matches!(function.text.as_str(), "position") || axis.is_some();
        if frames.is_empty() || frames.len() > if seen_from { 2 } else { 1 } {
            let message = format!(
                "`{}` takes one frame, found {}",
                function.text,
                frames.len()
            );
            return self.report(Diagnostic::error(span, message));
        }
        let known = |dimension| Measure::Known(dimension);
        if function.text == "center" {
            let body = self.find_body(&frames[0].0, frames[0].1)?;
            let center = self.model.tree.bodies[self.model.bodies[body].massive]
                .inertia
                .center;
            return Some(Box::new(move |_, i| {
                Some(Quantity {
                    expr: center[i],
                    measure: known(Dimension::LENGTH),
                })
            }));
        }
        let mut frame = self.find_frame(&frames[0].0, frames[0].1)?;
        if is_inertial(&function.text) {
            frame = self.board(frame, &frames[0].0);
        }
        if MOMENTARY_VECTORS.contains(&function.text.as_str()) {
            let function = function.text.clone();
            return Some(Box::new(move |builder: &mut Builder<'_>, i| {
                Some(builder.momentary_component(&function, frame, i))
            }));
        }
        let base = match frames.get(1) {
            Some((name, span)) => Some(self.find_frame(name, *span)?),
            None => None,
        };
        let (reading, dimension): (fn(usize, usize) -> super::Reading, Dimension) =
            match (function.text.as_str(), axis) {
                (_, Some(_)) => (super::Reading::Axis, Dimension::ONE),
                ("position", _) => (|_, i| super::Reading::Position(i), Dimension::LENGTH),
                ("velocity", _) => {
                    let speed = Dimension::LENGTH.rate();
                    (|_, i| super::Reading::Velocity(i), speed)
                }
                _ => {
                    let rate = Dimension::ANGLE.rate();
                    (|_, i| super::Reading::AngularVelocity(i), rate)
                }
            };
        let axis = axis.unwrap_or(0);
        Some(Box::new(move |builder: &mut Builder<'_>, i| {
            let model = &mut builder.model;
            let expr = match base {
                None => model.reading(frame, reading(axis, i)),
                // Rᵀ (p − p₀), or Rᵀ e
                Some(base) => {
                    let parts = [0, 1, 2].map(|k| {
                        let outer = model.reading(frame, reading(axis, k));
                        let along = model.reading(base, super::Reading::Axis(i, k));
                        let gap = match reading(axis, k) {
                            super::Reading::Position(_) => {
                                let origin = model.reading(base, super::Reading::Position(k));
                                model.graph.sub(outer, origin)
                            }
                            _ => outer,
                        };
                        model.graph.mul(along, gap)
                    });
                    model.graph.sum(parts)
                }
            };
            Some(Quantity {
                expr,
                measure: Measure::Known(dimension),
            })
        }))
    }

    /// The body of this name, directly or through a port.
    pub(super) fn find_body(&mut self, name: &str, span: Span) -> Option<usize> {
        if let Some(&(PortKind::Body, index)) = self.scope.ports.get(name) {
            return Some(index);
        }
        let mut bodies = self.model.bodies.iter();
        if let Some(index) = bodies.position(|body| body.name == name) {
            return Some(index);
        }
        let known: Vec<String> = self.model.bodies.iter().map(|b| b.name.clone()).collect();
        let name = Name {
            text: name.to_string(),
            span,
        };
        self.unknown_place(&name, "body", &known)
    }
}

/// A vector, component by component.
pub(super) type Component = Box<dyn Fn(&mut Builder<'_>, usize) -> Option<Quantity>>;

const VECTORS: &str = "vectors are position(frame), velocity(frame), angular_velocity(frame), \
    axis_x(frame), axis_y(frame), axis_z(frame) and center(body)";

impl Builder<'_> {
    /// Whether a coordinate drives a joint: bodies on it have kinetic energy.
    pub(super) fn moves_bodies(&self, coordinate: usize) -> bool {
        let is = |c: &Coordinate| c.index == coordinate;
        self.model.tree.bodies.iter().any(|body| match &body.joint {
            Joint::Fixed => false,
            Joint::Revolute { coordinate, .. } | Joint::Prismatic { coordinate, .. } => {
                is(coordinate)
            }
            Joint::Planar { coordinates, .. } => coordinates.iter().any(is),
            Joint::Ball(quaternion) => quaternion.iter().any(is),
            Joint::Floating(joint) => joint.position.iter().chain(&joint.quaternion).any(is),
            Joint::Free(free) => free.indices.contains(&coordinate),
            Joint::Driven { displacement, .. } => {
                displacement.map.iter().any(|entry| entry.0 == coordinate)
            }
        })
    }
}
