//! What a model's symbols are called in emitted code.

use super::naming::{Locals, snake};
use crate::graph::SymbolId;
use crate::model::Model;
use std::collections::{BTreeMap, BTreeSet};

/// The part of a function's arguments that a symbol belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    Time,
    Position(usize),
    Velocity(usize),
    Input(usize),
    State(usize),
    Parameter(usize),
    /// A stated acceleration.
    Acceleration(usize),
    /// A stated multiplier.
    Multiplier(usize),
    /// A place of a routine's arrays, all of them counted through.
    Place(usize),
}

/// An argument of emitted functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Argument {
    Parameters,
    Point,
    Acceleration,
    Multipliers,
    /// The arrays of a routine.
    Arrays,
}

impl Role {
    /// The argument that holds it.
    pub fn argument(self) -> Argument {
        match self {
            Self::Time
            | Self::Position(_)
            | Self::Velocity(_)
            | Self::Input(_)
            | Self::State(_) => Argument::Point,
            Self::Parameter(_) => Argument::Parameters,
            Self::Acceleration(_) => Argument::Acceleration,
            Self::Multiplier(_) => Argument::Multipliers,
            Self::Place(_) => Argument::Arrays,
        }
    }

    /// Where a function takes it from, with the language's `access` to a member;
    /// `None` for parameters, which are read where they are used, and for places of arrays, which
    /// the routine names.
    pub fn place(self, access: &str) -> Option<String> {
        Some(match self {
            Self::Time => format!("x{access}t"),
            Self::Position(i) => format!("x{access}q[{i}]"),
            Self::Velocity(i) => format!("x{access}v[{i}]"),
            Self::Input(i) => format!("x{access}u[{i}]"),
            Self::State(i) => format!("x{access}z[{i}]"),
            Self::Acceleration(i) => format!("a[{i}]"),
            Self::Multiplier(i) => format!("lambda[{i}]"),
            Self::Parameter(_) | Self::Place(_) => return None,
        })
    }
}

/// A symbol of the model.
#[derive(Debug, Clone)]
pub(super) struct Symbol {
    pub role: Role,
    /// The local variable; for a parameter, the field.
    pub code: String,
    /// What names of temporaries call it.
    pub telling: String,
}

/// All symbols of a model.
#[derive(Debug, Clone)]
pub(super) struct Symbols {
    symbols: BTreeMap<SymbolId, Symbol>,
    /// Names that no local variable may have.
    taken: Vec<String>,
}

/// Names of a function's arguments.
const ARGUMENTS: [&str; 8] = ["p", "x", "a", "lambda", "out", "w", "circular", "given"];

impl Symbols {
    /// Names them, and the symbols that stand for `a` and `λ`; `taken` lists what the
    /// language at hand needs for itself, `field` says what it calls a parameter's field.
    pub fn new(
        model: &Model,
        (acceleration, multipliers): (&[SymbolId], &[SymbolId]),
        (taken, field): (&[&str], fn(&str) -> String),
    ) -> Self {
        let taken: Vec<String> = ARGUMENTS
            .iter()
            .chain(taken)
            .map(|s| s.to_string())
            .collect();
        let mut locals = Locals::new(taken.iter().map(String::as_str));
        let mut symbols = BTreeMap::new();
        let mut add = |id: SymbolId, role: Role, code: String, telling: String| {
            symbols.insert(
                id,
                Symbol {
                    role,
                    code,
                    telling,
                },
            );
        };
        add(model.time, Role::Time, locals.claim("t"), "t".into());
        for (i, p) in model.positions().into_iter().enumerate() {
            let code = locals.claim(&format!("q_{}", p.name));
            add(p.symbol, Role::Position(i), code, snake(&p.name));
        }
        for (i, c) in model.coordinates.iter().enumerate() {
            let code = locals.claim(&format!("dq_{}", c.name));
            let telling = format!("d_{}", snake(&c.name));
            add(c.velocity, Role::Velocity(i), code, telling);
        }
        for (i, u) in model.inputs.iter().enumerate() {
            let code = locals.claim(&format!("u_{}", u.name));
            add(
                u.symbol,
                Role::Input(i),
                code,
                format!("u_{}", snake(&u.name)),
            );
        }
        for (i, d) in model.delays.iter().enumerate() {
            let code = locals.claim(&format!("u_{}", d.name));
            let role = Role::Input(model.inputs.len() + i);
            add(d.symbol, role, code, format!("u_{}", snake(&d.name)));
        }
        let first = model.inputs.len() + model.delays.len();
        for (i, c) in model.constraints.iter().enumerate() {
            let code = locals.claim(&format!("lambda_{}", c.name));
            let telling = format!("lambda_{}", snake(&c.name));
            add(c.multiplier, Role::Input(first + i), code, telling);
        }
        for (i, z) in model.states.iter().enumerate() {
            let code = locals.claim(&format!("z_{}", z.name));
            let telling = format!("z_{}", snake(&z.name));
            add(z.symbol, Role::State(i), code, telling);
        }
        for (i, (c, &id)) in model.coordinates.iter().zip(acceleration).enumerate() {
            let code = locals.claim(&format!("ddq_{}", c.name));
            let telling = format!("dd_{}", snake(&c.name));
            add(id, Role::Acceleration(i), code, telling);
        }
        for (k, (c, &id)) in model.constraints.iter().zip(multipliers).enumerate() {
            let code = locals.claim(&format!("lambda_{}", c.name));
            let telling = format!("lambda_{}", snake(&c.name));
            add(id, Role::Multiplier(k), code, telling);
        }
        for (i, p) in model.parameters.iter().enumerate() {
            add(p.symbol, Role::Parameter(i), field(&p.name), snake(&p.name));
        }
        Self { symbols, taken }
    }

    /// Those of a routine, each with a wish for its name, in the order of [`Role::Place`].
    pub fn of_routine<'a>(
        places: impl IntoIterator<Item = (SymbolId, &'a str)>,
        taken: Vec<String>,
    ) -> Self {
        let mut locals = Locals::new(taken.iter().map(String::as_str));
        let places = places.into_iter().enumerate();
        let symbols = places.map(|(place, (id, name))| {
            let symbol = Symbol {
                role: Role::Place(place),
                code: locals.claim(name),
                telling: snake(name),
            };
            (id, symbol)
        });
        Self {
            symbols: symbols.collect(),
            taken,
        }
    }

    /// The symbol behind an identifier.
    pub fn get(&self, id: SymbolId) -> &Symbol {
        // Expressions of a system hold no symbol but those of `System::arguments`.
        &self.symbols[&id]
    }

    /// The local variables of all arguments, and the arguments themselves.
    pub fn locals(&self) -> Locals {
        let own = self.symbols.values();
        let variables = own.filter(|s| !matches!(s.role, Role::Parameter(_)));
        let taken = self.taken.iter().map(String::as_str);
        Locals::new(variables.map(|s| s.code.as_str()).chain(taken))
    }

    /// The local variables of some arguments, with what they are.
    pub fn read_by(&self, reads: &BTreeSet<Role>) -> Vec<(&str, Role)> {
        let own = self.symbols.values().filter(|s| reads.contains(&s.role));
        let mut read: Vec<(&str, Role)> = own.map(|s| (s.code.as_str(), s.role)).collect();
        read.sort_by_key(|(_, role)| *role);
        read
    }

    /// Width of the written symbol.
    pub fn width(&self, id: SymbolId) -> usize {
        let symbol = self.get(id);
        let access = if let Role::Parameter(_) = symbol.role {
            3
        } else {
            0
        };
        symbol.code.len() + access
    }
}
