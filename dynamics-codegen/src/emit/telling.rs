//! Names for temporaries that follow from what they hold.

use super::symbols::Symbols;
use crate::graph::{Binary, ExprId, Graph, Node, Unary};

/// Longer names help nobody.
const LONGEST: usize = 28;
/// How many operations a name may spell out.
const DEEPEST: usize = 3;

/// `sin_theta`, `j1_plus_j2`, `d_x_sq`, …; `None` if nothing short says it.
pub(super) fn telling_name(graph: &Graph, symbols: &Symbols, expr: ExprId) -> Option<String> {
    let name = spell(graph, symbols, expr, DEEPEST)?;
    (name.len() <= LONGEST).then_some(name)
}

fn spell(graph: &Graph, symbols: &Symbols, expr: ExprId, depth: usize) -> Option<String> {
    let node = graph.node(expr);
    if let Node::Symbol(symbol) = node {
        let name = &symbols.get(symbol).telling;
        return (!name.is_empty()).then(|| name.clone());
    }
    if let Some(label) = graph.label_of(expr) {
        return Some(label.to_string());
    }
    if depth == 0 {
        return None;
    }
    let inner = |x| spell(graph, symbols, x, depth - 1);
    match node {
        Node::Constant(_) | Node::Symbol(_) => None,
        Node::Unary(Unary::Neg, x) => Some(format!("minus_{}", inner(x)?)),
        Node::Unary(op, x) => Some(format!("{}_{}", op.name(), inner(x)?)),
        Node::Binary(Binary::Mul, x, y) if x == y => Some(format!("{}_sq", inner(x)?)),
        Node::Binary(op, x, y) => {
            let word = match op {
                Binary::Add => "plus",
                Binary::Sub => "minus",
                Binary::Mul => return Some(format!("{}_{}", inner(x)?, inner(y)?)),
                Binary::Div => "over",
                _ => return None,
            };
            Some(format!("{}_{word}_{}", inner(x)?, inner(y)?))
        }
    }
}
