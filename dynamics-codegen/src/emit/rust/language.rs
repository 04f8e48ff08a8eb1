//! Rust's numbers, names and functions.

use crate::emit::body::Fused;
use crate::emit::symbols::{Role, Symbols};
use crate::emit::written::{Language, Written};
use crate::graph::{Binary, Precedence, SymbolId, Unary};

/// Expressions of type `T: Scalar`.
pub(super) struct Rust<'a> {
    pub symbols: &'a Symbols,
}

impl Language for Rust<'_> {
    fn constant(&self, value: f64) -> Written {
        Written::atom(match value {
            0.0 => "T::zero()".to_string(),
            1.0 => "T::one()".to_string(),
            _ => format!("T::from_f64({})", number(value)),
        })
    }

    fn symbol(&self, id: SymbolId) -> String {
        let symbol = self.symbols.get(id);
        match symbol.role {
            Role::Parameter(_) => format!("p.{}", symbol.code),
            _ => symbol.code.clone(),
        }
    }

    fn function(&self, op: Unary, x: Written) -> Written {
        Written::atom(format!("{}.{}()", x.within(Precedence::Atom), op.name()))
    }

    fn fused(&self, op: Fused, [x, y, z]: [Written; 3]) -> Written {
        let x = x.within(Precedence::Atom);
        Written::atom(format!("{x}.{}({}, {})", op.name(), y.text, z.text))
    }

    fn function_of_two(&self, op: Binary, x: Written, y: Written) -> Written {
        let name = if op == Binary::Pow { "powf" } else { op.name() };
        Written::atom(format!("{}.{name}({})", x.within(Precedence::Atom), y.text))
    }
}

/// A number of type `f64`, exact.
pub(super) fn number(value: f64) -> String {
    let sign = if value < 0.0 { "-" } else { "" };
    match value.abs() {
        x if x.is_nan() => "f64::NAN".to_string(),
        f64::INFINITY => format!("{sign}f64::INFINITY"),
        x => match MATHEMATICAL.iter().find(|(known, _)| *known == x) {
            Some((_, name)) => format!("{sign}core::f64::consts::{name}"),
            None => format!("{sign}{x:?}"),
        },
    }
}

/// Numbers that have a name in `core`.
const MATHEMATICAL: [(f64, &str); 19] = {
    use std::f64::consts::*;
    [
        (PI, "PI"),
        (TAU, "TAU"),
        (E, "E"),
        (FRAC_PI_2, "FRAC_PI_2"),
        (FRAC_PI_3, "FRAC_PI_3"),
        (FRAC_PI_4, "FRAC_PI_4"),
        (FRAC_PI_6, "FRAC_PI_6"),
        (FRAC_PI_8, "FRAC_PI_8"),
        (FRAC_1_PI, "FRAC_1_PI"),
        (FRAC_2_PI, "FRAC_2_PI"),
        (FRAC_2_SQRT_PI, "FRAC_2_SQRT_PI"),
        (SQRT_2, "SQRT_2"),
        (FRAC_1_SQRT_2, "FRAC_1_SQRT_2"),
        (LN_2, "LN_2"),
        (LN_10, "LN_10"),
        (LOG2_E, "LOG2_E"),
        (LOG10_E, "LOG10_E"),
        (LOG2_10, "LOG2_10"),
        (LOG10_2, "LOG10_2"),
    ]
};

/// An attribute that lets numbers which clippy would take for a rounded `PI` and the
/// like stand as the model states them; nothing if there is none.
pub(super) fn numbers_as_stated(values: &[f64]) -> Option<&'static str> {
    let rounded = |value: f64| {
        let close = |known: f64| known != value.abs() && (value.abs() / known - 1.0).abs() < 0.02;
        MATHEMATICAL.iter().any(|&(known, _)| close(known))
    };
    values.iter().any(|&value| rounded(value)).then_some(
        "#[allow(clippy::approx_constant, reason = \"numbers as the model states them\")]",
    )
}
