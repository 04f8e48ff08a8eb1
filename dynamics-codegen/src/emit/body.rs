//! The straight-line body of a function, in no particular language.
//!
//! An operation gets a temporary where it is used more than once, where the model has
//! a name for it, where it is a result, or where its line would grow too long; every
//! other operation is written inside the one that uses it. So each operation of the
//! graph is computed exactly once, in the order in which the graph holds it.

use super::naming::Locals;
use super::symbols::{Role, Symbols};
use super::telling::telling_name;
use crate::graph::{Binary, ExprId, Graph, Node, SymbolId, Unary};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

/// Longest right-hand side, in characters.
const WIDTH: usize = 58;
/// Longest function call inside a line.
const CALL_WIDTH: usize = 44;

/// An expression over temporaries, as it is written in one line.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Term {
    Constant(f64),
    Symbol(SymbolId),
    Local(usize),
    Unary(Unary, Box<Term>),
    Binary(Binary, Box<Term>, Box<Term>),
    /// A product and a sum that a processor may round once.
    Fused(Fused, Box<[Term; 3]>),
}

/// What is done with `x`, `y` and `z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fused {
    /// `x·y + z`
    MulAdd,
    /// `x·y − z`
    MulSub,
    /// `z − x·y`
    NegMulAdd,
}

impl Fused {
    /// The method of `Scalar`.
    pub fn name(self) -> &'static str {
        match self {
            Self::MulAdd => "mul_add",
            Self::MulSub => "mul_sub",
            Self::NegMulAdd => "neg_mul_add",
        }
    }
}

/// One line of the body.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Statement {
    /// `let local = value;`
    Let { local: usize, value: Term },
    /// `let (sine, cosine) = argument.sin_cos();`
    SinCos {
        sine: usize,
        cosine: usize,
        argument: Term,
    },
    /// The same for several arguments, none of which depends on another's sine or cosine.
    SinCosEach(Vec<Circular>),
}

/// A sine and a cosine of one argument.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Circular {
    pub sine: usize,
    pub cosine: usize,
    pub argument: Term,
}

/// A function's body.
#[derive(Debug, Clone, Default)]
pub(super) struct Body {
    /// Names of the temporaries; before them, how many places of given results.
    pub locals: Vec<String>,
    pub given: usize,
    pub statements: Vec<Statement>,
    /// One constant, symbol or temporary per output.
    pub results: Vec<Term>,
    /// What the body reads of its arguments.
    pub reads: BTreeSet<Role>,
    /// The numbers it contains.
    pub constants: Vec<f64>,
}

impl Body {
    /// The body that computes `outputs`, each with a wish for its temporary's name, from what
    /// stands in `given` places.
    pub fn new(
        graph: &Graph,
        symbols: &Symbols,
        outputs: &[(ExprId, String)],
        given: BTreeMap<ExprId, String>,
    ) -> Self {
        let mut builder = Builder::new(graph, symbols, outputs, given);
        for expr in builder.order.clone() {
            builder.visit(expr);
        }
        builder.body.results = outputs
            .iter()
            .map(|(output, _)| builder.take(*output))
            .collect();
        gather_circular(&mut builder.body.statements);
        builder.body
    }

    /// The numbers in some of the statements.
    pub fn constants_of(&self, statements: Range<usize>) -> Vec<f64> {
        let mut constants = Vec::new();
        for statement in &self.statements[statements] {
            match statement {
                Statement::Let { value, .. } => constants_in(value, &mut constants),
                Statement::SinCos { argument, .. } => constants_in(argument, &mut constants),
                Statement::SinCosEach(group) => {
                    let arguments = group.iter().map(|c| &c.argument);
                    arguments.for_each(|x| constants_in(x, &mut constants));
                }
            }
        }
        constants
    }

    /// Whether anything is read of the arguments that `role` selects.
    pub fn reads_any(&self, role: impl Fn(Role) -> bool) -> bool {
        self.reads.iter().any(|&r| role(r))
    }
}

