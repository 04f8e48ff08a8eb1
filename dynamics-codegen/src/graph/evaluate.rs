//! Numbers in, numbers out: one state at a time. For many states there is the tape.

use super::{Binary, ExprId, Graph, Node, Unary};

impl Unary {
    /// The function's value.
    pub fn apply(self, x: f64) -> f64 {
        match self {
            Self::Neg => -x,
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Sqrt => x.sqrt(),
            Self::Tanh => x.tanh(),
            Self::Abs => x.abs(),
            Self::Sign if x == 0.0 => 0.0,
            Self::Sign => x.signum(),
            Self::Step => f64::from(u8::from(x > 0.0)),
        }
    }
}

impl Binary {
    /// The function's value.
    pub fn apply(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Add => x + y,
            Self::Sub => x - y,
            Self::Mul => x * y,
            Self::Div => x / y,
            Self::Pow => x.powf(y),
            Self::Atan2 => x.atan2(y),
            Self::Min => x.min(y),
            Self::Max => x.max(y),
        }
    }
}

impl Graph {
    /// The values of `outputs` at the values of all symbols, in symbol order.
    ///
    /// `symbols` must have [`symbol_count`](Self::symbol_count) entries.
    pub fn evaluate(&self, outputs: &[ExprId], symbols: &[f64]) -> Vec<f64> {
        assert_eq!(symbols.len(), self.symbol_count(), "one value per symbol");
        let mut values = vec![0.0; self.len()];
        for expr in self.reachable(outputs).iter() {
            values[expr.index()] = match self.node(expr) {
                Node::Constant(bits) => f64::from_bits(bits),
                Node::Symbol(symbol) => symbols[symbol.index()],
                Node::Unary(op, x) => op.apply(values[x.index()]),
                Node::Binary(op, x, y) => op.apply(values[x.index()], values[y.index()]),
            };
        }
        outputs
            .iter()
            .map(|output| values[output.index()])
            .collect()
    }
}
