//! The checked model: names resolved, units checked, expressions on the graph.

mod bodies;
mod builder;
mod closure;
mod configuration;
mod constraint;
mod contact;
mod declare;
mod delay;
mod drive;
mod each;
mod effects;
mod energy;
mod finish;
mod floating;
mod fold;
mod force;
mod frame_names;
mod frames;
mod kinematic;
mod library;
mod lower;
mod measured;
mod mounted;
mod named;
mod names;
mod output;
mod parameter;
mod place;
mod quantity;
mod restated;
mod robot;
mod robot_drives;
mod robot_numbers;
mod robot_options;
mod sensed;
mod sensor;
mod set;
mod state;
mod switch;
mod table;
mod table_file;
mod template;
mod unilateral;
mod unit;
mod unknown;

pub use bodies::{NamedBody, PointForce};
pub(crate) use builder::build;
pub use configuration::{POSE, Pose, Position, TWIST};
pub use contact::Sliding;
pub use delay::Delay;
pub use fold::Variables;
pub(crate) use frames::TRANSFORMS;
pub use kinematic::{Kinematic, Reading};
pub(crate) use library::TEMPLATE_LIMIT;
pub use library::{Library, LibraryError};
pub(crate) use names::RESERVED;
pub use robot::{Described, FRICTION_SPEED, RobotBase, StatedLosses};
pub(crate) use sensed::component_names;
pub use state::State;
pub use table::Table;
pub use template::{Each, FitTerm, PointMass, Template, TemplateParameter};
pub use unilateral::{AXES, Contact, Plane, Shape};

use crate::dimension::Dimension;
use crate::graph::{ExprId, Graph, SymbolId};
use crate::syntax::PortKind;
use crate::tree::{Mechanism, Tree};

/// A generalised coordinate, or a component of a twist ([`Pose`]).
#[derive(Debug, Clone)]
pub struct Coordinate {
    /// Its name; log columns are `q_<name>`, `dq_<name>`, `ddq_<name>`.
    pub name: String,
    /// Its dimension, if the model declares one; of a twist's component, that of what it is
    /// the rate of.
    pub dimension: Option<Dimension>,
    /// The unit as written.
    pub unit: String,
    /// Position `q`; of a twist's component, a small displacement along it, which no
    /// expression contains.
    pub position: SymbolId,
    /// Velocity `v = dq/dt`; of a twist's component, that component.
    pub velocity: SymbolId,
    /// What the model says about it.
    pub doc: String,
}

/// An input (a commanded force, torque, current, …).
#[derive(Debug, Clone)]
pub struct Input {
    /// Its name; the log column is `u_<name>`.
    pub name: String,
    /// Its dimension, if the model declares one.
    pub dimension: Option<Dimension>,
    /// The unit as written.
    pub unit: String,
    /// What was commanded.
    pub symbol: SymbolId,
    /// What arrives: the command itself unless an effect is in the way.
    pub arrives: ExprId,
    /// Whether nobody stated it: a robot description has motors at all its joints,
    /// a log need not know all of them.
    pub assumed: bool,
    /// What the model says about it.
    pub doc: String,
}

/// A parameter: a number that may differ from machine to machine.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Its name. A parameter of an effect is `<effect>_<places>_<parameter>`.
    pub name: String,
    /// Its dimension, if known.
    pub dimension: Option<Dimension>,
    /// The unit, for people.
    pub unit: String,
    /// The value that the model states.
    pub nominal: f64,
    /// The value where the model states none: of an effect's parameter that of its template.
    pub default: f64,
    /// The smallest value that makes sense (`-∞` if not stated).
    pub lower: f64,
    /// The largest value that makes sense (`∞` if not stated).
    pub upper: f64,
    /// What is believed of it before any log is read, if stated.
    pub belief: Option<Belief>,
    /// How many values a search tries within the bounds, if stated.
    pub tries: Option<usize>,
    /// Its variable.
    pub symbol: SymbolId,
    /// Which of the model's effects it belongs to, if any.
    pub effect: Option<usize>,
    /// What the model says about it.
    pub doc: String,
}

/// What is believed of a parameter: a normal distribution, `prior normal(mean, sd)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// Its mean, in the parameter's unit.
    pub mean: f64,
    /// Its standard deviation, above zero.
    pub sd: f64,
}

/// What a constraint contains decides how often it is differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConstraintKind {
    /// `c(q, t) = 0`, differentiated twice.
    Holonomic,
    /// `c(q, v, t) = 0`, differentiated once.
    Nonholonomic,
}

/// A constraint `c = 0`.
#[derive(Debug, Clone)]
pub struct Constraint {
    /// Its name.
    pub name: String,
    /// What it contains.
    pub kind: ConstraintKind,
    /// Whether it depends explicitly on time.
    pub time_dependent: bool,
    /// Where this is positive the constraint is there; `None`: always.
    pub active: Option<ExprId>,
    /// The variable `λ` that stands for its multiplier in forces.
    pub multiplier: SymbolId,
    /// `c`: left side minus right side.
    pub residual: ExprId,
    /// Its dimension, if known.
    pub dimension: Option<Dimension>,
    /// What the model says about it.
    pub doc: String,
}

