//! What floats in a robot description, by seven coordinates and their rates or by a twist, and what turns in a ball
//! joint.

use super::builder::Builder;
use super::configuration::{POSE, Pose, TWIST};
use super::lower::Lowered;
use super::names::Binding;
use super::quantity::{Measure, Quantity};
use super::robot::Assembly;
use super::{Constraint, ConstraintKind};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::SymbolId;
use crate::robot::{Joint, Losses};
use crate::source::Span;
use crate::syntax::Name;
use crate::tree;

impl Builder<'_> {
    /// What a name says of a body that floats by seven coordinates and their rates, as if it floated by its twist:
    /// `hull_wx`, its angular velocity along its own x axis.
    pub(super) fn component_of_twist(&mut self, name: &str) -> Lowered {
        let (of, ending) = name.rsplit_once('_')?;
        let component = TWIST.iter().position(|(c, _)| *c == ending)?;
        let coordinates = &self.model.coordinates;
        let names: Vec<String> = POSE.iter().map(|(c, _)| format!("{of}_{c}")).collect();
        let mut windows = coordinates.windows(names.len());
        let pose =
            windows.find(|window| window.iter().zip(&names).all(|(c, name)| c.name == *name))?;
        let symbols: Vec<[SymbolId; 2]> = pose.iter().map(|c| [c.position, c.velocity]).collect();
        let graph = &mut self.model.graph;
        let quaternion = [3, 4, 5, 6].map(|k| graph.var(symbols[k][0]));
        let position_rate = [0, 1, 2].map(|k| graph.var(symbols[k][1]));
        let quaternion_rate = [3, 4, 5, 6].map(|k| graph.var(symbols[k][1]));
        let twist = tree::twist_of(graph, quaternion, position_rate, quaternion_rate);
        Some(Quantity {
            expr: twist[component],
            measure: Measure::of(Dimension::of_unit(TWIST[component].1)).rate(),
        })
    }
}

impl Assembly<'_, '_> {
    /// A joint that is free, by its twist.
    fn free(&mut self, index: usize, name: &str, span: Span) -> tree::Joint {
        let twist =
            TWIST.map(|(c, unit)| self.coordinate(index, &format!("{name}_{c}"), unit, span));
        let model = &mut self.builder.model;
        let graph = &mut model.graph;
        let symbols = POSE.map(|(c, _)| graph.symbol(format!("q_{name}_{c}")));
        let [x, y, z, qx, qy, qz, qw] = symbols;
        let pose = Pose {
            name: name.to_string(),
            first: twist[0].index,
            position: [x, y, z],
            quaternion: [qx, qy, qz, qw],
        };
        let free = tree::Free {
            position: pose.position.map(|symbol| graph.var(symbol)),
            quaternion: pose.quaternion.map(|symbol| graph.var(symbol)),
            twist: twist.map(|c| c.v),
            indices: twist.map(|c| c.index),
        };
        let number = model.poses.len();
        model.poses.push(pose);
        for (entry, (c, _)) in POSE.iter().enumerate() {
            let name = Name {
                text: format!("{name}_{c}"),
                span,
            };
            self.builder.bind(&name, Binding::Pose(number, entry));
        }
        tree::Joint::Free(free)
    }

    /// The joint of a body that floats, as the options say.
    pub(super) fn floating(&mut self, index: usize, name: &str, span: Span) -> tree::Joint {
        if self.options.twist.is_some() {
            return self.free(index, name, span);
        }
        let position =
            ["x", "y", "z"].map(|c| self.coordinate(index, &format!("{name}_{c}"), "m", span));
        let quaternion = self.quaternion(index, name, span);
        tree::Joint::Floating(tree::Floating {
            position,
            quaternion,
        })
    }

    /// A ball joint. Along unit quaternions `|ω|² = 4 |η̇|²`, so that what resists or adds inertia by `ω` does so
    /// four times as strongly by each rate.
    pub(super) fn ball(&mut self, index: usize, joint: &Joint) -> tree::Joint {
        let quaternion = self.quaternion(index, &joint.name, joint.span);
        let acts = self.options.losses.includes(&joint.name);
        let dry = joint.losses.filter(|losses| losses.friction != 0.0);
        if let Some(losses) = dry.filter(|_| acts) {
            let message = format!(
                "the dry friction of the ball joint `{}` is ignored",
                joint.name
            );
            let warning = Diagnostic::warning(losses.span, message);
            self.builder
                .report::<()>(warning.label("its damping is read"));
        }
        let by_rate = Joint {
            losses: joint.losses.map(|losses| Losses {
                damping: 4.0 * losses.damping,
                friction: 0.0,
                ..losses
            }),
            armature: 4.0 * joint.armature,
            ..joint.clone()
        };
        for coordinate in &quaternion {
            self.losses(&by_rate, coordinate.index, None);
            self.energies(&by_rate, coordinate);
        }
        tree::Joint::Ball(quaternion)
    }

    /// A unit quaternion `x, y, z, w`, held at its length by a constraint.
    fn quaternion(&mut self, index: usize, name: &str, span: Span) -> [tree::Coordinate; 4] {
        let quaternion = ["qx", "qy", "qz", "qw"]
            .map(|c| self.coordinate(index, &format!("{name}_{c}"), "1", span));
        let graph = &mut self.builder.model.graph;
        let squares = quaternion.map(|c| graph.mul(c.q, c.q));
        let length = graph.sum(squares);
        let one = graph.one();
        let residual = graph.sub(length, one);
        // ½ (ηᵀη − 1): its row is ηᵀ.
        let residual = graph.scale(0.5, residual);
        let multiplier = self
            .builder
            .model
            .graph
            .symbol(format!("lambda_{name}_unit"));
        self.builder.model.constraints.push(Constraint {
            name: format!("{name}_unit"),
            multiplier,
            active: None,
            kind: ConstraintKind::Holonomic,
            time_dependent: false,
            residual,
            dimension: Some(Dimension::ONE),
            doc: "The orientation's quaternion has unit length.".to_string(),
        });
        quaternion
    }
}
