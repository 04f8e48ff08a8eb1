//! Signs put where they cost nothing.
//!
//! A sum takes up the sign of one of its terms, and a constant factor that of the other factor;
//! `a − b` and `b − a` are one value with two signs. So of every value that some outputs need,
//! either it or its negative may be computed. What remains to be paid for are sums of which both
//! terms come as negatives, and outputs that do: [`Graph::settle_signs`] looks for a choice that
//! leaves few of them.

use super::{Binary, ExprId, Graph, Node, Unary};
use std::collections::HashMap;

/// How often every choice is looked at with the freedom to change what costs the same. Of the operations of
/// two arms' mass matrices it saves one in 213 and two in 427; twice as often is no better.
const WANDERING: usize = 5;
/// How often at most after that. With those arms none of it changes a count any more: it ends what
/// wandering may leave undone.
const SETTLING: usize = 10;

impl Graph {
    /// The same outputs, one each, with fewer changes of sign. What is `given` stays as it is, and what
    /// people have a name for keeps its sign, unless names contradict each other. The same to
    /// rounding: like terms that come to stand side by side are added up first.
    pub fn settle_signs(
        &mut self,
        outputs: &[ExprId],
        given: impl Fn(ExprId) -> bool,
    ) -> Vec<ExprId> {
        let mut values = Values::new(self, outputs, &given);
        values.choose();
        let settled = values.rebuild(self, outputs);
        let count = |outputs: &[ExprId]| self.reachable_beyond(outputs, &given).iter().count();
        if count(&settled) < count(outputs) {
            settled
        } else {
            outputs.to_vec()
        }
    }
}

/// A value, and whether its negative is meant.
type Signed = (usize, bool);

/// How a value is computed from others.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// As it stands: a symbol, a constant, what is given.
    Fixed(ExprId),
    /// A function of arguments that come with the right sign.
    Function(Node, [Option<Signed>; 2]),
    Sum(Signed, Signed),
    Product(usize, usize),
    Quotient(usize, usize),
    /// A positive constant times a value.
    Scaled(f64, usize),
}

/// What two values share that are one, but for the sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Identity {
    Expression(ExprId),
    /// Whether the second is taken away.
    Sum(usize, usize, bool),
    Product(usize, usize),
    Quotient(usize, usize),
    Scaled(u64, usize),
}

/// Where signs matter: a sum's two terms, whether they come as negatives; or what an output or a
/// function demands, beside `true`. It costs an operation if both are true.
type Place = [bool; 2];

/// The values that some outputs need; each needs earlier ones.
#[derive(Default)]
struct Values {
    kinds: Vec<Kind>,
    /// Each value, and whether it was first met as the negative of what its identity says.
    known: HashMap<Identity, Signed>,
    of: HashMap<ExprId, Signed>,
    /// Whether either sign will do.
    free: Vec<bool>,
    /// Whether the negative is computed.
    flipped: Vec<bool>,
    places: Vec<Place>,
    /// Per value: the places, and which side of them, that change with its sign.
    touched: Vec<Vec<(usize, usize)>>,
}

impl Values {
    fn new(graph: &Graph, outputs: &[ExprId], given: impl Fn(ExprId) -> bool) -> Self {
        let mut values = Self::default();
        let needed = graph.reachable_beyond(outputs, given);
        for expr in needed.iter() {
            values.add(graph, expr);
        }
        let demanded: Vec<Signed> = outputs
            .iter()
            .map(|&output| values.signed(output))
            .collect();
        values.find_places(graph, demanded);
        for expr in needed.iter().filter(|&expr| graph.label_of(expr).is_some()) {
            values.pin(values.of[&expr]);
        }
        values
    }

    /// Computes a value with this sign in any case; one that others are pinned against goes
    /// without.
    fn pin(&mut self, (value, negative): Signed) {
        let choices = self.choices(value);
        let flipped = choices.iter().filter(|&&choice| self.flipped[choice]);
        if (flipped.count() % 2 == 1) != negative
            && let Some(&last) = choices.iter().find(|&&choice| self.free[choice])
        {
            self.flip(last);
        }
        for choice in choices {
            self.free[choice] = false;
        }
    }

