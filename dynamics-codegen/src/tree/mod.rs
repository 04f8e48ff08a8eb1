//! Equations of motion of trees of rigid bodies, derived by structure.
//!
//! ```text
//! Tree ──Mechanism::new──▶ links ──recursions──▶ M, Q_C, ∂…, frames, energies
//!        (fixed joints merged, frames chosen,    (composite rigid body,
//!         inertias regrouped)                     Newton–Euler, LᵀDL)
//! ```
//!
//! All recursions run in link frames, on graph nodes: calling one twice gives
//! the same nodes, so functions that share work share it in the graph.
//!
//! Conventions: `M a = Q_C + Q` with `Q_C = −(C v + g)`. A floating body has
//! seven coordinates, position then unit quaternion `x, y, z, w`, with their time
//! derivatives as velocities ([`Floating`]), or six velocities, its twist in its
//! own frame ([`Free`]).
//!
//! A pendulum: one body on a revolute joint about y, hanging along −z.
//!
//! ```
//! use dynamics_codegen::graph::Graph;
//! use dynamics_codegen::tree::{
//!     Body, Coordinate, Inertia, Joint, Mechanism, Options, Placement, Tree,
//! };
//!
//! let mut g = Graph::new();
//! let (q, v) = (g.symbol("q"), g.symbol("v"));
//! let coordinate = Coordinate { q: g.var(q), v: g.var(v), index: 0, ratio: 1.0 };
//! let zero = g.zero();
//! let bob = Body {
//!     name: "bob".to_owned(),
//!     parent: None,
//!     placement: Placement {
//!         rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//!         translation: [zero; 3],
//!     },
//!     joint: Joint::Revolute { axis: [0.0, 1.0, 0.0], coordinate },
//!     inertia: Inertia {
//!         mass: g.constant(2.0),
//!         center: [zero, zero, g.constant(-0.5)],
//!         tensor: [[zero; 3]; 3],
//!     },
//! };
//! let gravity = [zero, zero, g.constant(-9.81)];
//! let tree = Tree { bodies: vec![bob], gravity, coordinates: 1 };
//! let pendulum = Mechanism::new(&mut g, &tree, Options::default())?;
//!
//! let inertia = pendulum.mass_matrix(&mut g)[0][0]; // m l² = 0.5 kg·m²
//! assert_eq!(g.as_constant(inertia), Some(0.5));
//! let force = pendulum.bias_force(&mut g)[0]; // −m g l sin q
//! let value = g.evaluate(&[force], &[0.3, 1.0])[0];
//! assert!((value + 9.81 * 0.3_f64.sin()).abs() < 1e-12);
//! # Ok::<(), dynamics_codegen::tree::TreeError>(())
//! ```

mod articulated;
mod check;
mod composite;
mod energy;
mod error;
mod frames;
mod inertia;
mod kinematics;
mod link;
mod lumped;
mod mechanism;
mod message;
mod newton_euler;
mod placement;
mod regroup;
mod second;
mod sensitivity;
mod solve;
mod space;
mod turn;
mod upright;
mod vector;

pub use error::TreeError;
pub use kinematics::{Frame, Pose};
pub use mechanism::{Layout, Mechanism, Options, Regrouped, Report, Snapped};
pub use placement::pose_rates;
pub(crate) use placement::twist_of;
pub use sensitivity::{ForwardDerivatives, InverseDerivatives};
pub use solve::{Constrained, Factor};

use crate::graph::ExprId;

/// A tree of rigid bodies under gravity.
#[derive(Debug, Clone)]
pub struct Tree {
    /// The bodies, parents before children.
    pub bodies: Vec<Body>,
    /// Gravitational acceleration in the world frame, m/s².
    pub gravity: [ExprId; 3],
    /// How many generalised coordinates there are.
    pub coordinates: usize,
}

/// A rigid body, with the joint that carries it.
#[derive(Debug, Clone)]
pub struct Body {
    /// Its name, for messages.
    pub name: String,
    /// The index of the body that the joint is attached to; `None` is the world.
    pub parent: Option<usize>,
    /// Where the joint sits in the parent's frame.
    pub placement: Placement,
    /// How the body moves in the joint's frame. At zero displacement the body's
    /// frame is the joint's frame.
    pub joint: Joint,
    /// Its mass distribution.
    pub inertia: Inertia,
}

/// A pose in another frame: `x_outer = rotation · x_inner + translation`.
#[derive(Debug, Clone, Copy)]
pub struct Placement {
    /// Row by row, orthonormal with determinant one.
    pub rotation: [[f64; 3]; 3],
    /// In metres, in the outer frame.
    pub translation: [ExprId; 3],
}

