//! Joints that stand still: their bodies are welded where they are.

use super::body::{Joint, JointKind, Robot};
use super::spatial::{Placement, rotation_about};
use super::text::{shown, suggest};
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// A joint that does not move.
#[derive(Debug, Clone, PartialEq)]
pub struct Lock {
    /// The joint's name.
    pub joint: String,
    /// Where it stands, rad or m.
    pub at: f64,
    /// Where that is said.
    pub span: Span,
}

/// Makes joints of one freedom fixed ones, with those that follow them; a planar or floating one
/// stays where the file puts it. What cannot be locked is reported.
pub(crate) fn lock(robot: &mut Robot, locks: &[Lock], findings: &mut Vec<Diagnostic>) {
    for (index, lock) in locks.iter().enumerate() {
        let name = shown(&lock.joint);
        if let Some(first) = locks[..index].iter().find(|l| l.joint == lock.joint) {
            let error = Diagnostic::error(lock.span, format!("`{name}` is locked twice"));
            findings.push(error.also(first.span, "the first time"));
            continue;
        }
        let Some(body) = robot.joint(&lock.joint) else {
            findings.push(unknown(robot, lock));
            continue;
        };
        let Some(joint) = &mut robot.bodies[body].joint else {
            continue;
        };
        if let Some(error) = refused(joint, lock) {
            findings.push(error);
            continue;
        }
        weld(joint, lock.at);
        for joint in robot.bodies.iter_mut().filter_map(|b| b.joint.as_mut()) {
            if let Some(mimic) = joint.mimic.filter(|mimic| mimic.source == body) {
                joint.mimic = None;
                weld(joint, mimic.multiplier * lock.at + mimic.offset);
            }
        }
    }
}

/// What is wrong with locking a joint.
fn refused(joint: &Joint, lock: &Lock) -> Option<Diagnostic> {
    let name = shown(&lock.joint);
    let error = |message: String| Diagnostic::error(lock.span, message);
    if joint.mimic.is_some() {
        let error = error(format!("`{name}` follows another joint"));
        return Some(error.help("lock the joint that it follows: it stands still with that one"));
    }
    match joint.kind {
        JointKind::Fixed => Some(error(format!("`{name}` does not move: it is fixed"))),
        JointKind::Planar { .. } | JointKind::Ball | JointKind::Floating { .. }
            if lock.at != 0.0 =>
        {
            let error = error(format!("`{name}` has no single position to be locked at"));
            Some(error.help("leave out the number: it stays where the description puts it"))
        }
        _ => None,
    }
}

fn unknown(robot: &Robot, lock: &Lock) -> Diagnostic {
    let name = shown(&lock.joint);
    let message = format!("the robot has no joint named `{name}`");
    let joints = robot.bodies.iter().filter_map(|body| body.joint.as_ref());
    let known = joints.map(|joint| joint.name.as_str());
    let error = Diagnostic::error(lock.span, message);
    match suggest(&lock.joint, known) {
        Some(near) => error.help(format!("did you mean `{}`?", shown(near))),
        None => error,
    }
}

/// Fixes a joint at a position.
fn weld(joint: &mut Joint, at: f64) {
    let mut inner = Placement::IDENTITY;
    match joint.kind {
        JointKind::Revolute { axis } if at != 0.0 => inner.rotation = rotation_about(axis, at),
        JointKind::Prismatic { axis } => inner.translation = axis.map(|x| at * x),
        JointKind::Floating { home } => inner = home,
        _ => {}
    }
    joint.placement = joint.placement.then(&inner);
    joint.kind = JointKind::Fixed;
}