    /// The value of an expression; one that was not added stays as it is.
    fn signed(&mut self, expr: ExprId) -> Signed {
        if let Some(&known) = self.of.get(&expr) {
            return known;
        }
        let signed = self.entry((Identity::Expression(expr), false), Kind::Fixed(expr));
        self.of.insert(expr, signed);
        signed
    }

    fn entry(&mut self, (identity, negative): (Identity, bool), kind: Kind) -> Signed {
        let next = self.kinds.len();
        let (value, first) = *self.known.entry(identity).or_insert((next, negative));
        if value == next {
            self.kinds.push(kind);
            self.free
                .push(matches!(kind, Kind::Sum(..) | Kind::Scaled(..)));
            self.flipped.push(false);
        }
        (value, negative != first)
    }

    fn add(&mut self, graph: &Graph, expr: ExprId) {
        let node = graph.node(expr);
        let mut arguments = node.children().map(|x| self.signed(x));
        let [x, y] = [arguments.next(), arguments.next()];
        drop(arguments);
        let signed = match (node, x, y) {
            (Node::Unary(Unary::Neg, _), Some((value, negative)), _) => (value, !negative),
            (Node::Binary(op @ (Binary::Add | Binary::Sub), ..), Some(x), Some(y)) => {
                let y = (y.0, y.1 != (op == Binary::Sub));
                let (low, high) = (x.min(y), x.max(y));
                let identity = Identity::Sum(low.0, high.0, low.1 != high.1);
                self.entry((identity, low.1), Kind::Sum(x, y))
            }
            (Node::Binary(Binary::Mul, factor, _), Some(x), Some(y)) => {
                let (identity, kind) = match graph.as_constant(factor) {
                    Some(c) => (
                        Identity::Scaled(c.abs().to_bits(), y.0),
                        Kind::Scaled(c.abs(), y.0),
                    ),
                    None => (
                        Identity::Product(x.0.min(y.0), x.0.max(y.0)),
                        Kind::Product(x.0, y.0),
                    ),
                };
                let minus = graph.as_constant(factor).is_some_and(|c| c < 0.0);
                let (value, _) = self.entry((identity, false), kind);
                (value, minus != (x.1 != y.1))
            }
            (Node::Binary(Binary::Div, ..), Some(x), Some(y)) => {
                let identity = Identity::Quotient(x.0, y.0);
                let (value, _) = self.entry((identity, false), Kind::Quotient(x.0, y.0));
                (value, x.1 != y.1)
            }
            (Node::Constant(_) | Node::Symbol(_), ..) => self.signed(expr),
            _ => {
                let identity = Identity::Expression(expr);
                self.entry((identity, false), Kind::Function(node, [x, y]))
            }
        };
        self.of.insert(expr, signed);
    }

    /// The free values that the sign of one depends on; a square's sign depends on none.
    fn choices(&self, value: usize) -> Vec<usize> {
        let mut choices: Vec<usize> = Vec::new();
        let mut open = vec![value];
        while let Some(value) = open.pop() {
            match self.kinds[value] {
                Kind::Product(a, b) | Kind::Quotient(a, b) => open.extend([a, b]),
                Kind::Fixed(_) | Kind::Function(..) => {}
                Kind::Sum(..) | Kind::Scaled(..) => {
                    match choices.iter().position(|&known| known == value) {
                        Some(twice) => drop(choices.swap_remove(twice)),
                        None => choices.push(value),
                    }
                }
            }
        }
        choices
    }

    fn find_places(&mut self, graph: &Graph, mut demanded: Vec<Signed>) {
        self.touched = vec![Vec::new(); self.kinds.len()];
        for value in 0..self.kinds.len() {
            match self.kinds[value] {
                Kind::Sum(x, y) => {
                    let place = self.places.len();
                    self.places.push([false; 2]);
                    for (side, term) in [x, y].into_iter().enumerate() {
                        // A constant is written with either sign.
                        let fixed = match self.kinds[term.0] {
                            Kind::Fixed(expr) => graph.as_constant(expr).is_some(),
                            _ => false,
                        };
                        if !fixed {
                            self.touch(term, (place, side));
                            self.touched[value].push((place, side));
                        }
                    }
                }
                Kind::Function(_, arguments) => demanded.extend(arguments.into_iter().flatten()),
                _ => {}
            }
        }
        demanded.sort_unstable();
        demanded.dedup();
        for signed in demanded {
            self.places.push([false, true]);
            self.touch(signed, (self.places.len() - 1, 0));
        }
    }

