//! Which word means what.
//!
//! Coordinates and inputs have namespaces of their own, because a log has
//! `q_j1` and `u_j1`: joint and motor share a name. Everything else shares one.

use super::sensor::{ENCODERS, MOMENTARY_VECTORS};
use crate::source::Span;
use crate::syntax::{CASES, Expr, ExprKind, Name, PortKind};
use std::collections::{BTreeMap, BTreeSet};

/// What a plain word stands for.
#[derive(Debug, Clone)]
pub(super) enum Binding {
    /// Index of a coordinate.
    Coordinate(usize),
    /// Index of a pose, and which of its seven positions.
    Pose(usize, usize),
    /// Index of a parameter.
    Parameter(usize),
    /// Index of a state.
    State(usize),
    /// A constant or a `let`: its expression, lowered when first used.
    Term(usize),
}

/// A shared term before and while it is being lowered.
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub name: Name,
    pub value: Expr,
    pub declared: Option<crate::dimension::Dimension>,
    pub state: TermState,
    /// Constants may contain numbers and other constants only.
    pub constant: bool,
}

/// How far a term has come.
#[derive(Debug, Clone, Copy)]
pub(super) enum TermState {
    Waiting,
    /// On the stack: meeting it again is a circle.
    Lowering,
    Done(super::quantity::Quantity),
    /// Its error has been reported.
    Failed,
}

/// A declared name with its place.
#[derive(Debug, Clone)]
pub(super) struct Declared<T> {
    pub what: T,
    pub span: Span,
}

/// The names visible in one file.
#[derive(Debug, Clone, Default)]
pub(super) struct Scope {
    pub names: BTreeMap<String, Declared<Binding>>,
    pub inputs: BTreeMap<String, Declared<usize>>,
    /// In a template: what the ports are bound to.
    pub ports: BTreeMap<String, (PortKind, usize)>,
    /// Of ports that stand for several coordinates: which.
    pub sets: BTreeMap<String, Vec<usize>>,
    /// The place in the set that such a port stands for just now.
    pub member: Option<usize>,
    pub frames: super::frames::Frames,
    pub terms: Vec<Term>,
    /// While names are declared: the parameters of the text, bound or not yet.
    pub parameters: BTreeSet<String>,
    /// Names whose definition could not be read: not there, and not to be complained about.
    pub unreadable: BTreeSet<String>,
}

/// Words with a meaning of their own.
pub(crate) const RESERVED: [&str; 2] = ["t", "pi"];

/// The functions of the language with their number of arguments.
pub(super) const FUNCTIONS: [(&str, usize); 35] = [
    ("sin", 1),
    ("cos", 1),
    ("tan", 1),
    ("asin", 1),
    ("acos", 1),
    ("atan", 1),
    ("atan2", 2),
    ("sinh", 1),
    ("cosh", 1),
    ("tanh", 1),
    ("exp", 1),
    ("ln", 1),
    ("sqrt", 1),
    ("abs", 1),
    ("sign", 1),
    ("step", 1),
    ("min", 2),
    ("max", 2),
    ("dot", 1),
    ("input", 1),
    ("coordinate", 1),
    ("delay", 2),
    ("mass", 1),
    ("multiplier", 1),
    ("normal_force", 1),
    ("speed", 1),
    ("load", 1),
    ("norm", 1),
    ("gap", 1),
    ("slip_x", 1),
    ("slip_y", 1),
    ("slip_z", 1),
    ("encoder_x", 2),
    ("encoder_y", 2),
    ("encoder_z", 2),
];

/// Functions of other languages, with what stands for them.
pub(super) const NO_FUNCTIONS: [(&str, &str); 3] = [
    ("if", CASES),
    ("log", "the natural logarithm is `ln(x)`"),
    ("pow", "a power is written `x^y`"),
];

/// Functions that read numbers or bodies by name.
const LOOKUPS: [&str; 11] = [
    "input",
    "coordinate",
    "mass",
    "multiplier",
    "normal_force",
    "speed",
    "load",
    "gap",
    "slip_x",
    "slip_y",
    "slip_z",
];

/// Functions of frames and bodies with three components.
pub(super) const VECTORS: [&str; 7] = [
    "center",
    "position",
    "velocity",
    "angular_velocity",
    "axis_x",
    "axis_y",
    "axis_z",
];

/// Whether a function is of frames or bodies, not of numbers.
fn takes_frames(function: &str) -> bool {
    VECTORS.contains(&function)
        || MOMENTARY_VECTORS.contains(&function)
        || ENCODERS.contains(&function)
}

impl Scope {
    /// The terms that an expression names, added to `found`.
    pub fn terms_in(&self, expr: &Expr, found: &mut Vec<usize>) {
        match &expr.kind {
            ExprKind::Number(_) => {}
            ExprKind::Name(name) => {
                let bound = self.names.get(name).map(|declared| &declared.what);
                if let (Some(Binding::Term(index)), false) = (bound, self.ports.contains_key(name))
                {
                    found.push(*index);
                }
            }
            ExprKind::Negate(inner) => self.terms_in(inner, found),
            ExprKind::Power(base, exponent) => {
                self.terms_in(base, found);
                self.terms_in(exponent, found);
            }
            ExprKind::Sum(first, rest) | ExprKind::Product(first, rest) => {
                self.terms_in(first, found);
                rest.iter().for_each(|(_, expr)| self.terms_in(expr, found));
            }
            // These look names up among inputs, coordinates, frames and bodies.
            ExprKind::Call(name, _) if LOOKUPS.contains(&name.text.as_str()) => {}
            ExprKind::Call(name, _) if takes_frames(&name.text) => {}
            ExprKind::Call(name, arguments) if name.text == "delay" => {
                arguments
                    .iter()
                    .skip(1)
                    .for_each(|expr| self.terms_in(expr, found));
            }
            ExprKind::Member(inner, _) => self.terms_in(inner, found),
            ExprKind::Call(_, arguments) => {
                arguments.iter().for_each(|expr| self.terms_in(expr, found));
            }
        }
    }

    /// Whether the definition of a name, or the use of a part that has it, could not be read.
    pub fn is_unreadable(&self, name: &str) -> bool {
        let of_use = |lost: &String| {
            name.strip_prefix(lost.as_str())
                .is_some_and(|r| r.starts_with('_'))
        };
        self.unreadable.contains(name) || self.unreadable.iter().any(of_use)
    }

    /// Whether a word may stand in an expression.
    pub fn has_name(&self, name: &str) -> bool {
        self.names.contains_key(name)
            || self.inputs.contains_key(name)
            || self.ports.contains_key(name)
            || RESERVED.contains(&name)
    }

    /// Every word that may stand in an expression.
    pub fn all_names(&self) -> impl Iterator<Item = &str> {
        let own = self
            .names
            .keys()
            .chain(self.inputs.keys())
            .chain(self.ports.keys());
        own.map(String::as_str).chain(RESERVED)
    }
}
