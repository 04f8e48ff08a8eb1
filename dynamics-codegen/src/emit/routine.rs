//! Functions that belong to no model: a controller, an estimator, a filter.

use super::plan::Entry;
use crate::graph::{ExprId, Graph, SymbolId};

/// An array among the arguments (`E` is [`SymbolId`]) or results ([`ExprId`]) of a [`Routine`].
#[derive(Debug, Clone)]
pub struct Array<E> {
    /// What it is called in code.
    pub name: String,
    /// What it is.
    pub meaning: String,
    /// Its places, each with its unit.
    pub entries: Vec<(Entry, E)>,
}

/// One function on a graph of its own: arrays in, arrays out, straight-line arithmetic between.
/// [`c`](Self::c) emits it.
///
/// ```
/// use dynamics_codegen::emit::{Array, Entry, Routine};
/// use dynamics_codegen::graph::Graph;
///
/// let mut graph = Graph::new();
/// let angle = graph.symbol("angle");
/// let torque = {
///     let angle = graph.var(angle);
///     graph.scale(-4.5, angle)
/// };
/// let entry = |name: &str, unit: &str| Entry { name: name.into(), unit: unit.into() };
/// let routine = Routine {
///     name: "spring".into(),
///     meaning: "Pulls back".into(),
///     source: "Written by hand.".into(),
///     arguments: vec![Array {
///         name: "angles".into(),
///         meaning: "Where the joint is".into(),
///         entries: vec![(entry("angle", "rad"), angle)],
///     }],
///     results: vec![Array {
///         name: "torques".into(),
///         meaning: "What to do about it".into(),
///         entries: vec![(entry("torque", "N*m"), torque)],
///     }],
///     graph,
/// };
/// let [header, source] = routine.c();
/// assert!(header.text.contains("const spring_real angles[1],"));
/// assert!(source.text.contains("torques[0] = torque;"));
/// ```
#[derive(Debug, Clone)]
pub struct Routine {
    /// The function's name, and its files'.
    pub name: String,
    /// What it does, for its comment.
    pub meaning: String,
    /// What it was made from and how to make it again, for the first lines of the files.
    pub source: String,
    /// What it reads; the symbols of `graph`, each once.
    pub arguments: Vec<Array<SymbolId>>,
    /// What it computes; these read no symbol but those of `arguments`.
    pub results: Vec<Array<ExprId>>,
    /// Where it stands.
    pub graph: Graph,
}
