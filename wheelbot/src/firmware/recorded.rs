//! Numbers that write down what is done with them: generic Rust becomes expressions.
//!
//! [`record`] runs a function over [`Recorded`] in place of `f32`. Every operation is put on a graph,
//! from which C is emitted: the same source runs in the simulation and on a controller without a
//! Rust compiler. Where the function decides by a number that is not constant there is no such
//! expression, and recording fails.

use dynamics::{Real, Scalar};
use dynamics_codegen::graph::{Binary, ExprId, Graph, SymbolId, Unary};
use std::cell::RefCell;
use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// The function decides by a number that is known only when it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the function compares or prints a number that is not constant: state the choice by `min`, `max`, \
     `select_positive` or `step`"
)]
pub struct Decides;

#[derive(Default)]
struct Recording {
    graph: Graph,
    decided: bool,
}

thread_local! {
    static RECORDING: RefCell<Recording> = RefCell::default();
}

fn with<R>(act: impl FnOnce(&mut Recording) -> R) -> R {
    RECORDING.with_borrow_mut(act)
}

fn on_graph(act: impl FnOnce(&mut Graph) -> ExprId) -> Recorded {
    Recorded(with(|recording| act(&mut recording.graph)))
}

/// An expression on the graph of the running [`record`]; of no use after it.
#[derive(Debug, Clone, Copy)]
pub struct Recorded(ExprId);

impl Recorded {
    /// Where it stands on the graph.
    pub fn expression(self) -> ExprId {
        self.0
    }

    /// An argument of the function, new on the graph.
    pub fn argument(name: &str) -> (SymbolId, Self) {
        with(|Recording { graph, .. }| {
            let symbol = graph.symbol(name);
            (symbol, Self(graph.var(symbol)))
        })
    }

    fn constant(self) -> Option<f64> {
        with(|recording| recording.graph.as_constant(self.0))
    }

    /// Its value, which has to be a constant.
    fn decided(self) -> f64 {
        self.constant().unwrap_or_else(|| {
            with(|recording| recording.decided = true);
            f64::NAN
        })
    }

    fn unary(self, op: Unary) -> Self {
        on_graph(|graph| graph.unary(op, self.0))
    }

    fn binary(self, op: Binary, other: Self) -> Self {
        on_graph(|graph| graph.binary(op, self.0, other.0))
    }
}

/// What `run` does with the arguments that it makes, as expressions on a graph.
///
/// # Errors
/// [`Decides`].
pub fn record<R>(run: impl FnOnce() -> R) -> Result<(Graph, R), Decides> {
    with(|recording| *recording = Recording::default());
    let result = run();
    let Recording { graph, decided } = with(std::mem::take);
    match decided {
        true => Err(Decides),
        false => Ok((graph, result)),
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $by:ident;)*) => {$(
        impl $operator for Recorded {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.binary(Binary::$operator, other)
            }
        }
        impl $assign for Recorded {
            fn $by(&mut self, other: Self) {
                *self = self.binary(Binary::$operator, other);
            }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
}

impl Neg for Recorded {
    type Output = Self;
    fn neg(self) -> Self {
        self.unary(Unary::Neg)
    }
}

impl PartialEq for Recorded {
    /// One expression is equal to itself; of two that are not constant nobody knows.
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0 || self.decided() == other.decided()
    }
}

impl PartialOrd for Recorded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.decided().partial_cmp(&other.decided())
    }
}

macro_rules! functions {
    ($($method:ident $op:ident;)*) => {$(
        fn $method(self) -> Self {
            self.unary(Unary::$op)
        }
    )*};
}

impl Scalar for Recorded {
    fn from_f64(x: f64) -> Self {
        on_graph(|graph| graph.constant(x))
    }

    functions! {
        sqrt Sqrt;
        tan Tan;
        asin Asin;
        acos Acos;
        atan Atan;
        exp Exp;
        ln Ln;
        tanh Tanh;
        abs Abs;
        sign Sign;
        step Step;
    }

    fn sin_cos(self) -> (Self, Self) {
        (self.unary(Unary::Sin), self.unary(Unary::Cos))
    }

    fn atan2(self, x: Self) -> Self {
        self.binary(Binary::Atan2, x)
    }

    fn powf(self, y: Self) -> Self {
        self.binary(Binary::Pow, y)
    }

    fn min(self, other: Self) -> Self {
        self.binary(Binary::Min, other)
    }

    fn max(self, other: Self) -> Self {
        self.binary(Binary::Max, other)
    }

    /// Both are computed, and one is multiplied by zero: neither may be infinite.
    fn select_positive(self, if_positive: Self, otherwise: Self) -> Self {
        let positive = self.step();
        positive * if_positive + (Self::one() - positive) * otherwise
    }
}

impl Real for Recorded {
    /// That of `f32`.
    fn epsilon() -> Self {
        Self::from_f64(f64::from(f32::EPSILON))
    }

    fn is_finite(self) -> bool {
        self.decided().is_finite()
    }

    fn to_f64(self) -> f64 {
        self.decided()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluated<T: Scalar>(x: T, y: T) -> [T; 4] {
        let (s, c) = (x * y).sin_cos();
        let limited = (x / y).min(T::from_f64(0.4)).max(-T::one());
        let chosen = (x - y).select_positive(s, c);
        [
            s + c * x,
            limited,
            chosen,
            (x * x + T::one()).sqrt().atan2(y),
        ]
    }

    #[test]
    fn what_is_recorded_computes_the_same() {
        let (graph, outputs) = record(|| {
            let [x, y] = ["x", "y"].map(|name| Recorded::argument(name).1);
            evaluated(x, y).map(Recorded::expression)
        })
        .unwrap();
        for (x, y) in [(0.3, 1.7), (-2.0, 0.4), (1.5, -0.2)] {
            let found = graph.evaluate(&outputs, &[x, y]);
            for (found, expected) in found.iter().zip(evaluated(x, y)) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }

    #[test]
    fn a_decision_by_an_argument_is_refused() {
        let branches = |limit: f64| {
            let limit = Recorded::from_f64(limit);
            let (_, x) = Recorded::argument("x");
            if limit > Recorded::zero() { x } else { -x }
        };
        assert!(record(|| branches(1.0)).is_ok());
        let asks = || Recorded::argument("x").1 > Recorded::zero();
        assert_eq!(record(asks).unwrap_err(), Decides);
        assert!(record(|| Recorded::argument("x").1.is_finite()).is_err());
    }
}