    fn touch(&mut self, (value, negative): Signed, (place, side): (usize, usize)) {
        self.places[place][side] = negative;
        for choice in self.choices(value) {
            self.touched[choice].push((place, side));
        }
    }

    /// Flips what pays for itself, until nothing does. Before that, what makes no difference is
    /// flipped as well, all of it and back: it opens the way to what pays.
    fn choose(&mut self) {
        for round in 0..WANDERING {
            self.look_at_all(|flipped| flipped == (round % 2 == 0));
        }
        for _ in 0..SETTLING {
            if !self.look_at_all(|_| false) {
                break;
            }
        }
    }

    /// Flips each value that pays for itself, or that costs the same and may be flipped to what
    /// `tie` says of it; whether any was.
    fn look_at_all(&mut self, tie: impl Fn(bool) -> bool) -> bool {
        let mut changed = false;
        for value in (0..self.kinds.len()).rev() {
            if !self.free[value] {
                continue;
            }
            let (before, may_tie) = (self.cost(value), tie(self.flipped[value]));
            self.flip(value);
            let after = self.cost(value);
            if after < before || after == before && may_tie {
                changed = true;
            } else {
                self.flip(value);
            }
        }
        changed
    }

    fn flip(&mut self, value: usize) {
        self.flipped[value] ^= true;
        for &(place, side) in &self.touched[value] {
            self.places[place][side] ^= true;
        }
    }

    /// What the touched places cost.
    fn cost(&self, value: usize) -> usize {
        let mut places: Vec<usize> = (self.touched[value].iter())
            .map(|&(place, _)| place)
            .filter(|&place| self.places[place] == [true; 2])
            .collect();
        places.sort_unstable();
        places.dedup();
        places.len()
    }

    /// The outputs on the graph, with the signs that were chosen.
    fn rebuild(&self, graph: &mut Graph, outputs: &[ExprId]) -> Vec<ExprId> {
        // Per value what is computed, and whether that is the negative.
        let mut built: Vec<(ExprId, bool)> = Vec::with_capacity(self.kinds.len());
        for (&kind, &flip) in self.kinds.iter().zip(&self.flipped) {
            let expr = match kind {
                Kind::Fixed(expr) => (expr, false),
                Kind::Function(node, arguments) => {
                    let arguments =
                        arguments.map(|x| x.map(|(of, minus)| with_sign(graph, built[of], minus)));
                    (function(graph, node, arguments), false)
                }
                Kind::Sum(x, y) => {
                    let term = |(of, minus): Signed| {
                        let (expr, flipped): (ExprId, bool) = built[of];
                        (expr, (minus != flipped) != flip)
                    };
                    (sum(graph, term(x), term(y)), flip)
                }
                Kind::Product(a, b) => {
                    let (a, b) = (built[a], built[b]);
                    (graph.mul(a.0, b.0), a.1 != b.1)
                }
                Kind::Quotient(a, b) => {
                    let (a, b) = (built[a], built[b]);
                    (graph.div(a.0, b.0), a.1 != b.1)
                }
                Kind::Scaled(c, of) => {
                    let (expr, flipped) = built[of];
                    (
                        graph.scale(if flip == flipped { c } else { -c }, expr),
                        flip,
                    )
                }
            };
            built.push(expr);
        }
        let signed = outputs.iter().map(|output| self.of[output]);
        signed
            .map(|(value, minus)| with_sign(graph, built[value], minus))
            .collect()
    }
}

/// A value, or its negative if `minus`, from what is computed of it.
fn with_sign(graph: &mut Graph, (expr, flipped): (ExprId, bool), minus: bool) -> ExprId {
    if minus == flipped {
        expr
    } else {
        graph.neg(expr)
    }
}

