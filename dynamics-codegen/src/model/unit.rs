//! Units as written: their dimension, and their text.

use super::builder::Builder;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::syntax::{Name, Unit, UnitBase};

impl Builder<'_> {
    /// The dimension of a unit as written; `None` (and a finding) if it is unknown.
    pub(super) fn dimension(&mut self, unit: &Unit) -> Option<Dimension> {
        let mut product = Dimension::ONE;
        for factor in &unit.factors {
            let base = match &factor.base {
                UnitBase::One => Some(Dimension::ONE),
                UnitBase::Named(name) => Dimension::of_unit(name).or_else(|| {
                    let error = Diagnostic::error(factor.span, format!("`{name}` is not a unit of the SI"));
                    self.report(error.help(
                        "units are products of m, kg, s, A, K, rad, N, J, W, Pa, V, …; prefixes and degrees are not known: convert the number",
                    ))
                }),
                UnitBase::OfPort { function, port } => match self.unit_of_port(function, port)? {
                    Some(dimension) => Some(dimension),
                    // The model leaves the port's unit open: so is this one.
                    None => return None,
                },
            };
            product = product * base?.powi(factor.exponent);
        }
        Some(product)
    }

    /// `unit(port)`, `rate(port)`, `torque(port)`; the inner `None` if the model
    /// does not state the port's unit.
    fn unit_of_port(&mut self, function: &Name, port: &Name) -> Option<Option<Dimension>> {
        let Some(&(kind, index)) = self.scope.ports.get(&port.text) else {
            return self.report(
                Diagnostic::error(
                    port.span,
                    format!("`{}` is not a port of this effect", port.text),
                )
                .help(
                    "a unit follows from a port in effect templates only; in a model write it out",
                ),
            );
        };
        let declared = self.port_dimension(kind, index);
        let of = |f: fn(Dimension) -> Dimension| Some(declared.map(f));
        match function.text.as_str() {
            "unit" => of(|d| d),
            "rate" => of(Dimension::rate),
            "torque" => of(|d| Dimension::ENERGY / d),
            _ => self.report(
                Diagnostic::error(
                    function.span,
                    format!("there is no unit `{}(…)`", function.text),
                )
                .help(
                    "a unit may follow from a port by `unit(port)`, `rate(port)` or `torque(port)`",
                ),
            ),
        }
    }
}

/// A unit as written, normalised.
pub(super) fn unit_text(unit: &Unit) -> String {
    let mut text = String::new();
    for (position, factor) in unit.factors.iter().enumerate() {
        let base = match &factor.base {
            UnitBase::One => "1".to_string(),
            UnitBase::Named(name) => name.clone(),
            UnitBase::OfPort { function, port } => format!("{}({})", function.text, port.text),
        };
        if position > 0 {
            text.push(if factor.exponent < 0 { '/' } else { '*' });
        }
        text.push_str(&base);
        let power = if position > 0 {
            factor.exponent.abs()
        } else {
            factor.exponent
        };
        if power != 1 {
            text.push_str(&format!("^{power}"));
        }
    }
    text
}
