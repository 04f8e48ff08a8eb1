//! Expressions as a person would write them.

use super::{Binary, ExprId, Graph, Node, SymbolId, Unary};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;

/// Longer than this, as a tree, an expression is not written out: sharing can make
/// the text exponentially longer than the graph.
const MAX_TREE: u64 = 1000;

/// How tightly an expression holds together, from loose to tight. A part needs
/// brackets where its surroundings hold tighter than the part itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precedence {
    /// `a + b`, `a - b`
    Sum,
    /// `a * b`, `a / b`
    Product,
    /// `-a`
    Sign,
    /// `a^b`; in code, a method call on `a`
    Power,
    /// A name, a number, a call.
    Atom,
}

impl Node {
    /// How tightly the node holds its arguments together in written form.
    pub fn precedence(self) -> Precedence {
        match self {
            Self::Constant(bits) if f64::from_bits(bits) < 0.0 => Precedence::Sign,
            Self::Constant(_) | Self::Symbol(_) => Precedence::Atom,
            Self::Unary(Unary::Neg, _) => Precedence::Sign,
            Self::Unary(..) => Precedence::Atom,
            Self::Binary(Binary::Add | Binary::Sub, ..) => Precedence::Sum,
            Self::Binary(Binary::Mul | Binary::Div, ..) => Precedence::Product,
            Self::Binary(Binary::Pow, ..) => Precedence::Power,
            Self::Binary(..) => Precedence::Atom,
        }
    }
}

impl Unary {
    /// Its name in the model language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Neg => "-",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Exp => "exp",
            Self::Ln => "ln",
            Self::Sqrt => "sqrt",
            Self::Tanh => "tanh",
            Self::Abs => "abs",
            Self::Sign => "sign",
            Self::Step => "step",
        }
    }
}

impl Binary {
    /// Its name or operator in the model language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Sub => "-",
            Self::Mul => "*",
            Self::Div => "/",
            Self::Pow => "^",
            Self::Atan2 => "atan2",
            Self::Min => "min",
            Self::Max => "max",
        }
    }
}

impl Graph {
    /// `expr` in the model language, with the fewest brackets that keep its
    /// mathematical meaning and with repeated factors as powers. What is a
    /// [call](Self::call) is written as one. `name` says what a symbol is called.
    ///
    /// ```
    /// use dynamics_codegen::graph::Graph;
    ///
    /// let mut g = Graph::new();
    /// let (x, y) = (g.symbol("x"), g.symbol("y"));
    /// let names = |symbol| if symbol == x { "x".to_string() } else { "y".to_string() };
    /// let (x, y) = (g.var(x), g.var(y));
    /// let square = g.mul(x, x);
    /// let sum = g.add(square, y);
    /// let product = g.mul(sum, y);
    /// assert_eq!(g.display(product, names).to_string(), "y*(y + x^2)");
    /// ```
    pub fn display<F>(&self, expr: ExprId, name: F) -> Display<'_, F>
    where
        F: Fn(SymbolId) -> String,
    {
        Display {
            graph: self,
            expr,
            name,
        }
    }

    /// The nodes that `expr` is displayed with, each in front of those that it stands in. What a
    /// [call](Self::call) is computed with is not displayed.
    pub fn displayed(&self, expr: ExprId) -> Vec<ExprId> {
        let mut found = Vec::new();
        let mut open = BTreeSet::from([expr]);
        while let Some(last) = open.pop_last() {
            found.push(last);
            open.extend(self.displayed_children(last));
        }
        found.reverse();
        found
    }

    fn displayed_children(&self, expr: ExprId) -> Vec<ExprId> {
        match self.call_of(expr) {
            Some(call) => call.arguments.clone(),
            None => self.node(expr).children().collect(),
        }
    }

    /// How many nodes `expr` has when every shared part is written out again.
    fn tree_size(&self, expr: ExprId) -> u64 {
        let mut sizes: HashMap<ExprId, u64> = HashMap::new();
        for part in self.displayed(expr) {
            let children = self.displayed_children(part);
            let children = children.iter().map(|child| sizes[child]);
            sizes.insert(part, children.fold(1, u64::saturating_add));
        }
        sizes[&expr]
    }
}