struct Builder<'a> {
    graph: &'a Graph,
    symbols: &'a Symbols,
    order: Vec<ExprId>,
    needed: BTreeSet<ExprId>,
    uses: HashMap<ExprId, usize>,
    wishes: HashMap<ExprId, &'a str>,
    /// What stands for each node: written out until it is bound.
    terms: HashMap<ExprId, Term>,
    names: Locals,
    body: Body,
}

impl<'a> Builder<'a> {
    fn new(
        graph: &'a Graph,
        symbols: &'a Symbols,
        outputs: &'a [(ExprId, String)],
        given: BTreeMap<ExprId, String>,
    ) -> Self {
        let ids: Vec<ExprId> = outputs.iter().map(|(id, _)| *id).collect();
        let order = graph.reachable_beyond(&ids, |expr| given.contains_key(&expr));
        let order: Vec<ExprId> = order.iter().collect();
        let mut uses = HashMap::new();
        for &expr in &order {
            for child in graph.node(expr).children() {
                *uses.entry(child).or_insert(0) += 1;
            }
        }
        let mut wishes = HashMap::new();
        for (id, wish) in outputs {
            wishes.entry(*id).or_insert(wish.as_str());
        }
        Self {
            graph,
            symbols,
            needed: order.iter().copied().collect(),
            order,
            uses,
            wishes,
            terms: (given.keys().enumerate())
                .map(|(place, &expr)| (expr, Term::Local(place)))
                .collect(),
            names: symbols.locals(),
            body: Body {
                given: given.len(),
                locals: given.into_values().collect(),
                ..Body::default()
            },
        }
    }

    fn visit(&mut self, expr: ExprId) {
        let term = match self.graph.node(expr) {
            Node::Constant(bits) => {
                self.body.constants.push(f64::from_bits(bits));
                Term::Constant(f64::from_bits(bits))
            }
            Node::Symbol(symbol) => {
                self.body.reads.insert(self.symbols.get(symbol).role);
                Term::Symbol(symbol)
            }
            Node::Unary(op @ (Unary::Sin | Unary::Cos), x) => return self.circular(expr, op, x),
            Node::Unary(op, x) => self.fit(
                |this| {
                    let x = this.take(x);
                    Term::Unary(op, Box::new(x))
                },
                &[x],
            ),
            Node::Binary(op @ (Binary::Add | Binary::Sub), x, y)
                if self.product(x).or(self.product(y)).is_some() =>
            {
                self.fused(op, x, y)
            }
            Node::Binary(op, x, y) => self.fit(
                |this| {
                    let (x, y) = (this.take(x), this.take(y));
                    Term::Binary(op, Box::new(x), Box::new(y))
                },
                &[x, y],
            ),
        };
        self.terms.insert(expr, term);
        if self.graph.node(expr).is_operation() && self.wants_a_name(expr) {
            self.bind(expr);
        }
    }

    fn wants_a_name(&self, expr: ExprId) -> bool {
        self.uses.get(&expr).is_some_and(|&n| n > 1)
            || self.wishes.contains_key(&expr)
            || self.graph.label_of(expr).is_some()
    }

    /// The term for an operation on `children`; binds the widest of them until the
    /// line is short enough.
    fn fit(&mut self, build: impl Fn(&Self) -> Term, children: &[ExprId]) -> Term {
        loop {
            let term = build(self);
            let widest = children
                .iter()
                .filter(|child| !is_atom(&self.terms[child]))
                .max_by_key(|&&child| self.width(&self.take(child)));
            match widest {
                Some(&child) if self.width(&term) > limit(&term) => self.bind(child),
                _ => return term,
            }
        }
    }

    /// The factors of a product that is written where it is used.
    fn product(&self, expr: ExprId) -> Option<[ExprId; 2]> {
        match (self.graph.node(expr), &self.terms[&expr]) {
            (Node::Binary(Binary::Mul, a, b), Term::Binary(Binary::Mul, ..)) => {
                // A constant reads better behind what it scales.
                let swap = self.graph.as_constant(a).is_some();
                Some(if swap { [b, a] } else { [a, b] })
            }
            _ => None,
        }
    }

