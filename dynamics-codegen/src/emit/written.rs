//! Terms as text: precedence and brackets, the same for every language.

use super::body::Term;
use crate::graph::{Binary, Precedence, SymbolId, Unary};

/// A piece of text with how tightly it holds together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Written {
    pub text: String,
    pub precedence: Precedence,
}

impl Written {
    pub fn atom(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            precedence: Precedence::Atom,
        }
    }

    /// In brackets if its surroundings hold tighter than it does.
    pub fn within(self, surroundings: Precedence) -> String {
        if self.precedence < surroundings {
            format!("({})", self.text)
        } else {
            self.text
        }
    }
}

/// What a language has to say about expressions.
pub(super) trait Language {
    /// A number.
    fn constant(&self, value: f64) -> Written;
    /// An argument of the model's functions.
    fn symbol(&self, id: SymbolId) -> String;
    /// A function of one argument, other than the sign.
    fn function(&self, op: Unary, x: Written) -> Written;
    /// A function of two arguments, other than the four operations.
    fn function_of_two(&self, op: Binary, x: Written, y: Written) -> Written;

    /// A term, evaluated in the order of the graph. A right operand of equal rank
    /// keeps its brackets: they are the order of evaluation.
    fn write(&self, term: &Term, locals: &[String]) -> Written {
        let write = |x: &Term| self.write(x, locals);
        let operation = |sign: &str, precedence, x: &Term, left, y: &Term, right| Written {
            text: format!(
                "{} {sign} {}",
                write(x).within(left),
                write(y).within(right)
            ),
            precedence,
        };
        match term {
            Term::Constant(value) => self.constant(*value),
            Term::Symbol(id) => Written::atom(self.symbol(*id)),
            Term::Local(index) => Written::atom(&locals[*index]),
            Term::Unary(Unary::Neg, x) => Written {
                text: format!("-{}", write(x).within(Precedence::Atom)),
                precedence: Precedence::Sign,
            },
            Term::Unary(op, x) => self.function(*op, write(x)),
            Term::Binary(op, x, y) => match op {
                Binary::Add | Binary::Sub => {
                    let (loose, tight) = (Precedence::Sum, Precedence::Product);
                    operation(op.name(), loose, x, loose, y, tight)
                }
                Binary::Mul | Binary::Div => {
                    let (loose, tight) = (Precedence::Product, Precedence::Sign);
                    operation(op.name(), loose, x, loose, y, tight)
                }
                _ => self.function_of_two(*op, write(x), write(y)),
            },
        }
    }
}