/// See [`Graph::display`].
pub struct Display<'a, F> {
    graph: &'a Graph,
    expr: ExprId,
    name: F,
}

impl<F: Fn(SymbolId) -> String> fmt::Display for Display<'_, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.graph.tree_size(self.expr) > MAX_TREE {
            let operations = self.graph.operation_count(&[self.expr]);
            return write!(f, "({operations} operations, too long to write out)");
        }
        f.write_str(&self.text(self.expr))
    }
}

impl<F: Fn(SymbolId) -> String> Display<'_, F> {
    /// Nested at most [`MAX_TREE`] deep: small frames keep this off the limit of
    /// the stack.
    fn text(&self, expr: ExprId) -> String {
        if let Some(call) = self.graph.call_of(expr) {
            let arguments = call.arguments.iter().map(|&argument| self.text(argument));
            let arguments: Vec<String> = arguments.collect();
            return format!("{}({})", call.name, arguments.join(", "));
        }
        match self.graph.node(expr) {
            Node::Constant(bits) => number(f64::from_bits(bits)),
            Node::Symbol(symbol) => (self.name)(symbol),
            Node::Unary(Unary::Neg, x) => format!("-{}", self.within(x, Precedence::Product)),
            Node::Unary(op, x) => format!("{}({})", op.name(), self.text(x)),
            Node::Binary(Binary::Add, x, y) => self.sum(x, y),
            Node::Binary(Binary::Sub, x, y) => {
                let right = self.within(y, Precedence::Product);
                match right.strip_prefix('-') {
                    Some(positive) => format!("{} + {positive}", self.text(x)),
                    None => format!("{} - {right}", self.text(x)),
                }
            }
            Node::Binary(Binary::Mul, ..) => self.product(expr),
            Node::Binary(Binary::Div, x, y) => {
                let above = self.within(x, Precedence::Product);
                format!("{above}/{}", self.within(y, Precedence::Power))
            }
            Node::Binary(Binary::Pow, x, y) => {
                let base = self.within(x, Precedence::Atom);
                format!("{base}^{}", self.within(y, Precedence::Atom))
            }
            Node::Binary(op, x, y) => {
                format!("{}({}, {})", op.name(), self.text(x), self.text(y))
            }
        }
    }

    /// `expr`, in brackets if it holds together less tightly than `surroundings`.
    fn within(&self, expr: ExprId, surroundings: Precedence) -> String {
        let text = self.text(expr);
        let called = self.graph.call_of(expr).is_some();
        if !called && self.graph.node(expr).precedence() < surroundings {
            format!("({text})")
        } else {
            text
        }
    }

    fn sum(&self, x: ExprId, y: ExprId) -> String {
        let right = self.text(y);
        match right.strip_prefix('-') {
            Some(positive) => format!("{} - {positive}", self.text(x)),
            None => format!("{} + {right}", self.text(x)),
        }
    }

    /// A product: numbers first, then each factor once, with its power.
    fn product(&self, expr: ExprId) -> String {
        let (mut constant, mut factors) = (1.0, Vec::new());
        let mut powers: BTreeMap<ExprId, u32> = BTreeMap::new();
        let mut open = vec![expr];
        while let Some(part) = open.pop() {
            match self.graph.node(part) {
                Node::Binary(Binary::Mul, x, y) if self.graph.call_of(part).is_none() => {
                    open.extend([y, x])
                }
                Node::Constant(bits) => constant *= f64::from_bits(bits),
                _ => {
                    let power = powers.entry(part).or_insert(0);
                    if *power == 0 {
                        factors.push(part);
                    }
                    *power += 1;
                }
            }
        }
        let mut texts = Vec::new();
        if constant.abs() != 1.0 {
            texts.push(number(constant.abs()));
        }
        for factor in factors {
            texts.push(match powers[&factor] {
                1 => self.within(factor, Precedence::Product),
                n => format!("{}^{n}", self.within(factor, Precedence::Atom)),
            });
        }
        let sign = if constant < 0.0 { "-" } else { "" };
        format!("{sign}{}", texts.join("*"))
    }
}

