//! Which nodes some outputs need.

use super::{ExprId, Graph, Node, SymbolId};
use std::collections::HashSet;

/// The nodes needed by a set of outputs, children before parents.
#[derive(Debug, Clone)]
pub struct Reachable {
    order: Vec<ExprId>,
}

impl Reachable {
    /// The nodes in an order in which each can be computed.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = ExprId> + '_ {
        self.order.iter().copied()
    }
}

impl Graph {
    /// The nodes that `outputs` depend on, children before parents.
    pub fn reachable(&self, outputs: &[ExprId]) -> Reachable {
        self.reachable_beyond(outputs, |_| false)
    }

    /// The same without nodes that are `given`, and without what only they depend on.
    pub fn reachable_beyond(
        &self,
        outputs: &[ExprId],
        given: impl Fn(ExprId) -> bool,
    ) -> Reachable {
        let Some(last) = outputs.iter().max() else {
            return Reachable { order: Vec::new() };
        };
        let mut needed = vec![false; last.index() + 1];
        for output in outputs {
            needed[output.index()] = true;
        }
        for index in (0..needed.len()).rev() {
            if needed[index] && given(ExprId(index as u32)) {
                needed[index] = false;
            }
            if needed[index] {
                for child in self.nodes[index].children() {
                    needed[child.index()] = true;
                }
            }
        }
        let order = (0..needed.len())
            .filter(|&index| needed[index])
            .map(|index| ExprId(index as u32))
            .collect();
        Reachable { order }
    }

    /// Whether any of `outputs` depends on `symbol`.
    pub fn depends_on(&self, outputs: &[ExprId], symbol: SymbolId) -> bool {
        let var = self.var(symbol);
        self.reachable(outputs).iter().any(|expr| expr == var)
    }

    /// The symbols that `outputs` depend on.
    pub fn symbols_in(&self, outputs: &[ExprId]) -> HashSet<SymbolId> {
        let reachable = self.reachable(outputs);
        let symbols = reachable.iter().filter_map(|expr| match self.node(expr) {
            Node::Symbol(symbol) => Some(symbol),
            _ => None,
        });
        symbols.collect()
    }

    /// How many operations the outputs cost together, each shared
    /// subexpression counted once.
    pub fn operation_count(&self, outputs: &[ExprId]) -> usize {
        self.reachable(outputs)
            .iter()
            .filter(|&expr| self.node(expr).is_operation())
            .count()
    }
}
