//! Whether every joint moves something.

use super::body::{Joint, JointKind, Robot};
use super::format::Format;
use super::merge::merge_fixed;
use super::spatial::{IDENTITY, Inertia, Matrix3, apply, dot};
use super::text::shown;
use crate::diagnostic::Diagnostic;

/// Every independent coordinate must move something.
pub(crate) fn check_mobility(robot: &Robot, findings: &mut Vec<Diagnostic>) {
    let merged = merge_fixed(robot);
    let bodies = &merged.bodies;
    let distal = distal(&merged);
    let mut moves: Vec<bool> = vec![false; bodies.len()];
    let mut carries: Vec<bool> = vec![false; bodies.len()];
    for (i, body) in bodies.iter().enumerate() {
        let Some(joint) = &body.joint else { continue };
        let leaf = distal[i].bodies == 1;
        let something = match joint.kind {
            JointKind::Fixed => true,
            JointKind::Prismatic { .. } | JointKind::Planar { .. } | JointKind::Floating { .. } => {
                distal[i].mass > 0.0
            }
            JointKind::Ball if leaf => {
                let axes = IDENTITY.iter();
                axes.map(|&axis| about(&body.inertia, axis))
                    .all(|inertia| inertia > 0.0)
            }
            JointKind::Revolute { axis } if leaf => about(&body.inertia, axis) > 0.0,
            JointKind::Ball | JointKind::Revolute { .. } => {
                distal[i].mass > 0.0 || distal[i].rotational
            }
        };
        // A joint that follows moves its inertia with the joint it follows.
        let coordinate = joint.mimic.filter(|m| m.multiplier != 0.0);
        let something = something || joint.armature > 0.0;
        moves[i] |= something;
        carries[i] |= distal[i].mass > 0.0;
        if let Some(mimic) = coordinate {
            moves[mimic.source] |= something;
            carries[mimic.source] |= distal[i].mass > 0.0;
        }
    }
    for ((body, moves), carries) in bodies.iter().zip(moves).zip(carries) {
        let Some(joint) = &body.joint else { continue };
        if joint.mimic.is_none() && !moves {
            findings.push(immobile(robot.format, joint, carries));
        }
    }
}

fn immobile(format: Format, joint: &Joint, carries: bool) -> Diagnostic {
    let span = joint.span;
    let lacks = match joint.kind {
        JointKind::Revolute { .. } => "inertia about its axis",
        JointKind::Ball => "inertia about every axis through its origin",
        _ => "mass",
    };
    let message = format!(
        "joint `{}` moves nothing that has {lacks}",
        shown(&joint.name)
    );
    if carries {
        // A design without the rotor: forces follow from motion, motion not from forces.
        return Diagnostic::warning(span, message)
            .label("its acceleration is undetermined")
            .help(format!(
                "give a {} beyond it its inertia, or add that of the rotor to the model: `effect armature(joint) {{ … }}`",
                format.body()
            ));
    }
    Diagnostic::error(span, message)
        .label("its acceleration would be undetermined")
        .help(format.mend_of_immobile())
}

/// What hangs on a joint.
#[derive(Debug, Clone, Copy)]
struct Distal {
    mass: f64,
    rotational: bool,
    bodies: usize,
}

/// Sums from the leaves to the root: children stand after their parents.
fn distal(robot: &Robot) -> Vec<Distal> {
    let mut sums: Vec<Distal> = robot
        .bodies
        .iter()
        .map(|body| Distal {
            mass: body.inertia.mass,
            rotational: body.inertia.tensor.iter().flatten().any(|&x| x != 0.0),
            bodies: 1,
        })
        .collect();
    for i in (0..sums.len()).rev() {
        if let Some(joint) = &robot.bodies[i].joint {
            let own = sums[i];
            let parent = &mut sums[joint.parent];
            parent.mass += own.mass;
            parent.rotational |= own.rotational;
            parent.bodies += own.bodies;
        }
    }
    sums
}

/// The moment of inertia about an axis through the origin, `aᵀ I a`.
fn about(inertia: &Inertia, axis: [f64; 3]) -> f64 {
    let tensor: Matrix3 = inertia.about_origin();
    dot(axis, apply(&tensor, axis))
}
