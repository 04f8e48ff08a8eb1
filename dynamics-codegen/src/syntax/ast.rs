//! The syntax tree. Every node keeps its place in the text.

use crate::robot::Format;
use crate::source::Span;

/// A word with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    /// The word.
    pub text: String,
    /// Where it stands.
    pub span: Span,
}

/// A model file or an effect template.
#[derive(Debug, Clone)]
pub struct File {
    /// What stands in the first line.
    pub heading: Heading,
    /// Text of the doc comment in front of the heading.
    pub doc: String,
    /// Everything else, in the order of the text.
    pub statements: Vec<Statement>,
    /// What statements that could not be read were going to define: defined all the same,
    /// so that one slip is not reported at every use.
    pub unreadable: Vec<Name>,
}

/// The first line of a file.
#[derive(Debug, Clone)]
pub enum Heading {
    /// `model name;`
    Model(Name),
    /// `effect name(joint, drive: input);`, `effect name(drive: each input);`
    Effect {
        /// The effect's name.
        name: Name,
        /// What it acts on.
        ports: Vec<Port>,
    },
}

/// A formal argument of an effect template: something of the model to act on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Its name inside the template.
    pub name: Name,
    /// What it stands for.
    pub kind: PortKind,
    /// Whether it is one after the other of several of that kind.
    pub each: bool,
}

/// What an effect can act on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PortKind {
    /// A coordinate (the default).
    Coordinate,
    /// An input.
    Input,
    /// The shaft that an input turns.
    Drive,
    /// A body.
    Body,
    /// Several coordinates of one unit: the last port of a template.
    Coordinates,
    /// A constraint that is a contact: something slides along it.
    Constraint,
    /// A column of a log: a coordinate, or a sensor.
    Reading,
    /// A sensor, or a component of one.
    Sensor,
    /// A frame.
    Frame,
}

/// One statement.
#[derive(Debug, Clone)]
pub struct Statement {
    /// Text of the doc comment in front of it.
    pub doc: String,
    /// From its first to its last token.
    pub span: Span,
    /// What it says.
    pub kind: StatementKind,
}