/// The shortest decimal that reads back as the same number; `pi` by its name.
fn number(value: f64) -> String {
    use std::f64::consts::PI;
    if value == PI {
        "pi".to_string()
    } else if value.abs() < 1e15 && value.fract() == 0.0 {
        format!("{value}")
    } else {
        format!("{value:?}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(build: impl Fn(&mut Graph, ExprId, ExprId) -> ExprId) -> String {
        let mut g = Graph::new();
        let (sx, sy) = (g.symbol("x"), g.symbol("y"));
        let (x, y) = (g.var(sx), g.var(sy));
        let expr = build(&mut g, x, y);
        let names = |s| g.symbol_name(s).to_string();
        g.display(expr, names).to_string()
    }

    #[test]
    fn brackets_only_where_needed() {
        type Build = fn(&mut Graph, ExprId, ExprId) -> ExprId;
        let cases: [(Build, &str); 9] = [
            (
                |g, x, y| {
                    let s = g.add(x, y);
                    g.mul(s, x)
                },
                "x*(x + y)",
            ),
            (
                |g, x, y| {
                    let s = g.sub(x, y);
                    g.sub(y, s)
                },
                "y - (x - y)",
            ),
            (
                |g, x, y| {
                    let s = g.add(x, y);
                    g.sub(y, s)
                },
                "y - (x + y)",
            ),
            (
                |g, x, y| {
                    let s = g.mul(x, y);
                    let c = g.unary(Unary::Cos, y);
                    g.div(c, s)
                },
                "cos(y)/(x*y)",
            ),
            (
                |g, x, y| {
                    let s = g.div(x, y);
                    g.neg(s)
                },
                "-x/y",
            ),
            (
                |g, x, y| {
                    let s = g.sub(x, y);
                    let n = g.neg(s);
                    g.unary(Unary::Exp, n)
                },
                "exp(y - x)",
            ),
            (
                |g, x, y| {
                    let p = g.powi(x, 5);
                    let p = g.scale(-2.5, p);
                    g.mul(p, y)
                },
                "-2.5*y*x^5",
            ),
            (
                |g, x, y| {
                    let n = g.neg(y);
                    let e = g.unary(Unary::Exp, n);
                    g.add(e, x)
                },
                "x + exp(-y)",
            ),
            (
                |g, x, y| {
                    let s = g.add(x, y);
                    g.pow(s, y)
                },
                "(x + y)^y",
            ),
        ];
        for (build, expected) in cases {
            assert_eq!(written(build), expected);
        }
    }

    #[test]
    fn what_would_not_fit_is_summed_up() {
        let text = written(|g, x, y| {
            let mut e = x;
            for _ in 0..60 {
                let square = g.mul(e, e);
                e = g.add(square, y);
            }
            e
        });
        assert_eq!(text, "(120 operations, too long to write out)");
    }

    /// What is made of two expressions.
    type Made = fn(&mut Graph, ExprId, ExprId) -> ExprId;

    /// What a model calls a function of its own is written so, whatever it is computed with.
    #[test]
    fn functions_of_the_model_are_written_as_calls() {
        let curve = |g: &mut Graph, x: ExprId, y: ExprId| {
            let floor = g.constant(3.0);
            let bound = g.binary(Binary::Max, y, floor);
            let curve = g.sub(bound, x);
            let argument = g.scale(2.0, x);
            let read = g.sub(bound, argument);
            g.call(curve, "curve", &[y]);
            g.call(read, "late", &[argument]);
            (curve, read)
        };
        let cases: [(&str, Made); 3] = [
            ("-curve(y)", |g, curve, _| g.neg(curve)),
            ("late(2*x)*curve(y)^2", |g, curve, read| {
                let square = g.mul(curve, curve);
                g.mul(square, read)
            }),
            ("late(2*x) - curve(y)", |g, curve, read| g.sub(read, curve)),
        ];
        for (expected, build) in cases {
            let found = written(|g, x, y| {
                let (curve, read) = curve(g, x, y);
                build(g, curve, read)
            });
            assert_eq!(found, expected);
        }
    }
}
