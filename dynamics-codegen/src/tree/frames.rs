//! The choice of link frames.
//!
//! A revolute link's frame turns about its own z axis; free are its zero angle
//! and where on the axis its origin sits. The zero angle is chosen such that
//! the first child's axis lies in the y–z plane, so that the constant rotation
//! to the child is one turn about x; the offset is added to the joint's angle.
//! A prismatic link's frame is parallel to its parent's and coincides with it
//! at zero displacement: no rotation at all.

use super::mechanism::Layout;
use super::placement::{Motion, MovingJoint, basis_with_z};
use super::turn;
use super::vector::{self, IDENTITY, Rotation};
use crate::graph::Graph;

/// Below this sine two axes count as parallel: their common normal is too far
/// away to be a good place for an origin.
const PARALLEL: f64 = 1e-6;

/// A link frame, seen from the frame of the description.
#[derive(Debug, Clone)]
pub(super) struct LinkFrame {
    pub rotation: Rotation,
    pub origin: [f64; 3],
    /// Constant rotation from the parent's link frame, as turns about z and x.
    pub turns: [(f64, f64); 2],
    /// Cosine and sine of what is added to the joint's angle; where the joint has none,
    /// of a third constant turn, about z.
    pub offset: (f64, f64),
}

/// Chooses a frame per joint, parents before children.
pub(super) fn choose(g: &Graph, joints: &[MovingJoint], layout: Layout) -> Vec<LinkFrame> {
    let children = first_children(joints);
    let mut frames: Vec<LinkFrame> = Vec::with_capacity(joints.len());
    for (i, joint) in joints.iter().enumerate() {
        let parent = joint.parent.map(|p| &frames[p]);
        let mut frame = orient(g, joints, joint, parent, children[i]);
        if layout != Layout::AsGiven {
            let parent = joint.parent.map(|p| (&joints[p], &frames[p]));
            let child = children[i].map(|c| &joints[c]);
            frame.origin = place(g, joint, parent, child, layout);
        }
        frames.push(frame);
    }
    frames
}

/// Per joint the child that carries most joints; the first of equals.
fn first_children(joints: &[MovingJoint]) -> Vec<Option<usize>> {
    let mut weights = vec![1_usize; joints.len()];
    let mut children = vec![None; joints.len()];
    for i in (0..joints.len()).rev() {
        if let Some(parent) = joints[i].parent {
            weights[parent] += weights[i];
            let heaviest: &mut Option<usize> = &mut children[parent];
            // Visited from the back: equals are replaced by earlier ones.
            if heaviest.is_none_or(|c| weights[i] >= weights[c]) {
                *heaviest = Some(i);
            }
        }
    }
    children
}

fn orient(
    g: &Graph,
    joints: &[MovingJoint],
    joint: &MovingJoint,
    parent: Option<&LinkFrame>,
    child: Option<usize>,
) -> LinkFrame {
    let from_parent =
        parent.map(|p| vector::product(&vector::transpose(&p.rotation), &joint.rotation));
    let still = |rotation, turns| LinkFrame {
        rotation,
        origin: [0.0; 3],
        turns,
        offset: (1.0, 0.0),
    };
    const NO_TURNS: [(f64, f64); 2] = [(1.0, 0.0); 2];
    match joint.motion {
        Motion::Prismatic { .. } => match from_parent {
            Some(c) => still(vector::transpose(&c), NO_TURNS),
            None => still(IDENTITY, NO_TURNS),
        },
        Motion::Spherical { .. } | Motion::Free { .. } => match from_parent {
            // The quaternion's rotation is relative to the joint's frame: the
            // constant rotation stays in front of it.
            Some(c) => {
                let [gamma, alpha, psi] = turn::euler_zxz(&c);
                LinkFrame {
                    offset: psi,
                    ..still(IDENTITY, [gamma, alpha])
                }
            }
            None => still(IDENTITY, NO_TURNS),
        },
        Motion::Revolute { axis, .. } => {
            let basis = basis_with_z(axis);
            let [gamma, alpha, psi] = match from_parent {
                Some(c) => turn::euler_zxz(&vector::product(&c, &basis)),
                None => [(1.0, 0.0); 3],
            };
            let delta = zero_angle(g, &basis, child.map(|c| &joints[c]), psi);
            LinkFrame {
                rotation: vector::product(&basis, &about_z(delta)),
                origin: [0.0; 3],
                turns: [gamma, alpha],
                // A root's base frame turns along with it.
                offset: match from_parent {
                    Some(_) => turn::tidy_pair(turn::compose(psi, delta)),
                    None => (1.0, 0.0),
                },
            }
        }
    }
}

fn about_z((cos, sin): (f64, f64)) -> Rotation {
    [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]
}

