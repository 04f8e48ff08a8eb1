//! The expression graph: hash-consed nodes in an arena.
//!
//! Nodes are built by constructors that simplify on the spot ([`build`](self)),
//! so equal expressions have one identity and common subexpressions are shared
//! by construction. A node's children always have smaller identifiers than the
//! node itself: every pass is a loop over identifiers, none is recursive.

mod build;
mod derivative;
mod display;
mod evaluate;
mod node;
mod order;
mod signs;

pub use display::{Display, Precedence};
pub use node::{Binary, ExprId, Node, SymbolId, Unary};
pub use order::Reachable;

use std::collections::{BTreeMap, HashMap};

/// An arena of hash-consed expressions over named symbols.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    identities: HashMap<Node, ExprId>,
    symbols: Vec<String>,
    symbol_nodes: Vec<ExprId>,
    labels: BTreeMap<ExprId, String>,
    calls: BTreeMap<ExprId, Call>,
}

/// What an operation is in the words of a model: a function that the graph has no node for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Call {
    /// The function's name.
    pub name: String,
    /// What it is read at.
    pub arguments: Vec<ExprId>,
}

impl Graph {
    /// An empty graph.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a symbol (a free variable) and returns it. Names are for people:
    /// two symbols of one name are two variables.
    pub fn symbol(&mut self, name: impl Into<String>) -> SymbolId {
        let symbol = SymbolId(u32::try_from(self.symbols.len()).expect("fewer than 2^32 symbols"));
        self.symbols.push(name.into());
        let node = self.intern(Node::Symbol(symbol));
        self.symbol_nodes.push(node);
        symbol
    }

    /// From now on [`var`](Self::var) of `symbol` is a constant. What was built before
    /// still holds the symbol.
    pub fn fix(&mut self, symbol: SymbolId, value: f64) {
        self.symbol_nodes[symbol.index()] = self.constant(value);
    }

    /// The expression that is just `symbol`, or the constant that it was
    /// [fixed](Self::fix) to.
    pub fn var(&self, symbol: SymbolId) -> ExprId {
        self.symbol_nodes[symbol.index()]
    }

    /// The name that `symbol` was made with.
    pub fn symbol_name(&self, symbol: SymbolId) -> &str {
        &self.symbols[symbol.index()]
    }

    /// How many symbols there are.
    pub fn symbol_count(&self) -> usize {
        self.symbols.len()
    }

    /// Remembers what people call an operation; the first name stays. Labels
    /// change no equation: emitted code names its temporaries after them.
    pub fn label(&mut self, expr: ExprId, name: &str) {
        if self.node(expr).is_operation() {
            self.labels.entry(expr).or_insert_with(|| name.to_string());
        }
    }

    /// What people call this operation, if they do.
    pub fn label_of(&self, expr: ExprId) -> Option<&str> {
        self.labels.get(&expr).map(String::as_str)
    }

    /// Remembers that an operation is a function of the model, read at `arguments`, and labels
    /// it so: expressions are then [displayed](Self::display) as the model writes them. The first
    /// name stays.
    pub fn call(&mut self, expr: ExprId, name: &str, arguments: &[ExprId]) {
        self.label(expr, name);
        // What is displayed is walked from the end: arguments stand in front.
        if self.node(expr).is_operation() && arguments.iter().all(|&argument| argument < expr) {
            self.calls.entry(expr).or_insert_with(|| Call {
                name: name.to_string(),
                arguments: arguments.to_vec(),
            });
        }
    }

    /// The function of the model that this operation is, if it is one.
    pub fn call_of(&self, expr: ExprId) -> Option<&Call> {
        self.calls.get(&expr)
    }

    /// All operations that are functions of the model.
    pub fn calls(&self) -> impl Iterator<Item = (ExprId, &Call)> {
        self.calls.iter().map(|(&expr, call)| (expr, call))
    }

    /// The node behind an identifier.
    pub fn node(&self, expr: ExprId) -> Node {
        self.nodes[expr.index()]
    }

    /// The identifier of a node that exists already.
    pub fn find(&self, node: Node) -> Option<ExprId> {
        self.identities.get(&node).copied()
    }

    /// How many nodes the arena holds.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether the arena holds no node at all.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The value of `expr` if it is a constant.
    pub fn as_constant(&self, expr: ExprId) -> Option<f64> {
        match self.node(expr) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Whether `expr` is the constant zero.
    pub fn is_zero(&self, expr: ExprId) -> bool {
        self.as_constant(expr) == Some(0.0)
    }

    /// The identifier of a node, made if it is new. Simplification happens
    /// before this, in the constructors.
    fn intern(&mut self, node: Node) -> ExprId {
        if let Some(&known) = self.identities.get(&node) {
            return known;
        }
        let id = ExprId(u32::try_from(self.nodes.len()).expect("fewer than 2^32 nodes"));
        self.nodes.push(node);
        self.identities.insert(node, id);
        id
    }
}