    /// A sum or difference with a product on one side.
    fn fused(&mut self, op: Binary, x: ExprId, y: ExprId) -> Term {
        let (fused, factors, rest) = match (op, self.product(x), self.product(y)) {
            (Binary::Add, Some(factors), _) => (Fused::MulAdd, factors, y),
            (Binary::Add, None, Some(factors)) => (Fused::MulAdd, factors, x),
            (_, _, Some(factors)) => (Fused::NegMulAdd, factors, x),
            (_, Some(factors), None) => (Fused::MulSub, factors, y),
            (_, None, None) => unreachable!("only called with a product"),
        };
        let children = [factors[0], factors[1], rest];
        let build = |this: &Self| Term::Fused(fused, Box::new(children.map(|c| this.take(c))));
        let term = self.fit(build, &children);
        if self.width(&term) <= WIDTH {
            return term;
        }
        // Three long names: the product gets a line of its own, of what its factors are now.
        for product in [x, y] {
            if self.product(product).is_some()
                && let Node::Binary(_, a, b) = self.graph.node(product)
            {
                let (a, b) = (self.take(a), self.take(b));
                let term = Term::Binary(Binary::Mul, Box::new(a), Box::new(b));
                self.terms.insert(product, term);
            }
        }
        let build = |this: &Self| Term::Binary(op, Box::new(this.take(x)), Box::new(this.take(y)));
        self.fit(build, &[x, y])
    }

    /// A sine or cosine, together with its partner if that is needed too.
    fn circular(&mut self, expr: ExprId, op: Unary, argument: ExprId) {
        if self.terms.contains_key(&expr) {
            return;
        }
        let other = if op == Unary::Sin {
            Unary::Cos
        } else {
            Unary::Sin
        };
        let partner = self.needed_unary(other, argument);
        let term = self.take(argument);
        let name = self.claim(expr);
        match partner {
            None => {
                let value = Term::Unary(op, Box::new(term));
                self.push_let(expr, name, value);
            }
            Some(partner) => {
                let partner_name = self.claim(partner);
                let (first, second) = (self.local(expr, name), self.local(partner, partner_name));
                let (sine, cosine) = if op == Unary::Sin {
                    (first, second)
                } else {
                    (second, first)
                };
                self.body.statements.push(Statement::SinCos {
                    sine,
                    cosine,
                    argument: term,
                });
            }
        }
    }

    fn needed_unary(&self, op: Unary, x: ExprId) -> Option<ExprId> {
        self.graph
            .find(Node::Unary(op, x))
            .filter(|id| self.needed.contains(id))
    }

    /// What is written where `expr` is used.
    fn take(&self, expr: ExprId) -> Term {
        // Children come before their parents, so the term is there.
        self.terms[&expr].clone()
    }

    fn bind(&mut self, expr: ExprId) {
        let value = self.take(expr);
        let name = self.claim(expr);
        self.push_let(expr, name, value);
    }

    fn push_let(&mut self, expr: ExprId, name: String, value: Term) {
        let local = self.local(expr, name);
        self.body.statements.push(Statement::Let { local, value });
    }

    fn local(&mut self, expr: ExprId, name: String) -> usize {
        self.body.locals.push(name);
        let local = self.body.locals.len() - 1;
        self.terms.insert(expr, Term::Local(local));
        local
    }

    /// A name: the model's, the result's, what the structure tells, or a number.
    fn claim(&mut self, expr: ExprId) -> String {
        let told = self.graph.label_of(expr).map(str::to_string);
        let told = told.or_else(|| self.wishes.get(&expr).map(|wish| wish.to_string()));
        let told = told.or_else(|| telling_name(self.graph, self.symbols, expr));
        match told {
            Some(wish) => self.names.claim(&wish),
            None => self.names.number(),
        }
    }

