//! Functions that begin with what another one computes.
//!
//! The equation of motion contains the mass matrix, and the residuals' derivatives are those of
//! the inverse dynamics but for a few entries. Where such a part is long it is not written
//! twice: the function calls the other one, and goes on from its results.

use super::counts::OperationCount;
use super::plan::{Function, Quantity};
use crate::graph::{ExprId, Graph, Node, Unary};
use std::collections::HashMap;

/// Parts of fewer operations are written out again, which is quicker.
const SHORTEST: usize = 4000;

/// What a function calls before it computes.
#[derive(Debug, Clone)]
pub(super) struct Given {
    /// Which of the plan's functions.
    pub function: usize,
    /// Where its results stand.
    pub places: HashMap<ExprId, Place>,
}

/// Where a result stands.
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// The quantity, if the function has several.
    quantity: Option<String>,
    /// `[1][2]`
    entry: String,
    /// Whether the negative of it stands there.
    negative: bool,
}

impl Given {
    fn new(graph: &Graph, index: usize, function: &Function) -> Self {
        let mut places = HashMap::new();
        for quantity in &function.quantities {
            let name = function.fused.then(|| quantity.name.clone());
            for (entry, &expr) in quantity.entries.iter().enumerate() {
                let mut add = |expr: ExprId, negative| {
                    if graph.node(expr).is_operation() {
                        let (quantity, entry) = (name.clone(), place(quantity, entry));
                        let place = Place {
                            quantity,
                            entry,
                            negative,
                        };
                        places.entry(expr).or_insert(place);
                    }
                };
                add(expr, false);
                // Sums take up a sign: they contain what stands behind it.
                if let Node::Unary(Unary::Neg, inner) = graph.node(expr) {
                    add(inner, true);
                }
            }
        }
        Self {
            function: index,
            places,
        }
    }

    /// The text of each place: `given.mass_matrix[0][1]`, with the language's `access`.
    pub fn texts<'a>(&'a self, access: &'a str) -> impl Iterator<Item = (ExprId, String)> + 'a {
        self.places.iter().map(move |(&expr, place)| {
            let member = place
                .quantity
                .as_ref()
                .map(|name| format!("{access}{name}"));
            let text = format!("given{}{}", member.unwrap_or_default(), place.entry);
            let text = if place.negative {
                format!("(-{text})")
            } else {
                text
            };
            (expr, text)
        })
    }
}

/// The earlier function that spares `function` most, if any spares it enough and computes
/// hardly anything in vain.
pub(super) fn giver(graph: &Graph, earlier: &[Function], function: &Function) -> Option<Given> {
    let outputs = function.entries();
    let whole = OperationCount::of(graph, &outputs).total();
    if whole < SHORTEST || function.solved.is_some() {
        return None;
    }
    let mut best: Option<(usize, Given)> = None;
    for (index, other) in earlier.iter().enumerate() {
        let callable = (function.takes_acceleration() || !other.takes_acceleration())
            && (function.takes_multipliers() || !other.takes_multipliers());
        let cost = OperationCount::of(graph, &other.entries()).total();
        if other.solved.is_some() || !callable || cost < SHORTEST {
            continue;
        }
        let given = Given::new(graph, index, other);
        let own = OperationCount::beyond(graph, &outputs, &given).total();
        let in_vain = (own + cost).saturating_sub(whole);
        let enough = whole - own >= SHORTEST && 10 * in_vain <= whole;
        if enough && best.as_ref().is_none_or(|(least, _)| own < *least) {
            best = Some((own, given));
        }
    }
    best.map(|(_, given)| given)
}

/// `[1][2]`: where entry `index` of a quantity stands.
pub(super) fn place(quantity: &Quantity, index: usize) -> String {
    let mut rest = index;
    let mut place = String::new();
    for &length in quantity.shape().iter().rev() {
        place.insert_str(0, &format!("[{}]", rest % length));
        rest /= length;
    }
    place
}
