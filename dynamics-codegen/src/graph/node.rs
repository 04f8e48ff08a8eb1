//! What a node can be.

/// Identifies an expression of one [`Graph`](super::Graph).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(pub(super) u32);

impl ExprId {
    /// The position in the arena.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Identifies a symbol (free variable) of one [`Graph`](super::Graph).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SymbolId(pub(super) u32);

impl SymbolId {
    /// The position in the symbol table.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A function of one argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Unary {
    /// `-x`
    Neg,
    /// `sin x`
    Sin,
    /// `cos x`
    Cos,
    /// `tan x`
    Tan,
    /// `asin x`
    Asin,
    /// `acos x`
    Acos,
    /// `atan x`
    Atan,
    /// `e^x`
    Exp,
    /// natural logarithm
    Ln,
    /// `√x`
    Sqrt,
    /// `tanh x`
    Tanh,
    /// `|x|`
    Abs,
    /// `-1`, `0` or `1`
    Sign,
    /// `1` for `x > 0`, else `0`
    Step,
}

/// A function of two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Binary {
    /// `x + y`
    Add,
    /// `x - y`
    Sub,
    /// `x · y`
    Mul,
    /// `x / y`
    Div,
    /// `x^y`
    Pow,
    /// the angle of the point `(y, x)`: `atan2(x, y)` with the ordinate first
    Atan2,
    /// the smaller one
    Min,
    /// the larger one
    Max,
}

impl Binary {
    /// Whether the order of the arguments does not matter.
    pub fn is_commutative(self) -> bool {
        matches!(self, Self::Add | Self::Mul | Self::Min | Self::Max)
    }
}

/// One node of the graph. Constants are kept as bits so that nodes can be hashed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Node {
    /// A number.
    Constant(u64),
    /// A free variable.
    Symbol(SymbolId),
    /// A function of one expression.
    Unary(Unary, ExprId),
    /// A function of two expressions.
    Binary(Binary, ExprId, ExprId),
}

impl Node {
    /// The arguments, in order.
    pub fn children(self) -> impl Iterator<Item = ExprId> {
        let (first, second) = match self {
            Self::Constant(_) | Self::Symbol(_) => (None, None),
            Self::Unary(_, x) => (Some(x), None),
            Self::Binary(_, x, y) => (Some(x), Some(y)),
        };
        first.into_iter().chain(second)
    }

    /// Whether computing the node costs an operation.
    pub fn is_operation(self) -> bool {
        matches!(self, Self::Unary(..) | Self::Binary(..))
    }
}
