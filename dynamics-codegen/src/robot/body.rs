//! A robot as the derivation wants it: a tree of bodies, numbers only.

use super::format::Format;
use super::snap::Snapped;
use super::spatial::{Inertia, Placement, Vector3};
use crate::source::{SourceId, Span};

/// A robot read from a description.
///
/// **Order.** The bodies stand depth first: every parent before its children,
/// and the children of a link in the order in which the file states the joints
/// that lead to them. The body without a joint, the root, comes first: of an
/// MJCF it is the world. The order of the links in a URDF does not matter. The
/// descendants of body `i` are therefore one contiguous run that starts at
/// `i + 1`.
///
/// **Names.** A link that an MJCF does not have, between two joints of one body
/// or in an anchor that is not the body's origin, has the empty name, as has the
/// weld behind it: no file can name them.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// What the description is.
    pub format: Format,
    /// The name in `<robot name="…">` or `<mujoco model="…">`, exactly as written: it
    /// is not an identifier and must be mangled before it becomes one.
    pub name: String,
    /// The opening tag of `<robot>` or `<mujoco>`.
    pub span: Span,
    /// The bodies, parents before children.
    pub bodies: Vec<Body>,
    /// Every link of the file as a frame that rides on a body, in the order of
    /// the bodies as read. [`merge_fixed`](super::merge_fixed) keeps them all.
    pub frames: Vec<Frame>,
    /// What was rounded to 0 and ±1.
    pub snapped: Snapped,
    /// Gravitational acceleration in the root's axes, m/s², where the file states one.
    pub gravity: Option<Vector3>,
    /// What drives it, in the order of the file; empty if the file does not say.
    pub actuators: Vec<Actuator>,
    /// What holds beside the tree, in the order of the file.
    pub closures: Vec<Closure>,
    /// The files that it includes: their paths from its folder, and their texts.
    pub included: Vec<(String, SourceId)>,
}

/// What a description says of its motion beside the tree: a loop that is closed, or joints that go together.
#[derive(Debug, Clone, PartialEq)]
pub struct Closure {
    /// Its name, exactly as written or made up.
    pub name: String,
    /// Where it stands.
    pub span: Span,
    /// What holds.
    pub kind: ClosureKind,
}

/// What holds beside a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClosureKind {
    /// A point of one body is where one of another is.
    Points {
        /// The bodies.
        bodies: [usize; 2],
        /// The points, each in the axes of its body, m.
        points: [Vector3; 2],
    },
    /// A joint is where a polynomial of another says: `q₁ − q₁₀ = Σ aₖ (q₂ − q₂₀)ᵏ`.
    Joints {
        /// The body of the joint that follows, and its coordinate `q₁₀` as the file draws it, rad or m.
        follower: (usize, f64),
        /// The same of the joint that is followed; without one, the first is held at `a₀`.
        leader: Option<(usize, f64)>,
        /// The coefficients `a₀` to `a₄`, by rad or m.
        polynomial: [f64; 5],
    },
}

/// A rigid body: one link and the joint that carries it.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// The link's name, exactly as written.
    pub link: String,
    /// Where the link is named.
    pub span: Span,
    /// The joint that carries it; `None` for the root alone.
    pub joint: Option<Joint>,
    /// Mass, centre of mass, inertia tensor, in the axes of the link.
    pub inertia: Inertia,
    /// `<inertial>`, if the link has one.
    pub inertial: Option<Span>,
}

/// A joint: how a body moves on its parent.
///
/// At zero coordinates the link's frame stands at [`placement`](Self::placement)
/// in the parent link's frame; the joint moves it from there, expressed in the
/// link's own axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// The joint's name, exactly as written.
    pub name: String,
    /// Where the joint is named.
    pub span: Span,
    /// Index of the parent among [`Robot::bodies`]; smaller than the body's own.
    pub parent: usize,
    /// How it moves.
    pub kind: JointKind,
    /// The link's frame in the parent link's frame at zero coordinates.
    pub placement: Placement,
    /// Limits, if stated. They are no part of the dynamics.
    pub limits: Option<Limits>,
    /// Whether it follows another joint.
    pub mimic: Option<Mimic>,
    /// What the file says about losses. Kept as information; it is the model that
    /// decides whether they act.
    pub losses: Option<Losses>,
    /// Inertia of the drive's rotor as the joint feels it: kg·m², or kg.
    pub armature: f64,
    /// A spring in the joint.
    pub spring: Option<Spring>,
}

/// How a joint moves. Axes are unit vectors in the link's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// Not at all.
    Fixed,
    /// Rotation by `q` rad about the axis (`revolute`, and `continuous`, which
    /// has no position limit).
    Revolute {
        /// Unit vector.
        axis: Vector3,
    },
    /// Translation by `q` m along the axis.
    Prismatic {
        /// Unit vector.
        axis: Vector3,
    },
    /// Three rotations about the joint's origin.
    Ball,
    /// Three translations and three rotations.
    Floating {
        /// Where the link's frame stands in the joint's when nothing moves it.
        home: Placement,
    },
    /// Two translations in the plane perpendicular to the axis, and the
    /// rotation about it. [`plane_basis`] completes the axis.
    Planar {
        /// Unit normal of the plane.
        axis: Vector3,
    },
}

