//! Parameters: value, bounds, prior, and how many values a search tries.

use super::builder::Builder;
use super::names::Binding;
use super::unit::unit_text;
use super::{Belief, Parameter};
use crate::diagnostic::Diagnostic;
use crate::syntax::{Bounds, Expr, Name, Prior, Unit};

/// What is said where something may vary that must not.
pub(super) const NUMBERS: &str = "numbers and constants only: `0.5`, `pi/4`, `-g0`";

impl Builder<'_> {
    /// `parameter k: unit = nominal in bounds prior …;`
    pub(super) fn declare_parameter(
        &mut self,
        name: &Name,
        unit: Option<&Unit>,
        nominal: Option<&Expr>,
        bounds: Option<&Bounds>,
        prior: Option<&Prior>,
        doc: &str,
    ) {
        let in_model = self.effect.is_none();
        let value = match nominal {
            Some(expr) => self.number(expr),
            None if in_model => self.report(
                Diagnostic::error(name.span, format!("parameter `{}` has no value", name.text))
                    .help(format!("give it one: `parameter {}: … = 1.0;`", name.text)),
            ),
            // An effect does nothing until its strength is known.
            None => Some(0.0),
        };
        let value = value.unwrap_or(0.0);
        let (lower, upper) = self.range(bounds);
        let belief = prior.and_then(|prior| self.belief(prior));
        let dimension = unit.and_then(|unit| self.dimension(unit));
        let binding = Binding::Parameter(self.model.parameters.len());
        if !self.bind(name, binding) {
            return;
        }
        let full_name = format!("{}{}", self.prefix, name.text);
        if let Some(earlier) = self.model.parameters.iter().find(|p| p.name == full_name) {
            let message = format!("a parameter named `{}` exists already", earlier.name);
            self.report::<()>(Diagnostic::error(name.span, message));
        }
        let symbol = self.model.graph.symbol(full_name.clone());
        // Units of a template are written in terms of its ports: show them resolved.
        let unit = match (unit, dimension) {
            (Some(unit), dimension) if self.effect.is_some() => {
                dimension.map_or_else(String::new, |d| self.resolved_unit(unit, d))
            }
            (Some(unit), _) => unit_text(unit),
            (None, _) => String::new(),
        };
        self.model.parameters.push(Parameter {
            name: full_name,
            dimension,
            unit,
            nominal: value,
            default: value,
            lower,
            upper,
            belief,
            tries: None,
            symbol,
            effect: self.effect,
            doc: doc.to_string(),
        });
        let span = bounds.map_or(name.span, |b| b.span);
        if lower >= upper {
            self.report::<()>(Diagnostic::error(
                span,
                format!("no value lies between {lower} and {upper}"),
            ));
        } else if !(lower..=upper).contains(&value) {
            let message = format!("the value {value} of `{}` is not in its bounds", name.text);
            let place = nominal.map_or(name.span, |e| e.span);
            self.report::<()>(Diagnostic::error(place, message).also(span, "the bounds"));
        }
    }

    /// The bounds as numbers, infinite where nothing is said.
    fn range(&mut self, bounds: Option<&Bounds>) -> (f64, f64) {
        let mut end = |at: Option<&Expr>, open: f64| match at {
            Some(expr) => self.number(expr).unwrap_or(open),
            None => open,
        };
        let lower = end(bounds.and_then(|b| b.lower.as_ref()), f64::NEG_INFINITY);
        let upper = end(bounds.and_then(|b| b.upper.as_ref()), f64::INFINITY);
        (lower, upper)
    }

    /// `prior normal(mean, sd)`.
    pub(super) fn belief(&mut self, prior: &Prior) -> Option<Belief> {
        let (mean, sd) = (self.number(&prior.mean), self.number(&prior.sd));
        let (mean, sd) = (mean?, sd?);
        if sd > 0.0 {
            return Some(Belief { mean, sd });
        }
        let message = format!("a standard deviation is above zero, not {sd}");
        self.report(Diagnostic::error(prior.sd.span, message).help(
            "`prior normal(mean, sd)`; what is known exactly is a `constant`, or a parameter that stays as it is",
        ))
    }

    /// `try 20`: how many values a search tries.
    pub(super) fn set_tries(&mut self, name: &Name, tries: Option<&Expr>) -> Option<()> {
        let value = self.number(tries?)?;
        let span = tries?.span;
        if !(1.0..=100.0).contains(&value) || value.fract() != 0.0 {
            let message = "a number of values to try is whole, from 1 to 100";
            return self.report(Diagnostic::error(span, message));
        }
        let bound = self.scope.names.get(&name.text).map(|d| d.what.clone());
        if let Some(Binding::Parameter(index)) = bound {
            self.model.parameters[index].tries = Some(value as usize);
        }
        Some(())
    }

    /// The value of an expression of numbers and constants.
    pub(super) fn number(&mut self, expr: &Expr) -> Option<f64> {
        let quantity = self.lower(expr)?;
        match self.model.graph.as_constant(quantity.expr) {
            Some(value) => Some(value),
            None => self.report(
                Diagnostic::error(expr.span, "expected a number")
                    .label("this may vary")
                    .help(NUMBERS),
            ),
        }
    }
}
