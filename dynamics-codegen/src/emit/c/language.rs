//! C's numbers, names and functions.

use super::long::{Numbers, declare};
use super::{Lines, comment};
use crate::emit::body::{Body, Statement, Term};
use crate::emit::symbols::{Role, Symbols};
use crate::emit::written::{Language, Written};
use crate::graph::{Binary, Precedence, SymbolId, Unary};

/// Expressions of the model's real type.
pub(super) struct C<'a> {
    pub symbols: &'a Symbols,
    /// Numbers that have names.
    pub numbers: &'a Numbers,
}

impl Language for C<'_> {
    fn constant(&self, value: f64) -> Written {
        match self.numbers.name(value) {
            Some(name) => Written::atom(name),
            None => Written::atom(real(value)),
        }
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
        Binary::Min => "min_of",
        Binary::Max => "max_of",
        Binary::Add | Binary::Sub | Binary::Mul | Binary::Div => op.name(),
    }
}

/// Functions of `<math.h>` behind macros that choose the precision: macro, arguments,
/// name in `double` (in `float` with an `f` behind it).
pub(super) const MATH: [(&str, &str, &str); 13] = [
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
];

/// Functions that C lacks, or has otherwise (`fmin` and `fmax` drop a NaN, which here goes on as in
/// `dynamics::Scalar`): name, arguments, documentation, value.
pub(super) const HELPERS: [(&str, &[&str], &str, &str); 4] = [
    (
        "sign_of",
        &["x"],
        "-1, 0 or 1; NaN at NaN.",
        "(x > REAL(0.0)) ? REAL(1.0) : ((x < REAL(0.0)) ? REAL(-1.0) : x)",
    ),
    (
        "step_of",
        &["x"],
        "1 where x is positive, else 0; NaN at NaN.",
        "(x > REAL(0.0)) ? REAL(1.0) : ((x <= REAL(0.0)) ? REAL(0.0) : x)",
    ),
    (
        "min_of",
        &["x", "y"],
        "The smaller one; NaN if either is.",
        "((x < y) || (x != x)) ? x : y",
    ),
    (
        "max_of",
        &["x", "y"],
        "The larger one; NaN if either is.",
        "((x > y) || (x != x)) ? x : y",
    ),
];

/// `a` in brackets where the argument of a function needs none.
pub(super) fn argument(written: Written) -> String {
    written.within(Precedence::Sum)
}

/// Constants, functions and helpers in the chosen precision; those that `code` uses.
pub(super) fn preamble(w: &mut Lines, prefix: &str, code: &str) {
    w.line(&format!("#define REAL(x) (({prefix}_real)(x))"));
    let used = |name: &str| code.contains(&format!("{name}("));
    let functions: Vec<_> = MATH.iter().filter(|(name, ..)| used(name)).collect();
    if !functions.is_empty() {
        for (branch, ending) in [("#ifdef DYNAMICS_FLOAT", "f"), ("#else", "")] {
            w.line(branch);
            for (name, arguments, function) in &functions {
                w.line(&format!(
                    "#define {name}({arguments}) {function}{ending}({arguments})"
                ));
            }
        }
        w.line("#endif");
    }
    w.blank();
    for (name, arguments, doc, value) in HELPERS {
        if used(name) {
            let arguments = arguments.iter().map(|x| format!("{prefix}_real {x}"));
            let arguments = arguments.collect::<Vec<_>>().join(", ");
            comment(w, 0, doc);
            w.line(&format!("static {prefix}_real {name}({arguments})"));
            w.line("{");
            w.line(&format!("    return {value};"));
            w.line("}");
            w.blank();
        }
    }
}

/// Some of a body's statements, each a constant; of a `long` body in one declaration.
pub(super) fn write_statements(
    w: &mut Lines,
    prefix: &str,
    language: &C<'_>,
    (body, statements, long): (&Body, &[Statement], bool),
) {
    let write = |term: &Term| argument(language.write(term, &body.locals));
    let circular = |sine: usize, cosine: usize, argument: &Term| {
        let argument = write(argument);
        [
            (sine, format!("SIN({argument})")),
            (cosine, format!("COS({argument})")),
        ]
    };
    let mut constants: Vec<(&str, String)> = Vec::new();
    for statement in statements {
        let own: Vec<(usize, String)> = match statement {
            Statement::Let { local, value } => vec![(*local, write(value))],
            Statement::SinCos {
                sine,
                cosine,
                argument,
            } => circular(*sine, *cosine, argument).into(),
            Statement::SinCosEach(group) => (group.iter())
                .flat_map(|one| circular(one.sine, one.cosine, &one.argument))
                .collect(),
        };
        let named = own.into_iter();
        constants.extend(named.map(|(local, value)| (body.locals[local].as_str(), value)));
    }
    if long {
        return declare(w, prefix, &constants);
    }
    for (name, value) in constants {
        w.line(&format!("    const {prefix}_real {name} = {value};"));
    }
}
