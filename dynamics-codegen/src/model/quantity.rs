//! Expressions with their dimension, while statements are being lowered.

use crate::dimension::Dimension;
use crate::graph::ExprId;

/// What is known of an expression's dimension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// It is this.
    Known(Dimension),
    /// Made of bare numbers only: takes the dimension of its surroundings in a
    /// sum, and is a pure number in a product.
    Bare,
    /// Contains something declared without a unit: not checked.
    Unchecked,
}

impl Measure {
    pub fn of(declared: Option<Dimension>) -> Self {
        declared.map_or(Self::Unchecked, Self::Known)
    }

    pub fn known(self) -> Option<Dimension> {
        match self {
            Self::Known(dimension) => Some(dimension),
            Self::Bare | Self::Unchecked => None,
        }
    }

    /// That of the time derivative.
    pub fn rate(self) -> Self {
        match self {
            Self::Known(dimension) => Self::Known(dimension.rate()),
            other => other,
        }
    }

    /// The dimension of a product or quotient.
    pub fn combine(self, other: Self, f: fn(Dimension, Dimension) -> Dimension) -> Self {
        match (self, other) {
            (Self::Unchecked, _) | (_, Self::Unchecked) => Self::Unchecked,
            (Self::Bare, Self::Bare) => Self::Bare,
            (a, b) => Self::Known(f(a.or_one(), b.or_one())),
        }
    }

    fn or_one(self) -> Dimension {
        self.known().unwrap_or(Dimension::ONE)
    }

    /// The dimension of a sum, or `None` if the two cannot be added.
    pub fn unify(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Known(a), Self::Known(b)) => (a == b).then_some(self),
            (Self::Known(_), _) => Some(self),
            (_, Self::Known(_)) => Some(other),
            (Self::Bare, Self::Bare) => Some(Self::Bare),
            _ => Some(Self::Unchecked),
        }
    }
}

/// An expression on the graph with its dimension.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantity {
    pub expr: ExprId,
    pub measure: Measure,
}
