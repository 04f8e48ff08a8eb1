//! Unilateral contacts: points, spheres and discs that a plane pushes and never pulls.

mod lower;
mod touch;

use super::Model;
use crate::graph::ExprId;

/// A shape that may touch a plane.
#[derive(Debug, Clone)]
pub struct Contact {
    /// Its name.
    pub name: String,
    /// What touches.
    pub shape: Shape,
    /// What is touched.
    pub plane: Plane,
    /// From the origin of the shape's frame to its point nearest to the plane, along the world's
    /// axes.
    pub arm: [ExprId; 3],
    /// The distance of that point from the plane, m; below zero it is inside.
    pub gap: ExprId,
    /// How fast the shape moves against the plane there, m/s: along the plane's two axes, then
    /// along its normal.
    pub velocity: [ExprId; 3],
    /// Coefficient of Coulomb friction.
    pub friction: ExprId,
    /// Coefficient of restitution: how much of the approach comes back (Newton's law).
    pub restitution: ExprId,
    /// What the model says about it.
    pub doc: String,
}

/// What touches a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// The origin of a frame: index among the tree's bodies.
    Point {
        /// The frame.
        frame: usize,
    },
    /// A sphere about the origin of a frame.
    Sphere {
        /// The frame.
        frame: usize,
        /// Its radius, m.
        radius: ExprId,
    },
    /// The rim of a disc about the origin of a frame.
    Disc {
        /// The frame.
        frame: usize,
        /// Which of the frame's axes is the disc's.
        axis: usize,
        /// Its radius, m.
        radius: ExprId,
    },
}

/// The plane through the origin of a frame across one of its axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plane {
    /// The frame: index among the tree's bodies.
    pub frame: usize,
    /// Which of the frame's axes is the normal, towards the free side.
    pub normal: usize,
}

impl Shape {
    /// Its frame: index among the tree's bodies.
    pub fn frame(self) -> usize {
        let (Self::Point { frame } | Self::Sphere { frame, .. } | Self::Disc { frame, .. }) = self;
        frame
    }

    /// Its radius, m, if it has one.
    pub fn radius(self) -> Option<ExprId> {
        match self {
            Self::Point { .. } => None,
            Self::Sphere { radius, .. } | Self::Disc { radius, .. } => Some(radius),
        }
    }
}

impl Plane {
    /// The frame's axes in the order of a contact's components: two along the plane, then the
    /// normal; right-handed.
    pub fn axes(self) -> [usize; 3] {
        [1, 2, 0].map(|next| (self.normal + next) % 3)
    }
}

/// Letters of the axes, as in `plane_z`.
pub const AXES: [&str; 3] = ["x", "y", "z"];

impl Model {
    /// What a contact is between, as a model says it: `disc_y(wheel, r) on plane_z(world)`. `radius` is
    /// written if given. A product of transforms goes by the contact's name.
    pub fn between(&self, contact: &Contact, radius: Option<&str>) -> String {
        let name = |frame: usize| self.tree.bodies[frame].name.as_str();
        let function = match contact.shape {
            Shape::Point { .. } => "point".to_string(),
            Shape::Sphere { .. } => "sphere".to_string(),
            Shape::Disc { axis, .. } => format!("disc_{}", AXES[axis]),
        };
        let shape = name(contact.shape.frame());
        let radius = radius.map_or_else(String::new, |radius| format!(", {radius}"));
        let Plane { frame, normal } = contact.plane;
        let plane = format!("plane_{}({})", AXES[normal], name(frame));
        format!("{function}({shape}{radius}) on {plane}")
    }
}