/// `±x ± y`, each with whether it is taken away.
fn sum(graph: &mut Graph, x: (ExprId, bool), y: (ExprId, bool)) -> ExprId {
    match (x.1, y.1) {
        (false, false) => graph.add(x.0, y.0),
        (false, true) => graph.sub(x.0, y.0),
        (true, false) => graph.sub(y.0, x.0),
        (true, true) => {
            let sum = graph.add(x.0, y.0);
            graph.neg(sum)
        }
    }
}

fn function(graph: &mut Graph, node: Node, arguments: [Option<ExprId>; 2]) -> ExprId {
    match (node, arguments) {
        (Node::Unary(op, _), [Some(x), _]) => graph.unary(op, x),
        (Node::Binary(op, ..), [Some(x), Some(y)]) => graph.binary(op, x, y),
        _ => unreachable!("a function has its arguments"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x y z` and the symbols behind them.
    fn xyz() -> (Graph, [ExprId; 3]) {
        let mut g = Graph::new();
        let symbols = ["x", "y", "z"].map(|name| g.symbol(name));
        let exprs = symbols.map(|symbol| g.var(symbol));
        (g, exprs)
    }

    fn settled(g: &mut Graph, outputs: &[ExprId]) -> Vec<ExprId> {
        let settled = g.settle_signs(outputs, |_| false);
        for values in [[0.3, -1.2, 0.7], [-2.0, 0.1, 5.0]] {
            assert_eq!(g.evaluate(outputs, &values), g.evaluate(&settled, &values));
        }
        settled
    }

    #[test]
    fn a_difference_and_its_negative_are_one() {
        let (mut g, [x, y, z]) = xyz();
        let (forth, back) = (g.sub(x, y), g.sub(y, x));
        let (first, second) = (g.mul(forth, z), g.mul(back, x));
        let (first, second) = (g.add(first, y), g.add(second, z));
        assert_eq!(g.operation_count(&[first, second]), 6);
        let outputs = settled(&mut g, &[first, second]);
        assert_eq!(g.operation_count(&outputs), 5);
    }

    #[test]
    fn a_sum_of_negatives_is_the_negative_of_a_sum() {
        let (mut g, [x, y, z]) = xyz();
        let (a, b) = (g.mul(x, y), g.mul(y, z));
        let (a, b) = (g.neg(a), g.sub(z, b));
        // z − (x y − (z − y z)) and (z − y z) x: no sign is left.
        let inner = g.sub(a, b);
        let (first, second) = (g.add(z, inner), g.mul(b, x));
        let outputs = settled(&mut g, &[first, second]);
        let negs = g.reachable(&outputs);
        let negs = negs
            .iter()
            .filter(|&e| matches!(g.node(e), Node::Unary(Unary::Neg, _)));
        assert_eq!(negs.count(), 0);
    }

    #[test]
    fn constant_factors_take_up_signs() {
        let (mut g, [x, y, z]) = xyz();
        let (forth, back) = (g.scale(2.0, x), g.scale(-2.0, x));
        let outputs = [g.add(forth, y), g.add(back, z)];
        assert_eq!(g.operation_count(&outputs), 4);
        let outputs = settled(&mut g, &outputs);
        assert_eq!(g.operation_count(&outputs), 3);
    }

    #[test]
    fn what_has_a_name_keeps_its_sign() {
        let (mut g, [x, y, z]) = xyz();
        let (forth, back) = (g.sub(x, y), g.sub(y, x));
        g.label(back, "gap");
        let (first, second) = (g.mul(forth, z), g.mul(back, x));
        let outputs = [g.add(first, y), g.add(second, z)];
        let outputs = settled(&mut g, &outputs);
        assert!(g.reachable(&outputs).iter().any(|expr| expr == back));
    }

    #[test]
    fn what_is_given_stays() {
        let (mut g, [x, y, z]) = xyz();
        let (forth, back) = (g.sub(x, y), g.sub(y, x));
        let (first, second) = (g.mul(forth, z), g.mul(back, x));
        let outputs = [g.add(first, y), g.add(second, z)];
        let settled = g.settle_signs(&outputs, |expr| expr == back);
        assert!(g.reachable(&settled).iter().any(|expr| expr == back));
        assert_eq!(
            g.evaluate(&outputs, &[1.0, 2.5, 3.0]),
            g.evaluate(&settled, &[1.0, 2.5, 3.0])
        );
    }
}
