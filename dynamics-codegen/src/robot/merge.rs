//! Welding what fixed joints connect.

use super::body::{Body, ClosureKind, Joint, JointKind, Robot};
use super::spatial::Placement;

/// The same robot with every link on a fixed joint welded to the body that
/// carries it: the root and the bodies that move remain, in the same order.
///
/// The inertias are added exactly ([`Inertia::plus`](super::Inertia::plus)),
/// the placements of joints multiplied. Nothing is lost: the link of a welded
/// body stays in [`Robot::frames`], with its placement on the body that now
/// carries it, so that a tool frame can still be asked for by name. Indices in
/// [`Joint::parent`] and [`Mimic::source`](super::Mimic::source) are those of
/// the new bodies.
///
/// Products of rotations are rounded as [`Robot::snapped`] says, and what that
/// moves is added there.
pub fn merge_fixed(robot: &Robot) -> Robot {
    let mut merged = Robot {
        bodies: Vec::new(),
        frames: Vec::new(),
        ..robot.clone()
    };
    // Where each old body went: the new body, and its frame there.
    let mut went: Vec<(usize, Placement)> = Vec::with_capacity(robot.bodies.len());
    for body in &robot.bodies {
        let target = place(body, &went, &mut merged);
        went.push(target);
    }
    for body in &mut merged.bodies {
        if let Some(mimic) = body.joint.as_mut().and_then(|joint| joint.mimic.as_mut()) {
            mimic.source = went[mimic.source].0;
        }
    }
    for actuator in &mut merged.actuators {
        actuator.body = went[actuator.body].0;
    }
    for closure in &mut merged.closures {
        match &mut closure.kind {
            ClosureKind::Points { bodies, points } => {
                for (body, point) in bodies.iter_mut().zip(points) {
                    let (carrier, placement) = &went[*body];
                    (*body, *point) = (*carrier, placement.point(*point));
                }
            }
            ClosureKind::Joints {
                follower, leader, ..
            } => {
                follower.0 = went[follower.0].0;
                if let Some(leader) = leader {
                    leader.0 = went[leader.0].0;
                }
            }
        }
    }
    for frame in &robot.frames {
        let (body, placement) = &went[frame.body];
        let mut frame = frame.clone();
        frame.body = *body;
        frame.placement = placement.then(&frame.placement);
        merged.snapped.rotation(&mut frame.placement.rotation);
        merged.frames.push(frame);
    }
    merged
}

/// Adds a body, as one of its own or to the one that carries it.
fn place(body: &Body, went: &[(usize, Placement)], merged: &mut Robot) -> (usize, Placement) {
    let own = merged.bodies.len();
    let Some(joint) = &body.joint else {
        merged.bodies.push(body.clone());
        return (own, Placement::IDENTITY);
    };
    let (carrier, outer) = went[joint.parent];
    let mut placement = outer.then(&joint.placement);
    merged.snapped.rotation(&mut placement.rotation);
    if joint.kind == JointKind::Fixed {
        let inertia = &mut merged.bodies[carrier].inertia;
        *inertia = inertia.plus(&body.inertia.placed(&placement));
        return (carrier, placement);
    }
    merged.bodies.push(Body {
        joint: Some(Joint {
            parent: carrier,
            placement,
            ..joint.clone()
        }),
        ..body.clone()
    });
    (own, Placement::IDENTITY)
}
