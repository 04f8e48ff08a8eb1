//! The arm of thesis 5.3: iiwa on a base, tool tip on a plane, viscous friction at
//! the tip. All terms come from `models/iiwa7.urdf` by the recursions of
//! `dynamics-codegen`, on a tape.

use crate::Failure;
use dynamics::nalgebra::{SMatrix, SVector};
use dynamics::{Constraint, Equation, Point, System};
use dynamics_codegen::graph::{Graph, SymbolId};
use dynamics_codegen::robot::{JointKind, Placement as Pose, Robot};
use dynamics_codegen::source::Sources;
use dynamics_codegen::tape::Tape;
use dynamics_codegen::tree::{
    Body, Coordinate, Frame, Inertia, Joint, Mechanism, Options, Placement, Tree,
};
use dynamics_codegen::urdf;

/// Joints.
pub const N: usize = 7;
/// Height of the arm's foot, m.
const FOOT: f64 = 0.05;
/// From the frame of the last link to the tip along its axis, m.
const TOOL: f64 = 0.1;
/// Height of the plane, m.
pub const PLANE: f64 = 0.055;
/// Gravity, m/s².
const GRAVITY: f64 = 9.8;
/// Viscous friction of every joint, known to all models, N·m·s/rad.
pub const DAMPING: f64 = 0.5;
/// Viscous friction of the tip on the plane, known to no model, N·s/m.
pub const FRICTION: f64 = 1.0;
/// Moments of inertia of the last link with its tool about its centre of gravity, kg·m².
const END_INERTIA: [f64; 3] = [0.005, 0.0036, 0.0047];
/// Mass (kg) and centre of gravity (m) of the last link with its tool.
pub const TRUE_END: [f64; 4] = [2.0, 0.0, 0.0, -0.02];

pub type Vector = SVector<f64, N>;
pub type State = Point<f64, N, N, 0>;

/// Everything the recursions say at one state.
pub struct Terms {
    pub mass: SMatrix<f64, N, N>,
    /// `Q_C`, N·m.
    pub bias: Vector,
    /// Of the tip, m.
    pub position: SVector<f64, 3>,
    /// Columns are the axes of the last link in the world.
    pub rotation: SMatrix<f64, 3, 3>,
    /// Linear rows, then angular ones.
    pub jacobian: SMatrix<f64, 6, N>,
    /// `J̇ v`.
    pub drift: SVector<f64, 6>,
}

/// Derivatives of `M` (row-major) and `Q_C` in mass or centre of gravity of the last link.
pub struct Slope {
    pub mass: Vec<f64>,
    pub bias: Vec<f64>,
}

/// The arm with given parameters of its last link.
#[derive(Clone)]
pub struct Arm {
    terms: Tape,
    slopes: Tape,
    /// Mass and centre of gravity of the last link.
    pub end: [f64; 4],
    /// Friction of the tip, N·s/m.
    pub friction: f64,
}

/// The tree of the arm, with symbols for the last link.
fn tree(g: &mut Graph, robot: &Robot, q: &[SymbolId], v: &[SymbolId], end: &[SymbolId]) -> Tree {
    let mut index = 0;
    let mut bodies = Vec::new();
    for body in &robot.bodies {
        let mut inertia = Inertia {
            mass: g.constant(body.inertia.mass),
            center: body.inertia.center.map(|c| g.constant(c)),
            tensor: body.inertia.tensor.map(|row| row.map(|x| g.constant(x))),
        };
        let (parent, placement, joint) = match &body.joint {
            None => (None, Pose::IDENTITY, Joint::Fixed),
            Some(joint) => {
                let motion = match joint.kind {
                    JointKind::Revolute { axis } => {
                        let (q, v) = (g.var(q[index]), g.var(v[index]));
                        let ratio = 1.0;
                        let coordinate = Coordinate { q, v, index, ratio };
                        index += 1;
                        Joint::Revolute { axis, coordinate }
                    }
                    _ => Joint::Fixed,
                };
                (Some(joint.parent), joint.placement, motion)
            }
        };
        let mut translation = placement.translation;
        if parent.is_none() {
            translation[2] += FOOT;
        }
        if index == N {
            let zero = g.zero();
            inertia.mass = g.var(end[0]);
            inertia.center = [1, 2, 3].map(|i| g.var(end[i]));
            inertia.tensor = [[zero; 3]; 3];
            for (i, moment) in END_INERTIA.into_iter().enumerate() {
                inertia.tensor[i][i] = g.constant(moment);
            }
        }
        bodies.push(Body {
            name: body.link.clone(),
            parent,
            placement: Placement {
                rotation: placement.rotation,
                translation: translation.map(|x| g.constant(x)),
            },
            joint,
            inertia,
        });
    }
    Tree {
        bodies,
        gravity: [0.0, 0.0, -GRAVITY].map(|x| g.constant(x)),
        coordinates: index,
    }
}

