//! How much arithmetic a function does.

use super::plan::{functions, quantities};
use crate::compile::Compiled;
use crate::graph::{Binary, ExprId, Graph, Node, Unary};
use std::fmt;

/// Operations of one function; what is shared inside it is counted once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OperationCount {
    /// Additions, subtractions and changes of sign.
    pub additions: usize,
    /// Multiplications.
    pub multiplications: usize,
    /// Divisions.
    pub divisions: usize,
    /// Sines and cosines.
    pub sines: usize,
    /// Every other function.
    pub others: usize,
}

impl OperationCount {
    /// Counts what `outputs` need.
    pub fn of(graph: &Graph, outputs: &[ExprId]) -> Self {
        let mut count = Self::default();
        for expr in graph.reachable(outputs).iter() {
            match graph.node(expr) {
                Node::Constant(_) | Node::Symbol(_) => {}
                Node::Unary(Unary::Neg, _) | Node::Binary(Binary::Add | Binary::Sub, ..) => {
                    count.additions += 1;
                }
                Node::Binary(Binary::Mul, ..) => count.multiplications += 1,
                Node::Binary(Binary::Div, ..) => count.divisions += 1,
                Node::Unary(Unary::Sin | Unary::Cos, _) => count.sines += 1,
                Node::Unary(..) | Node::Binary(..) => count.others += 1,
            }
        }
        count
    }

    /// All of them.
    pub fn total(self) -> usize {
        self.additions + self.multiplications + self.divisions + self.sines + self.others
    }
}

impl fmt::Display for OperationCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} operations ({} additions, {} multiplications, {} divisions, {} sines and cosines, {} others)",
            self.total(),
            self.additions,
            self.multiplications,
            self.divisions,
            self.sines,
            self.others
        )
    }
}

/// The operations of every emitted function, by its name, in the order of emission.
pub fn operation_counts(compiled: &Compiled) -> Vec<(&'static str, OperationCount)> {
    let quantities = quantities(compiled);
    functions(&quantities)
        .iter()
        .map(|f| {
            (
                f.name,
                OperationCount::of(&compiled.model.graph, &f.entries()),
            )
        })
        .collect()
}

/// A table for comments and reports.
pub(super) fn table(compiled: &Compiled) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<22}{:>7}{:>7}{:>7}{:>7}{:>9}{:>7}",
        "function", "total", "+ -", "*", "/", "sin cos", "other"
    )];
    for (name, n) in operation_counts(compiled) {
        lines.push(format!(
            "{name:<22}{:>7}{:>7}{:>7}{:>7}{:>9}{:>7}",
            n.total(),
            n.additions,
            n.multiplications,
            n.divisions,
            n.sines,
            n.others
        ));
    }
    lines
}