/// What a statement says.
#[derive(Debug, Clone)]
pub enum StatementKind {
    /// `coordinate x: m;`
    Coordinate {
        /// Its name.
        name: Name,
        /// Its unit.
        unit: Option<Unit>,
    },
    /// `input u: N;`
    Input {
        /// Its name.
        name: Name,
        /// Its unit.
        unit: Option<Unit>,
    },
    /// `measured x = x + offset;`: what a log shows in place of a position, or of what a sensor
    /// shows.
    Measured {
        /// The coordinate or the sensor.
        name: Name,
        /// What its sensor reads.
        value: Expr,
    },
    /// `mounted board = board * rotate_x(tilt);`: where the inertial sensors of a frame are.
    Mounted {
        /// The frame.
        name: Name,
        /// A product of frames and transforms.
        value: Expr,
    },
    /// `input u = gain*u;`: what arrives in place of what was commanded.
    Channel {
        /// The input that is replaced.
        name: Name,
        /// What arrives.
        value: Expr,
    },
    /// `state z: m = 0;`: a first-order state.
    State {
        /// Its name.
        name: Name,
        /// Its unit.
        unit: Option<Unit>,
        /// Its value when a log begins.
        initial: Option<Expr>,
    },
    /// `dot(z) == expression;`: the rate of a state.
    Rate {
        /// The state.
        name: Name,
        /// Its rate.
        value: Expr,
    },
    /// `parameter m: kg = 1.0 in 0.01.. prior normal(1, 0.05);`
    Parameter {
        /// Its name.
        name: Name,
        /// Its unit.
        unit: Option<Unit>,
        /// Its nominal value.
        nominal: Option<Expr>,
        /// Where it may lie.
        bounds: Option<Bounds>,
        /// What is believed of it beforehand.
        prior: Option<Box<Prior>>,
        /// How many values a search tries within the bounds.
        tries: Option<Expr>,
    },
    /// `constant g: m/s^2 = 9.81;`
    Constant {
        /// Its name.
        name: Name,
        /// Its unit.
        unit: Option<Unit>,
        /// Its value.
        value: Expr,
    },
    /// `let s = sin(theta);`
    Let {
        /// Its name.
        name: Name,
        /// What it stands for.
        value: Expr,
    },
    /// `kinetic m/2*dot(x)^2;`
    Kinetic(Expr),
    /// `potential m*g*z;`
    Potential(Expr),
    /// `dissipation d/2*dot(x)^2;` (Rayleigh: the force is `-∂/∂v`)
    Dissipation(Expr),
    /// `force x = u;`
    Force {
        /// The coordinate it acts on.
        on: Name,
        /// The generalised force.
        value: Expr,
    },
    /// `constraint name when flag: left == right;`
    Constraint {
        /// Its name.
        name: Name,
        /// Where it is positive the constraint is there; always if not stated.
        when: Option<Expr>,
        /// Left of `==`.
        left: Expr,
        /// Right of `==`.
        right: Expr,
    },
    /// `output name = expression;`
    Output {
        /// Its name.
        name: Name,
        /// What it stands for.
        value: Expr,
    },
    /// `sensor board = accelerometer(imu) { noise: 0.02; }`
    Sensor(Box<SensorStatement>),
    /// `contact foot: sphere(ankle, r) on plane_z(world) { friction: mu; }`
    Contact(Box<ContactStatement>),
    /// `urdf "robot.urdf" { base: floating; }`, `mjcf "robot.xml";`
    Robot {
        /// What the description is, by the statement's word.
        format: Format,
        /// The path as written.
        file: Name,
        /// What stands in the braces.
        options: Vec<RobotOption>,
    },
    /// `frame hub = base * rotate_z(yaw);`
    Frame {
        /// Its name.
        name: Name,
        /// A product of frames and transforms.
        value: Expr,
    },
    /// `body arm { … }`
    Body(Box<BodyStatement>),
    /// `gravity (0, 0, -g);`
    Gravity(Box<[Expr; 3]>),
    /// `force at(tip) = (fx, fy, fz);`
    PointForce(Box<PointForce>),
    /// `term friction;`: in a template, the term of a fit that the effect is part of.
    Term {
        /// What the term is called.
        name: Name,
        /// The words `between neighbours`, where they stand.
        neighbours: Option<Span>,
    },
    /// `part arm(base, angle) { … }`
    Part(Box<PartStatement>),
    /// `use left = arm(hub, 0.3) { m = 0.5 }`
    Use(Box<UseStatement>),
    /// `table drag(speed: m/s): N { 0: 0; 1: 0.3; 2: 1.4; }`
    Table(Box<TableStatement>),
    /// `effect viscous(j2) { d = 0.02 }`
    Effect {
        /// The template's name.
        template: Name,
        /// What it acts on.
        on: Vec<Name>,
        /// Values for its parameters.
        values: Vec<(Name, Expr)>,
    },
}

/// A mechanism that is written once.
#[derive(Debug, Clone)]
pub struct PartStatement {
    /// Its name.
    pub name: Name,
    /// What differs from use to use.
    pub ports: Vec<Name>,
    /// What it consists of.
    pub statements: Vec<Statement>,
    /// As [`File::unreadable`].
    pub unreadable: Vec<Name>,
}

/// One use of a part.
#[derive(Debug, Clone)]
pub struct UseStatement {
    /// Its name: in front of all names of the part.
    pub name: Name,
    /// The part.
    pub part: Name,
    /// What its ports stand for here.
    pub arguments: Vec<Expr>,
    /// The brackets around them.
    pub brackets: Span,
    /// Values of its parameters.
    pub values: Vec<(Name, Expr)>,
}

/// A function that is known at points.
#[derive(Debug, Clone)]
pub struct TableStatement {
    /// Its name.
    pub name: Name,
    /// What it is a function of, with units.
    pub arguments: Vec<(Name, Option<Unit>)>,
    /// The unit of its values.
    pub unit: Option<Unit>,
    /// Where the numbers are.
    pub content: TableContent,
}

/// The numbers of a table.
#[derive(Debug, Clone)]
pub enum TableContent {
    /// In braces: what stands in front of the `:`, and what stands behind it.
    Rows(Vec<(Expr, Vec<Expr>)>),
    /// In a file, by its path as written.
    File(Name),
}

