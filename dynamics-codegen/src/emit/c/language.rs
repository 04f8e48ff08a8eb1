//! C's numbers, names and functions.

use crate::emit::symbols::{Role, Symbols};
use crate::emit::written::{Language, Written};
use crate::graph::{Binary, Precedence, SymbolId, Unary};

/// Expressions of the model's real type.
pub(super) struct C<'a> {
    pub symbols: &'a Symbols,
}

impl Language for C<'_> {
    fn constant(&self, value: f64) -> Written {
        Written::atom(real(value))
    }

    fn symbol(&self, id: SymbolId) -> String {
        let symbol = self.symbols.get(id);
        match symbol.role {
            Role::Parameter(_) => format!("p->{}", symbol.code),
            _ => symbol.code.clone(),
        }
    }

    fn function(&self, op: Unary, x: Written) -> Written {
        Written::atom(format!("{}({})", unary(op), x.text))
    }

    fn function_of_two(&self, op: Binary, x: Written, y: Written) -> Written {
        Written::atom(format!("{}({}, {})", binary(op), x.text, y.text))
    }
}

/// A number, converted to the real type; exact in `double`.
pub(super) fn real(value: f64) -> String {
    if value.is_nan() {
        return "REAL(NAN)".to_string();
    }
    if value.is_infinite() {
        let sign = if value < 0.0 { "-" } else { "" };
        return format!("REAL({sign}INFINITY)");
    }
    format!("REAL({value:?})")
}

/// The macro or helper that stands for a function.
fn unary(op: Unary) -> &'static str {
    match op {
        Unary::Sin => "SIN",
        Unary::Cos => "COS",
        Unary::Tan => "TAN",
        Unary::Asin => "ASIN",
        Unary::Acos => "ACOS",
        Unary::Atan => "ATAN",
        Unary::Exp => "EXP",
        Unary::Ln => "LOG",
        Unary::Sqrt => "SQRT",
        Unary::Tanh => "TANH",
        Unary::Abs => "FABS",
        Unary::Sign => "sign_of",
        Unary::Step => "step_of",
        Unary::Neg => "-",
    }
}

fn binary(op: Binary) -> &'static str {
    match op {
        Binary::Pow => "POW",
        Binary::Atan2 => "ATAN2",
        Binary::Min => "FMIN",
        Binary::Max => "FMAX",
        Binary::Add | Binary::Sub | Binary::Mul | Binary::Div => op.name(),
    }
}

/// Functions of `<math.h>` behind macros that choose the precision: macro, arguments,
/// name in `double` (in `float` with an `f` behind it).
pub(super) const MATH: [(&str, &str, &str); 15] = [
    ("SIN", "x", "sin"),
    ("COS", "x", "cos"),
    ("TAN", "x", "tan"),
    ("ASIN", "x", "asin"),
    ("ACOS", "x", "acos"),
    ("ATAN", "x", "atan"),
    ("ATAN2", "y, x", "atan2"),
    ("EXP", "x", "exp"),
    ("LOG", "x", "log"),
    ("SQRT", "x", "sqrt"),
    ("TANH", "x", "tanh"),
    ("FABS", "x", "fabs"),
    ("POW", "x, y", "pow"),
    ("FMIN", "x, y", "fmin"),
    ("FMAX", "x, y", "fmax"),
];

/// Functions that C lacks: name, documentation, value.
pub(super) const HELPERS: [(&str, &str, &str); 2] = [
    (
        "sign_of",
        "-1, 0 or 1.",
        "(x > REAL(0.0)) ? REAL(1.0) : ((x < REAL(0.0)) ? REAL(-1.0) : x)",
    ),
    (
        "step_of",
        "1 where x is positive, else 0.",
        "(x > REAL(0.0)) ? REAL(1.0) : REAL(0.0)",
    ),
];

/// `a` in brackets where the argument of a function needs none.
pub(super) fn argument(written: Written) -> String {
    written.within(Precedence::Sum)
}
