//! Links: the joints' transforms and inertias seen from the chosen frames.

use super::frames::LinkFrame;
use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Base, Link};
use super::placement::{Anchor, Motion, MovingJoint};
use super::turn::{self, Stage, Turn};
use super::upright::JointAngle;
use super::vector::{self, IDENTITY, Vector};
use crate::graph::{ExprId, Graph, Unary};

/// The links with their transforms; inertias seen from the link frames.
pub(super) fn links(
    g: &mut Graph,
    joints: &[MovingJoint],
    frames: &[LinkFrame],
    turn_matters: &[bool],
) -> Vec<Link> {
    (joints.iter().zip(frames).zip(turn_matters))
        .map(|((joint, frame), &turn_matters)| {
            let parent = joint.parent.map(|p| &frames[p]);
            link(g, joint, frame, parent, turn_matters)
        })
        .collect()
}

fn link(
    g: &mut Graph,
    joint: &MovingJoint,
    frame: &LinkFrame,
    parent: Option<&LinkFrame>,
    turn_matters: bool,
) -> Link {
    let (base, mut shift) = placed(g, joint, frame, parent);
    let mut stages: Vec<Stage> = Vec::new();
    if parent.is_some() {
        stages.extend(turn::constant_turn(g, 2, frame.turns[0]));
        stages.extend(turn::constant_turn(g, 0, frame.turns[1]));
        if let Motion::Spherical { .. } | Motion::Free { .. } = joint.motion {
            stages.extend(turn::constant_turn(g, 2, frame.offset));
        }
    }
    let constant_stages = stages.len();
    let mut freedoms = joint.freedoms.clone();
    let mut quaternion = None;
    let mut turns_by = None;
    let inertia = seen_from(g, frame, &joint.inertia);
    match joint.motion {
        // The frame need not turn with what looks the same from all sides.
        Motion::Revolute { .. } if !turn_matters && inertia.is_symmetric_about_z(g) => {
            let still = g.zero();
            stages.push(joint_turn(g, still, frame.offset));
        }
        Motion::Revolute { angle, .. } => {
            stages.push(joint_turn(g, angle, frame.offset));
            turns_by = Some(JointAngle {
                angle,
                offset: frame.offset,
            });
        }
        Motion::Spherical {
            rotation,
            quaternion: given,
        } => {
            stages.push(Stage::General(rotation));
            quaternion = Some(given);
        }
        Motion::Free { rotation, position } => {
            stages.push(Stage::General(rotation));
            // The position is seen from the joint's frame: the constant rotation in front
            // of it is the base's for a root, the constant stages' for any other.
            let constant = &stages[..constant_stages];
            let displacement = turn::up(g, constant, position);
            shift = vector::add(g, shift, displacement);
        }
        Motion::Prismatic { axis, distance } => {
            let axis = vector::apply(&vector::transpose(&frame.rotation), axis);
            freedoms[0].axis = Axis::Linear(axis);
            let axis = vector::constant(g, axis);
            let displacement = vector::scale(g, distance, axis);
            shift = vector::add(g, shift, displacement);
        }
    }
    Link {
        parent: joint.parent,
        stages,
        constant_stages,
        turns_by,
        shift,
        freedoms,
        inertia,
        driven: joint.driven,
        free: matches!(joint.motion, Motion::Free { .. }),
        base,
        spherical: quaternion.map(|q| q.map(|c| c.index)),
        quaternion: quaternion.map(|q| q.map(|c| c.q)),
        quaternion_rates: quaternion.map(|q| q.map(|c| c.v)),
    }
}

/// The frame that carries a root, and a link's constant shift in its parent's
/// frame. A root has none: its base frame takes in the constant transform.
fn placed(
    g: &mut Graph,
    joint: &MovingJoint,
    frame: &LinkFrame,
    parent: Option<&LinkFrame>,
) -> (Base, Vector) {
    let zero = vector::zero(g);
    let origin = vector::constant(g, vector::apply(&joint.rotation, frame.origin));
    let origin = vector::add(g, joint.translation, origin);
    let Some(parent) = parent else {
        let rotation = match joint.motion {
            Motion::Spherical { .. } | Motion::Free { .. } => joint.rotation,
            _ => vector::product(&joint.rotation, &frame.rotation),
        };
        let base = Base {
            rotation,
            translation: origin,
        };
        return (base, zero);
    };
    let lengths = [parent.origin, frame.origin];
    let there = vector::constant(g, parent.origin);
    let gap = vector::sub(g, origin, there);
    let gap = tidy(g, gap, &lengths);
    let gap = vector::rotate(g, &vector::transpose(&parent.rotation), gap);
    let base = Base {
        rotation: IDENTITY,
        translation: zero,
    };
    (base, tidy(g, gap, &lengths))
}

fn seen_from(g: &mut Graph, frame: &LinkFrame, inertia: &PseudoInertia) -> PseudoInertia {
    let back = vector::constant(g, frame.origin.map(|x| -x));
    let centred = inertia.shift(g, back);
    let turned = centred.rotate(g, &vector::transpose(&frame.rotation));
    let magnitude = inertia.magnitude(g);
    turned.tidy(g, magnitude)
}

/// The turn by `angle + offset`; offsets by quarter turns only exchange sine
/// and cosine.
pub(super) fn joint_turn(g: &mut Graph, angle: ExprId, (c, s): (f64, f64)) -> Stage {
    let quarter = c == 0.0 || s == 0.0;
    let angle = if quarter {
        angle
    } else {
        let offset = g.constant(s.atan2(c));
        g.add(angle, offset)
    };
    let (cos, sin) = (g.unary(Unary::Cos, angle), g.unary(Unary::Sin, angle));
    let (cos, sin) = if !quarter || c == 1.0 {
        (cos, sin)
    } else if c == -1.0 {
        (g.neg(cos), g.neg(sin))
    } else if s == 1.0 {
        (g.neg(sin), cos)
    } else {
        (sin, g.neg(cos))
    };
    Stage::Planar(Turn { axis: 2, cos, sin })
}

/// Removes what is round-off beside the lengths it was computed from.
fn tidy(g: &mut Graph, v: Vector, lengths: &[[f64; 3]]) -> Vector {
    let largest = (lengths.iter().flatten()).fold(0.0_f64, |l, x| l.max(x.abs()));
    let largest = v.iter().fold(largest, |l, &x| {
        l.max(g.as_constant(x).map_or(0.0, f64::abs))
    });
    v.map(|x| match g.as_constant(x) {
        Some(value) if value.abs() <= 8.0 * f64::EPSILON * largest => g.zero(),
        _ => x,
    })
}

/// Where the bodies sit in the chosen link frames.
pub(super) fn anchors(g: &mut Graph, anchors: &[Anchor], frames: &[LinkFrame]) -> Vec<Anchor> {
    (anchors.iter())
        .map(|anchor| {
            let Some(link) = anchor.link else {
                return *anchor;
            };
            let inward = vector::transpose(&frames[link].rotation);
            let origin = vector::constant(g, frames[link].origin);
            let gap = vector::sub(g, anchor.translation, origin);
            Anchor {
                link: anchor.link,
                rotation: vector::product(&inward, &anchor.rotation),
                translation: vector::rotate(g, &inward, gap),
            }
        })
        .collect()
}