/// What a log shows, and how well.
#[derive(Debug, Clone)]
pub struct SensorStatement {
    /// Its name.
    pub name: Name,
    /// Its unit.
    pub unit: Option<Unit>,
    /// What it shows.
    pub value: Expr,
    /// Standard deviation of its noise.
    pub noise: Option<Expr>,
    /// The distance of neighbouring readings.
    pub resolution: Option<Expr>,
    /// Readings per second.
    pub rate: Option<Expr>,
}

/// What may touch a plane, and how.
#[derive(Debug, Clone)]
pub struct ContactStatement {
    /// Its name.
    pub name: Name,
    /// `point(f)`, `sphere(f, r)` or `disc_y(f, r)`.
    pub shape: Expr,
    /// `plane_z(f)`.
    pub plane: Expr,
    /// Coefficient of friction; none if not stated.
    pub friction: Option<Expr>,
    /// Coefficient of restitution; none if not stated.
    pub restitution: Option<Expr>,
}

/// An entry in the braces of `urdf "…" { … }` or `mjcf "…" { … }`.
#[derive(Debug, Clone)]
pub struct RobotOption {
    /// Which option.
    pub name: Name,
    /// Its values.
    pub values: Vec<Name>,
    /// Per value what stands behind its `=`, if anything does: `lock: j5 = 0.3`.
    pub positions: Vec<Option<Expr>>,
}

/// A rigid body.
#[derive(Debug, Clone)]
pub struct BodyStatement {
    /// Its name.
    pub name: Name,
    /// Where it is: a product of frames and transforms.
    pub frame: Expr,
    /// Its mass.
    pub mass: Option<Expr>,
    /// Its centre of mass in its frame.
    pub center: Option<[Expr; 3]>,
    /// `diag(ix, iy, iz)` or `full(ixx, iyy, izz, ixy, ixz, iyz)`, about the centre of mass.
    pub inertia: Option<Expr>,
}

/// A force or torque at a frame.
#[derive(Debug, Clone)]
pub struct PointForce {
    /// The frame whose origin it acts at.
    pub at: Name,
    /// The frame along whose axes it is given; `None` is the world.
    pub axes: Option<Name>,
    /// Its components.
    pub value: [Expr; 3],
    /// Whether it is a torque.
    pub torque: bool,
}

/// `in lower..upper`, each side optional.
#[derive(Debug, Clone)]
pub struct Bounds {
    /// The lower bound.
    pub lower: Option<Expr>,
    /// The upper bound.
    pub upper: Option<Expr>,
    /// The whole of it.
    pub span: Span,
}

/// `prior normal(mean, sd)`
#[derive(Debug, Clone)]
pub struct Prior {
    /// The mean.
    pub mean: Expr,
    /// The standard deviation.
    pub sd: Expr,
}

/// A unit: a product of powers.
#[derive(Debug, Clone)]
pub struct Unit {
    /// The factors.
    pub factors: Vec<UnitFactor>,
    /// The whole of it.
    pub span: Span,
}

/// One factor of a unit.
#[derive(Debug, Clone)]
pub struct UnitFactor {
    /// What is raised to the power.
    pub base: UnitBase,
    /// The power.
    pub exponent: i32,
    /// Its place.
    pub span: Span,
}

/// What a factor of a unit can be.
#[derive(Debug, Clone)]
pub enum UnitBase {
    /// The number one, as in `1/s`.
    One,
    /// A unit by name.
    Named(String),
    /// In a template, a unit that follows from a port: `torque(joint)`.
    OfPort {
        /// `unit`, `rate` or `torque`.
        function: Name,
        /// The port.
        port: Name,
    },
}

/// An expression.
#[derive(Debug, Clone)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Where it stands.
    pub span: Span,
}

/// What an expression can be. Chains are kept flat, so that depth is nesting
/// and nothing else.
#[derive(Debug, Clone)]
pub enum ExprKind {
    /// A number.
    Number(f64),
    /// A name.
    Name(String),
    /// `-x`
    Negate(Box<Expr>),
    /// `a + b - c`: the first term and what follows, `true` for minus.
    Sum(Box<Expr>, Vec<(bool, Expr)>),
    /// `a*b/c`: the first factor and what follows, `true` for division.
    Product(Box<Expr>, Vec<(bool, Expr)>),
    /// `x^y`
    Power(Box<Expr>, Box<Expr>),
    /// `f(a, b)`
    Call(Name, Vec<Expr>),
    /// `position(tip).x`
    Member(Box<Expr>, Name),
}