impl Arm {
    /// The true arm.
    pub fn new() -> Result<Self, Failure> {
        let mut sources = Sources::new();
        let text = include_str!("../../../models/iiwa7.urdf");
        let id = sources.add("models/iiwa7.urdf", text);
        let robot = urdf::read(&sources, id, &mut Vec::new()).ok_or("the URDF is faulty")?;
        let mut g = Graph::new();
        let mut symbols = |kind: &str, count: usize| -> Vec<SymbolId> {
            (0..count).map(|i| g.symbol(format!("{kind}{i}"))).collect()
        };
        let (q, v, end) = (symbols("q", N), symbols("v", N), symbols("end", 4));
        let tree = tree(&mut g, &robot, &q, &v, &end);
        if tree.coordinates != N {
            return Err(format!("expected {N} joints, found {}", tree.coordinates).into());
        }
        let mechanism = Mechanism::new(&mut g, &tree, Options::default())?;
        let mut tip = Frame::of_body(&mut g, tree.bodies.len() - 1);
        tip.translation[2] = g.constant(TOOL);
        let mut forces = mechanism.mass_matrix(&mut g).concat();
        forces.extend(mechanism.bias_force(&mut g));
        let mut outputs = forces.clone();
        let pose = mechanism.pose(&mut g, &tip);
        outputs.extend(pose.position);
        outputs.extend(pose.rotation.as_flattened());
        outputs.extend(mechanism.jacobian(&mut g, &tip).concat());
        outputs.extend(mechanism.jacobian_rate_times_velocity(&mut g, &tip));
        let slopes: Vec<_> = end
            .iter()
            .flat_map(|&s| g.derivatives(&forces, s))
            .collect();
        let inputs = [q, v, end].concat();
        Ok(Self {
            terms: Tape::new(&g, &outputs, &inputs),
            slopes: Tape::new(&g, &slopes, &inputs),
            end: TRUE_END,
            friction: FRICTION,
        })
    }

    /// The same arm with another last link, and without friction at the tip.
    pub fn known(&self, end: [f64; 4]) -> Self {
        Self {
            end,
            friction: 0.0,
            ..self.clone()
        }
    }

    fn inputs(&self, x: &State) -> Vec<f64> {
        [&x.q[..], &x.v, &self.end].concat()
    }

    /// All terms at a state.
    pub fn terms(&self, x: &State) -> Terms {
        let out = self.terms.evaluate(&self.inputs(x));
        let (mass, rest) = out.split_at(N * N);
        let (bias, rest) = rest.split_at(N);
        let (position, rest) = rest.split_at(3);
        let (rotation, rest) = rest.split_at(9);
        let (jacobian, drift) = rest.split_at(6 * N);
        Terms {
            mass: SMatrix::from_row_slice(mass),
            bias: SVector::from_column_slice(bias),
            position: SVector::from_column_slice(position),
            rotation: SMatrix::from_row_slice(rotation),
            jacobian: SMatrix::from_row_slice(jacobian),
            drift: SVector::from_column_slice(drift),
        }
    }

    /// Derivatives in mass and centre of gravity of the last link.
    pub fn slopes(&self, x: &State) -> Vec<Slope> {
        let out = self.slopes.evaluate(&self.inputs(x));
        let each = out.chunks(N * N + N);
        each.map(|c| Slope {
            mass: c[..N * N].to_vec(),
            bias: c[N * N..].to_vec(),
        })
        .collect()
    }

    /// `Q_C + Q_u + Q_D`: what an analytical model without contact friction knows.
    pub fn known_force(&self, terms: &Terms, x: &State) -> Vector {
        terms.bias + Vector::from(x.u) - Vector::from(x.v) * DAMPING
    }
}

/// The contact: the tip keeps its height.
pub fn contact(terms: &Terms, x: &State) -> Constraint<f64, N, 1> {
    let row = terms.jacobian.row(2).into_owned();
    Constraint {
        a: row,
        b: SVector::from([-terms.drift[2]]),
        c: SVector::from([terms.position[2] - PLANE]),
        c_dot: row * Vector::from(x.v),
        holonomic: [true],
    }
}

impl System<f64, N, N, 1, 0> for Arm {
    fn mass_matrix(&self, x: &State) -> SMatrix<f64, N, N> {
        self.equation(x).mass_matrix
    }

    fn force(&self, x: &State) -> Vector {
        self.equation(x).force
    }

    fn constraint(&self, x: &State) -> Constraint<f64, N, 1> {
        self.equation(x).constraint
    }

    fn state_rate(&self, _: &State) -> [f64; 0] {
        []
    }

    fn equation(&self, x: &State) -> Equation<f64, N, 1> {
        let terms = self.terms(x);
        let linear = terms.jacobian.fixed_rows::<3>(0);
        let drag = linear.transpose() * (linear * Vector::from(x.v)) * self.friction;
        Equation {
            mass_matrix: terms.mass,
            force: self.known_force(&terms, x) - drag,
            constraint: contact(&terms, x),
        }
    }
}