/// The turn about z after which the child's axis lies in the y–z plane; if it
/// is parallel to z, after which the child lies on the x axis; failing that,
/// the turn that undoes `psi`.
fn zero_angle(
    g: &Graph,
    basis: &Rotation,
    child: Option<&MovingJoint>,
    psi: (f64, f64),
) -> (f64, f64) {
    let undo = (psi.0, -psi.1);
    let Some(child) = child else { return undo };
    let inward = vector::transpose(basis);
    let axis = match child.motion {
        Motion::Revolute { axis, .. } | Motion::Prismatic { axis, .. } => axis,
        Motion::Spherical { .. } | Motion::Free { .. } => return undo,
    };
    let u = vector::apply(&inward, vector::apply(&child.rotation, axis));
    let tilt = u[0].hypot(u[1]);
    let wanted = if tilt > PARALLEL {
        (u[1] / tilt, -u[0] / tilt)
    } else if let Some(p) = vector::as_numbers(g, child.translation) {
        let p = vector::apply(&inward, p);
        let distance = p[0].hypot(p[1]);
        if distance == 0.0 {
            return undo;
        }
        (p[0] / distance, p[1] / distance)
    } else {
        return undo;
    };
    let wanted = turn::tidy_pair(wanted);
    // Of the two opposite choices, the one nearer to no offset.
    if turn::compose(psi, wanted).0 < -1e-15 {
        (-wanted.0, -wanted.1)
    } else {
        wanted
    }
}

/// Where the link frame's origin sits, in the joint's frame.
fn place(
    g: &Graph,
    joint: &MovingJoint,
    parent: Option<(&MovingJoint, &LinkFrame)>,
    child: Option<&MovingJoint>,
    layout: Layout,
) -> [f64; 3] {
    const HERE: [f64; 3] = [0.0; 3];
    // Moving the origin of parameters costs operations on every call.
    let Some(p) = vector::as_numbers(g, joint.translation).filter(|_| joint.inertia.is_constant(g))
    else {
        return HERE;
    };
    let outward = parent.map(|(j, frame)| {
        let gap = [0, 1, 2].map(|k| p[k] - frame.origin[k]);
        let inward = vector::transpose(&joint.rotation);
        let direction = match j.motion {
            Motion::Revolute { axis, .. } => Some(vector::apply(&inward, axis)),
            _ => None,
        };
        (vector::apply(&inward, gap), direction)
    });
    match joint.motion {
        Motion::Spherical { .. } | Motion::Free { .. } => HERE,
        Motion::Prismatic { .. } => outward.map_or(HERE, |(gap, _)| gap.map(|x| -x)),
        Motion::Revolute { axis, .. } => {
            let to_child = || slide_to_child(g, axis, child);
            let to_parent =
                || outward.map(|(gap, direction)| slide_to_parent(axis, gap, direction));
            let slide = match layout {
                Layout::Proximal => to_child().or_else(to_parent),
                _ => to_parent().or_else(to_child),
            };
            axis.map(|x| slide.unwrap_or(0.0) * x)
        }
    }
}

/// How far along `axis` the point nearest to the child's axis is.
fn slide_to_child(g: &Graph, axis: [f64; 3], child: Option<&MovingJoint>) -> Option<f64> {
    let child = child?;
    let Motion::Revolute { axis: other, .. } = child.motion else {
        return None;
    };
    let p = vector::as_numbers(g, child.translation)?;
    let u = vector::apply(&child.rotation, other);
    let along = vector::inner(axis, u);
    let sine_squared = 1.0 - along * along;
    (sine_squared > PARALLEL * PARALLEL)
        .then(|| (vector::inner(axis, p) - along * vector::inner(u, p)) / sine_squared)
}

/// How far along `axis` the point nearest to the parent's axis is, or, for a
/// parent without one, nearest to its origin; for parallel axes, level with the
/// parent's origin. `gap` leads from there to here.
fn slide_to_parent(axis: [f64; 3], gap: [f64; 3], direction: Option<[f64; 3]>) -> f64 {
    let across = vector::inner(axis, gap);
    if let Some(a) = direction {
        let along = vector::inner(axis, a);
        let sine_squared = 1.0 - along * along;
        if sine_squared > PARALLEL * PARALLEL {
            return (along * vector::inner(a, gap) - across) / sine_squared;
        }
    }
    -across
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any rotation is the product of its three turns.
    #[test]
    fn euler_angles_give_the_rotation_back() {
        let turn_x = |a: f64| {
            [
                [1.0, 0.0, 0.0],
                [0.0, a.cos(), -a.sin()],
                [0.0, a.sin(), a.cos()],
            ]
        };
        for (gamma, alpha, psi) in [
            (0.3, 1.1, -2.0),
            (2.9, -0.4, 0.7),
            (0.0, 3.0, 1.0),
            (1.0, 0.0, 0.4),
        ] {
            let pair = |a: f64| (f64::cos(a), f64::sin(a));
            let c = vector::product(&about_z(pair(gamma)), &turn_x(alpha));
            let c = vector::product(&c, &about_z(pair(psi)));
            let [first, second, third] = turn::euler_zxz(&c);
            let back = vector::product(&about_z(first), &turn_x(second.1.atan2(second.0)));
            let back = vector::product(&back, &about_z(third));
            for (x, y) in c.iter().flatten().zip(back.iter().flatten()) {
                assert!((x - y).abs() < 1e-15, "{gamma} {alpha} {psi}: {x} {y}");
            }
            assert!(first.0 >= 0.0);
        }
    }
}
