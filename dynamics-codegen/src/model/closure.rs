//! Equalities of a robot description as constraints.

use super::robot::Assembly;
use super::{Constraint, ConstraintKind, Reading};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::ExprId;
use crate::robot::{self, Closure, ClosureKind, Vector3};
use crate::tree;

impl Assembly<'_, '_> {
    /// The constraints of what the description says beside its tree.
    pub(super) fn close(&mut self) {
        let robot = self.robot;
        let mut pairs = Vec::new();
        for closure in &robot.closures {
            match closure.kind {
                ClosureKind::Points { bodies, points } => {
                    let pair = [0, 1].map(|k| self.point(closure, bodies[k], points[k]));
                    pairs.push((closure, pair));
                }
                ClosureKind::Joints {
                    follower,
                    leader,
                    polynomial,
                } => self.couple(closure, (follower, leader), polynomial),
            }
        }
        if pairs.is_empty() {
            return;
        }
        let pairs_of_frames: Vec<[usize; 2]> = pairs.iter().map(|(_, pair)| *pair).collect();
        let part = self.part(&pairs_of_frames);
        for ((closure, pair), part) in pairs.into_iter().zip(part) {
            for (i, axis) in ["x", "y", "z"]
                .into_iter()
                .enumerate()
                .filter(|&(i, _)| part[i])
            {
                let model = &mut self.builder.model;
                let places = pair.map(|frame| model.reading(frame, Reading::Position(i)));
                let gap = model.graph.sub(places[0], places[1]);
                let name = format!("{}_{axis}", closure.name);
                self.constrain(closure, name, gap, Some(Dimension::LENGTH));
            }
        }
    }

    /// Along which of the world's axes the motion can part two frames: those in one plane stay in it, and an equation
    /// that says so would be one too many.
    fn part(&mut self, pairs: &[[usize; 2]]) -> Vec<[bool; 3]> {
        let model = &mut self.builder.model;
        model.tree.coordinates = model.coordinates.len();
        let options = tree::Options {
            snap: None,
            ..tree::Options::default()
        };
        let is_read = |body: usize| pairs.iter().flatten().any(|&frame| frame == body);
        let graph = &mut model.graph;
        let Ok(mechanism) = tree::Mechanism::with_frames(graph, &model.tree, options, is_read)
        else {
            // What is wrong with the tree is said when it is whole.
            return vec![[true; 3]; pairs.len()];
        };
        let each = pairs.iter().map(|pair| {
            let places = pair.map(|frame| {
                let frame = tree::Frame::of_body(graph, frame);
                mechanism.pose(graph, &frame).position
            });
            [0, 1, 2].map(|i| {
                let gap = graph.sub(places[0][i], places[1][i]);
                let mut positions = model.coordinates.iter().map(|c| c.position);
                let poses = model.poses.iter();
                let mut of_poses =
                    poses.flat_map(|pose| pose.position.into_iter().chain(pose.quaternion));
                positions.any(|symbol| graph.depends_on(&[gap], symbol))
                    || of_poses.any(|symbol| graph.depends_on(&[gap], symbol))
            })
        });
        each.collect()
    }

    /// A frame at a point of a body.
    fn point(&mut self, closure: &Closure, body: usize, point: Vector3) -> usize {
        let model = &mut self.builder.model;
        let zero = model.graph.zero();
        model.tree.bodies.push(tree::Body {
            name: closure.name.clone(),
            parent: Some(self.frames[body]),
            placement: tree::Placement {
                rotation: robot::IDENTITY,
                translation: point.map(|x| model.graph.constant(x)),
            },
            joint: tree::Joint::Fixed,
            inertia: tree::Inertia {
                mass: zero,
                center: [zero; 3],
                tensor: [[zero; 3]; 3],
            },
        });
        model.tree.bodies.len() - 1
    }

    /// `q₁ − q₁₀ = Σ aₖ (q₂ − q₂₀)ᵏ` with the coordinates `q₁₀`, `q₂₀` as the description draws the joints.
    fn couple(
        &mut self,
        closure: &Closure,
        (follower, leader): ((usize, f64), Option<(usize, f64)>),
        polynomial: [f64; 5],
    ) {
        let joints = [Some(follower), leader].into_iter().flatten();
        let locked: Vec<usize> = joints
            .map(|(body, _)| body)
            .filter(|&body| self.coordinates[body].is_empty())
            .collect();
        if let Some(&body) = locked.first() {
            let joint = self.robot.bodies[body].joint.as_ref();
            let name = joint.map_or("", |joint| joint.name.as_str());
            let message = format!(
                "`{name}` is locked, and the equality `{}` moves it",
                closure.name
            );
            let error = Diagnostic::error(closure.span, message);
            let help =
                "leave equalities out, without `equalities: hold`, and lock what follows, too";
            self.builder.report::<()>(error.help(help));
            return;
        }
        let turned = |this: &mut Self, (body, drawn): (usize, f64)| -> ExprId {
            let model = &mut this.builder.model;
            let coordinate = &model.coordinates[this.coordinates[body][0]];
            let q = model.graph.var(coordinate.position);
            let drawn = model.graph.constant(drawn);
            model.graph.sub(q, drawn)
        };
        let led = leader.map(|leader| turned(self, leader));
        let own = turned(self, follower);
        let graph = &mut self.builder.model.graph;
        // Horner's scheme.
        let mut value = graph.zero();
        for &coefficient in polynomial.iter().rev() {
            let constant = graph.constant(coefficient);
            value = match led {
                Some(led) => {
                    let product = graph.mul(value, led);
                    graph.add(product, constant)
                }
                None => constant,
            };
        }
        let gap = graph.sub(own, value);
        let coordinate = self.coordinates[follower.0][0];
        let dimension = self.builder.model.coordinates[coordinate].dimension;
        self.constrain(closure, closure.name.clone(), gap, dimension);
    }

    fn constrain(
        &mut self,
        closure: &Closure,
        name: String,
        residual: ExprId,
        dimension: Option<Dimension>,
    ) {
        if self.builder.check_constraint(&name, closure.span).is_none() {
            return;
        }
        let model = &mut self.builder.model;
        let multiplier = model.graph.symbol(format!("lambda_{name}"));
        model.constraints.push(Constraint {
            name,
            multiplier,
            active: None,
            kind: ConstraintKind::Holonomic,
            time_dependent: false,
            residual,
            dimension,
            doc: format!("The equality `{}` of the description.", closure.name),
        });
    }
}
