//! How much arithmetic a function does.

use super::plan::{Function, Plan};
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

/// The operations of the terms and of `equation_of_motion`, by the functions' names, in
/// the order of emission.
pub fn operation_counts(compiled: &Compiled) -> Vec<(String, OperationCount)> {
    count_functions(&Plan::terms(compiled))
}

/// The operations of every function of a plan.
pub(super) fn count_functions(plan: &Plan) -> Vec<(String, OperationCount)> {
    let count = |f: &Function| OperationCount::of(&plan.model.graph, &f.entries());
    let functions = plan.functions.iter();
    functions.map(|f| (f.name.clone(), count(f))).collect()
}

/// A table for comments and reports.
pub(super) fn table(plan: &Plan) -> Vec<String> {
    let names = plan.functions.iter().map(|f| f.name.len());
    let wide = names.max().unwrap_or(0).max(22);
    let mut lines = vec![format!(
        "{:<wide$}{:>7}{:>7}{:>7}{:>7}{:>9}{:>7}",
        "function", "total", "+ -", "*", "/", "sin cos", "other"
    )];
    for (name, n) in count_functions(plan) {
        lines.push(format!(
            "{name:<wide$}{:>7}{:>7}{:>7}{:>7}{:>9}{:>7}",
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