/// A named expression that the user wants to see.
#[derive(Debug, Clone)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: ExprId,
    /// Its dimension, if known.
    pub dimension: Option<Dimension>,
    /// What the model says about it.
    pub doc: String,
}

/// One number that a log shows beside the coordinates: a sensor, or a component of one.
#[derive(Debug, Clone)]
pub struct Sensor {
    /// Its name: the log's column.
    pub name: String,
    /// What it shows, without noise: of positions, velocities, accelerations, multipliers,
    /// inputs, states, parameters and time.
    pub value: ExprId,
    /// Its dimension, if known.
    pub dimension: Option<Dimension>,
    /// Standard deviation of its noise, in its unit.
    pub noise: f64,
    /// The distance of neighbouring readings, in its unit; `None`: there are no steps.
    pub resolution: Option<f64>,
    /// Readings per second; `None`: one whenever somebody looks.
    pub rate: Option<f64>,
    /// By how much later than the reading what it shows is, s: a function of parameters. A late
    /// sensor has a negative one.
    pub lead: ExprId,
    /// What the model says about it.
    pub doc: String,
}

/// An effect that the model contains.
#[derive(Debug, Clone)]
pub struct Effect {
    /// The template's name.
    pub template: String,
    /// What it acts on.
    pub on: Vec<(PortKind, String)>,
    /// Indices into [`Model::parameters`].
    pub parameters: Vec<usize>,
    /// The term of a fit that it is part of, if any.
    pub term: Option<FitTerm>,
    /// The template's description.
    pub doc: String,
    /// What the model says about it: which log asked for it, what it bought.
    pub provenance: String,
}

/// One use of a part; what it adds to the model has its name, and `_`, in front.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartUse {
    /// Its name.
    pub name: String,
    /// The part's name.
    pub part: String,
    /// What it gives the part, in brackets, as written.
    pub arguments: String,
    /// What the model says about it.
    pub doc: String,
}

/// A checked model.
#[derive(Debug, Clone)]
pub struct Model {
    /// Its name.
    pub name: String,
    /// What it says about itself.
    pub doc: String,
    /// All expressions.
    pub graph: Graph,
    /// Time `t`.
    pub time: SymbolId,
    /// The generalised coordinates, in the order of the text.
    pub coordinates: Vec<Coordinate>,
    /// The poses of bodies that float by their twists, in the order of the coordinates.
    pub poses: Vec<Pose>,
    /// The inputs, in the order of the text.
    pub inputs: Vec<Input>,
    /// What sensors read in place of positions: the coordinate, and its reading.
    pub measured: Vec<(usize, ExprId)>,
    /// Inputs as they were some time ago, wherever something asks for them.
    pub delays: Vec<Delay>,
    /// The first-order states, in the order of the text, then those of the effects.
    pub states: Vec<State>,
    /// The parameters, in the order of the text, then those of the effects.
    pub parameters: Vec<Parameter>,
    /// What would be parameters had it not been folded in ([`Variables`]): each is its
    /// nominal value, as a constant, wherever it stood.
    pub fixed: Vec<Parameter>,
    /// Kinetic energy `T(q, v, t)`.
    pub kinetic: ExprId,
    /// Potential energy `V(q, t)`.
    pub potential: ExprId,
    /// Rayleigh dissipation function; its force is `-∂/∂v`.
    pub dissipation: ExprId,
    /// Generalised forces stated outright, one sum per coordinate.
    pub forces: Vec<ExprId>,
    /// Forces and torques at frames.
    pub point_forces: Vec<PointForce>,
    /// Bodies, frames and gravity; the first body is the world.
    pub tree: Tree,
    /// The tree, ready for derivation; `None` if nothing asks for it.
    pub mechanism: Option<Mechanism>,
    /// The bodies that have a name.
    pub bodies: Vec<NamedBody>,
    /// The symbols that stand for what is read off frames.
    pub kinematics: Vec<Kinematic>,
    /// The robot description underneath, if any.
    pub robot: Option<RobotBase>,
    /// The constraints, in the order of the text.
    pub constraints: Vec<Constraint>,
    /// The unilateral contacts, in the order of the text.
    pub contacts: Vec<Contact>,
    /// The outputs, in the order of the text.
    pub outputs: Vec<Output>,
    /// The sensors, in the order of the text.
    pub sensors: Vec<Sensor>,
    /// The frames that gyroscopes and accelerometers are mounted at.
    pub boards: Vec<String>,
    /// What stands for accelerations in the sensors, one per coordinate; empty without a sensor.
    pub accelerations: Vec<SymbolId>,
    /// The effects, in the order of the text.
    pub effects: Vec<Effect>,
    /// The look-up tables, in the order of the text.
    pub tables: Vec<Table>,
    /// The uses of parts, in the order of the text, each in front of those inside it.
    pub uses: Vec<PartUse>,
}

impl Model {
    /// The nominal parameter values, in the order of [`parameters`](Self::parameters).
    pub fn nominal_parameters(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.nominal).collect()
    }
}