/// Mass distribution of a body, in its own frame.
#[derive(Debug, Clone, Copy)]
pub struct Inertia {
    /// Mass, kg.
    pub mass: ExprId,
    /// Centre of mass, m.
    pub center: [ExprId; 3],
    /// Inertia tensor about the centre of mass, kg·m², axes of the body's
    /// frame. Only the upper triangle is read.
    pub tensor: [[ExprId; 3]; 3],
}

/// A displacement with its rate and the generalised coordinate behind it.
#[derive(Debug, Clone, Copy)]
pub struct Coordinate {
    /// The joint's displacement (rad or m); for a coupled (mimic) joint an
    /// expression of another joint's coordinate.
    pub q: ExprId,
    /// Its time derivative.
    pub v: ExprId,
    /// Which generalised coordinate drives it, below [`Tree::coordinates`].
    pub index: usize,
    /// Displacement per unit of that coordinate: 1, or a mimic joint's multiplier.
    pub ratio: f64,
}

/// A displacement along which anything may drive a body: several coordinates, a
/// nonlinear law, time, or a parameter that turns a frame.
#[derive(Debug, Clone)]
pub struct Displacement {
    /// `s(q, t)`, rad or m.
    pub value: ExprId,
    /// `ṡ`
    pub rate: ExprId,
    /// `∂s/∂q` as pairs of index and coefficient.
    pub map: Vec<(usize, ExprId)>,
    /// The rates of these coefficients along the motion.
    pub map_rate: Vec<(usize, ExprId)>,
    /// `s̈` at `a = 0`.
    pub drift: ExprId,
}

/// How a body moves in its joint's frame.
#[derive(Debug, Clone)]
pub enum Joint {
    /// Not at all.
    Fixed,
    /// By an angle about `axis` (any length but zero).
    Revolute {
        /// In the joint's frame.
        axis: [f64; 3],
        /// The angle, rad.
        coordinate: Coordinate,
    },
    /// By a distance along `axis` (any length but zero).
    Prismatic {
        /// In the joint's frame.
        axis: [f64; 3],
        /// The distance, m.
        coordinate: Coordinate,
    },
    /// In the plane through the joint's origin normal to `normal`.
    Planar {
        /// In the joint's frame.
        normal: [f64; 3],
        /// Along the two directions that complete `normal` to a right-handed
        /// frame (for `z` these are `x` and `y`), then the angle about it.
        coordinates: [Coordinate; 3],
    },
    /// About a point, by a unit quaternion `x, y, z, w` and its rates, as a [`Floating`] body turns.
    Ball([Coordinate; 4]),
    /// Freely, by seven coordinates and their rates.
    Floating(Floating),
    /// Freely, by a twist in the body's own frame.
    Free(Free),
    /// About or along `axis`, driven by an expression.
    Driven {
        /// In the joint's frame (any length but zero).
        axis: [f64; 3],
        /// Whether it turns; else it slides.
        turns: bool,
        /// By how much.
        displacement: Box<Displacement>,
    },
}

/// A free body: position of its origin in the joint's frame, then a unit
/// quaternion `x, y, z, w` for its orientation.
///
/// The velocities are the time derivatives of these seven numbers. The
/// quaternion `η` obeys `ηᵀη = 1`, so the accelerations obey `ηᵀη̈ = −η̇ᵀη̇`:
/// one constraint row, never singular. The body's angular velocity is
/// `ω = 2 E(η) η̇`, and `ω̇ = 2 E(η) η̈`.
///
/// Along `η` itself the kinetic energy says nothing; the mass matrix gets
/// `κ η ηᵀ` there (κ = 4 times the mean moment of inertia of all that is
/// rigidly attached), which makes it positive definite and changes nothing but
/// the multiplier of the unit constraint. Forward dynamics does not need it:
/// it solves for `ω̇` and maps back.
#[derive(Debug, Clone, Copy)]
pub struct Floating {
    /// Position.
    pub position: [Coordinate; 3],
    /// Quaternion `x, y, z, w`.
    pub quaternion: [Coordinate; 4],
}

/// A free body whose velocities are its twist: linear velocity of its origin, then angular
/// velocity, both in the body's own frame (Pinocchio's convention).
///
/// With the pose `(p, η)` in the joint's frame, `R = R(η)` and the twist `(v, ω)`:
/// `ṗ = R v` and `η̇ = ½ η ⊗ (ω, 0)`. The accelerations are `v̇` and `ω̇`, the forces a force
/// and a moment about the origin, in the body's frame. Derivatives by position are along the
/// tangent: by a small twist of the displaced body, at the same velocities.
#[derive(Debug, Clone, Copy)]
pub struct Free {
    /// Position of the body's origin, m.
    pub position: [ExprId; 3],
    /// Unit quaternion `x, y, z, w`.
    pub quaternion: [ExprId; 4],
    /// The twist `v, ω`, m/s and rad/s.
    pub twist: [ExprId; 6],
    /// Which generalised velocities these are, each below [`Tree::coordinates`].
    pub indices: [usize; 6],
}
