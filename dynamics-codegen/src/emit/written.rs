//! Terms as text: precedence and brackets, the same for every language.

use super::body::{Fused, Term};
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

    /// A product and a sum. Where a language has nothing for it, the two operations.
    fn fused(&self, op: Fused, [x, y, z]: [Written; 3]) -> Written {
        let (loose, tight) = (Precedence::Product, Precedence::Sign);
        let product = Written {
            text: format!("{} * {}", x.within(loose), y.within(tight)),
            precedence: loose,
        };
        let (sum, product_first) = (Precedence::Sum, Precedence::Product);
        let text = match op {
            Fused::MulAdd => format!("{} + {}", product.within(sum), z.within(product_first)),
            Fused::MulSub => format!("{} - {}", product.within(sum), z.within(product_first)),
            Fused::NegMulAdd => format!("{} - {}", z.within(sum), product.within(product_first)),
        };
        Written {
            text,
            precedence: sum,
        }
    }

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
            Term::Fused(op, terms) => {
                let [x, y, z] = terms.as_ref();
                self.fused(*op, [write(x), write(y), write(z)])
            }
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
