//! How much arithmetic a function does.

use super::given::Given;
use super::plan::{EQUATION_OF_MOTION, Function, Plan};
use super::solved::SLOPES;
use crate::compile::Compiled;
use crate::graph::{Binary, ExprId, Graph, Node, Reachable, Unary};
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
        Self::among(graph, graph.reachable(outputs))
    }

    /// Counts what `outputs` need beyond what is given.
    pub(super) fn beyond(graph: &Graph, outputs: &[ExprId], given: &Given) -> Self {
        let known = |expr| given.places.contains_key(&expr);
        Self::among(graph, graph.reachable_beyond(outputs, known))
    }

    fn among(graph: &Graph, needed: Reachable) -> Self {
        let mut count = Self::default();
        for expr in needed.iter() {
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

    /// Those of two functions, one after the other.
    fn plus(self, other: Self) -> Self {
        Self {
            additions: self.additions + other.additions,
            multiplications: self.multiplications + other.multiplications,
            divisions: self.divisions + other.divisions,
            sines: self.sines + other.sines,
            others: self.others + other.others,
        }
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

/// The operations of every function of a plan, with those of the functions that it calls.
pub(super) fn count_functions(plan: &Plan) -> Vec<(String, OperationCount)> {
    let functions = plan.functions.iter();
    functions
        .map(|f| (f.name.clone(), count(plan, f)))
        .collect()
}

fn count(plan: &Plan, function: &Function) -> OperationCount {
    let Some(solved) = &function.solved else {
        let called = (function.given.iter()).map(|g| count(plan, &plan.functions[g.function]));
        return called.fold(function.written(&plan.model.graph), OperationCount::plus);
    };
    let slopes = (!solved.groups.is_empty()).then_some(SLOPES);
    let called = [EQUATION_OF_MOTION].into_iter().chain(slopes);
    let called = called.filter_map(|name| plan.functions.iter().find(|f| f.name == name));
    called
        .map(|function| count(plan, function))
        .chain([plan.loop_count(function, solved)])
        .fold(OperationCount::default(), OperationCount::plus)
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