impl JointKind {
    /// How many velocities it has: 0, 1, 3 or 6.
    pub fn degrees_of_freedom(&self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute { .. } | Self::Prismatic { .. } => 1,
            Self::Planar { .. } | Self::Ball => 3,
            Self::Floating { .. } => 6,
        }
    }

    /// The axis, if the joint has one.
    pub fn axis(&self) -> Option<Vector3> {
        match *self {
            Self::Revolute { axis } | Self::Prismatic { axis } | Self::Planar { axis } => {
                Some(axis)
            }
            Self::Fixed | Self::Ball | Self::Floating { .. } => None,
        }
    }
}

/// Two unit vectors `e₁, e₂` that complete the unit normal `n` of a planar
/// joint to a right-handed frame `(e₁, e₂, n)`: `(x, y)` for `z`, `(y, z)` for
/// `x`, `(z, x)` for `y`. For a skew normal, `e₁` is the part perpendicular to
/// `n` of the coordinate axis that follows the one nearest to `n`.
pub fn plane_basis(normal: Vector3) -> (Vector3, Vector3) {
    let nearest = (1..3).fold(0, |best, i| {
        if normal[i].abs() > normal[best].abs() {
            i
        } else {
            best
        }
    });
    let next = (nearest + 1) % 3;
    let along = normal[next];
    let mut first = normal.map(|n| -along * n);
    first[next] += 1.0;
    let length = first.iter().map(|x| x * x).sum::<f64>().sqrt();
    let first = first.map(|x| x / length + 0.0);
    let [a, b, c] = normal;
    let [x, y, z] = first;
    (first, [b * z - c * y, c * x - a * z, a * y - b * x])
}

/// What `<limit>` states. Unstated is infinite, save that a revolute or
/// prismatic joint whose `<limit>` leaves out `lower` or `upper` has 0 there
/// (URDF before version 1.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Smallest coordinate in rad or m; `-∞` for a continuous joint.
    pub lower: f64,
    /// Largest coordinate in rad or m; `∞` for a continuous joint.
    pub upper: f64,
    /// Largest torque in N·m, or force in N.
    pub effort: f64,
    /// Largest speed in rad/s or m/s.
    pub velocity: f64,
    /// `<limit>`.
    pub span: Span,
}

/// A joint that follows: `q = multiplier·q_source + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mimic {
    /// Index of the body whose joint is followed. It never follows another
    /// itself: chains are resolved when the file is read.
    pub source: usize,
    /// Ratio of the coordinates.
    pub multiplier: f64,
    /// Coordinate at `q_source = 0`, in rad or m.
    pub offset: f64,
    /// `<mimic>`.
    pub span: Span,
}

/// What `<dynamics>` of a URDF or `<joint>` of an MJCF states; unstated is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Losses {
    /// Viscous: N·m·s/rad, or N·s/m.
    pub damping: f64,
    /// Coulomb: N·m, or N.
    pub friction: f64,
    /// The element.
    pub span: Span,
}

/// A spring in a joint: the torque or force `−stiffness (q − rest)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// N·m/rad, or N/m.
    pub stiffness: f64,
    /// The coordinate where it is slack, rad or m.
    pub rest: f64,
}

/// A drive that pulls at a joint: `gear u` with its own force `u`.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its name, exactly as written; that of the joint if it has none.
    pub name: String,
    /// Where it is stated.
    pub span: Span,
    /// Index of the body whose joint it drives.
    pub body: usize,
    /// The joint's torque or force by the drive's.
    pub gear: f64,
}

/// A link as a frame that rides on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The link's name, exactly as written.
    pub link: String,
    /// The joint that carries the link, `None` for the root.
    pub joint: Option<String>,
    /// Where the link is named.
    pub span: Span,
    /// Index of the body that it rides on.
    pub body: usize,
    /// The link's frame in the body's frame.
    pub placement: Placement,
}

impl Robot {
    /// The frame of a link, merged or not.
    pub fn frame(&self, link: &str) -> Option<&Frame> {
        self.frames.iter().find(|frame| frame.link == link)
    }

    /// The index of the body that a joint carries.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.bodies
            .iter()
            .position(|body| body.joint.as_ref().is_some_and(|joint| joint.name == name))
    }

    /// The number of independent velocities: all joints but those that mimic.
    pub fn degrees_of_freedom(&self) -> usize {
        self.bodies
            .iter()
            .filter_map(|body| body.joint.as_ref())
            .filter(|joint| joint.mimic.is_none())
            .map(|joint| joint.kind.degrees_of_freedom())
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_basis_is_right_handed() {
        let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(plane_basis(z), (x, y));
        assert_eq!(plane_basis(x), (y, z));
        assert_eq!(plane_basis(y), (z, x));
        let s = 1.0 / 3.0_f64.sqrt();
        let n = [s, -s, s];
        let (a, b) = plane_basis(n);
        let dot = super::super::spatial::dot;
        for (u, v, expected) in [
            (a, a, 1.0),
            (b, b, 1.0),
            (a, b, 0.0),
            (a, n, 0.0),
            (b, n, 0.0),
        ] {
            assert!((dot(u, v) - expected).abs() < 1e-15);
        }
        // a × b = n
        assert!((a[0] * b[1] - a[1] * b[0] - n[2]).abs() < 1e-15);
    }
}