    /// About how many characters a term takes.
    fn width(&self, term: &Term) -> usize {
        match term {
            Term::Constant(value) => format!("{value:?}").len() + "T::from_f64()".len(),
            Term::Symbol(symbol) => self.symbols.width(*symbol),
            Term::Local(local) => self.body.locals[*local].len(),
            Term::Unary(_, x) => self.width(x) + 7,
            Term::Binary(Binary::Add | Binary::Sub | Binary::Mul | Binary::Div, x, y) => {
                self.width(x) + self.width(y) + 5
            }
            Term::Binary(_, x, y) => self.width(x) + self.width(y) + 8,
            Term::Fused(fused, terms) => {
                let inside: usize = terms.iter().map(|x| self.width(x)).sum();
                inside + fused.name().len() + 5
            }
        }
    }
}

fn limit(term: &Term) -> usize {
    match term {
        Term::Unary(Unary::Neg, _) => WIDTH,
        Term::Binary(Binary::Add | Binary::Sub | Binary::Mul | Binary::Div, ..) => WIDTH,
        _ => CALL_WIDTH,
    }
}

fn is_atom(term: &Term) -> bool {
    matches!(term, Term::Constant(_) | Term::Symbol(_) | Term::Local(_))
}

/// Puts sines and cosines that can be computed side by side into one statement, behind what
/// their arguments need.
fn gather_circular(statements: &mut Vec<Statement>) {
    let mut dependent = BTreeSet::new();
    let mut needed = BTreeSet::new();
    let mut together = BTreeSet::new();
    for (index, statement) in statements.iter().enumerate() {
        match statement {
            Statement::Let { local, value } => {
                if reads(value).iter().any(|local| dependent.contains(local)) {
                    dependent.insert(*local);
                }
            }
            Statement::SinCos {
                sine,
                cosine,
                argument,
            } => {
                let own = reads(argument);
                if !own.iter().any(|local| dependent.contains(local)) {
                    together.insert(index);
                    needed.extend(own);
                }
                dependent.extend([*sine, *cosine]);
            }
            Statement::SinCosEach(_) => {}
        }
    }
    if together.len() < 2 {
        return;
    }
    for statement in statements.iter().rev() {
        if let Statement::Let { local, value } = statement
            && needed.contains(local)
        {
            needed.extend(reads(value));
        }
    }
    let (mut before, mut group, mut after) = (Vec::new(), Vec::new(), Vec::new());
    for (index, statement) in std::mem::take(statements).into_iter().enumerate() {
        match statement {
            Statement::SinCos {
                sine,
                cosine,
                argument,
            } if together.contains(&index) => group.push(Circular {
                sine,
                cosine,
                argument,
            }),
            Statement::Let { local, .. } if needed.contains(&local) => before.push(statement),
            _ => after.push(statement),
        }
    }
    *statements = before;
    statements.push(Statement::SinCosEach(group));
    statements.extend(after);
}

/// The temporaries that a term reads.
pub(super) fn reads(term: &Term) -> BTreeSet<usize> {
    match term {
        Term::Constant(_) | Term::Symbol(_) => BTreeSet::new(),
        Term::Local(local) => BTreeSet::from([*local]),
        Term::Unary(_, x) => reads(x),
        Term::Binary(_, x, y) => &reads(x) | &reads(y),
        Term::Fused(_, terms) => terms.iter().flat_map(reads).collect(),
    }
}

fn constants_in(term: &Term, found: &mut Vec<f64>) {
    match term {
        Term::Constant(value) => found.push(*value),
        Term::Symbol(_) | Term::Local(_) => {}
        Term::Unary(_, x) => constants_in(x, found),
        Term::Binary(_, x, y) => {
            constants_in(x, found);
            constants_in(y, found);
        }
        Term::Fused(_, terms) => terms.iter().for_each(|x| constants_in(x, found)),
    }
}
