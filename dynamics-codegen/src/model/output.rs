//! Outputs: what a log may hold beside the coordinates.

use super::Output;
use super::builder::Builder;
use super::names::VECTORS;
use crate::diagnostic::Diagnostic;
use crate::syntax::{Expr, ExprKind, Name};

impl Builder<'_> {
    /// One output, or one per component of a vector: `output tip = position(tool);`.
    pub(super) fn lower_output(&mut self, name: &Name, value: &Expr, doc: &str) -> Option<()> {
        let components = match &value.kind {
            ExprKind::Call(function, arguments) if VECTORS.contains(&function.text.as_str()) => {
                let vector = self.vector(function, arguments, value.span)?;
                let mut components = Vec::new();
                for (index, letter) in ["x", "y", "z"].into_iter().enumerate() {
                    let name = format!("{}_{letter}", name.text);
                    components.push((name, vector(self, index)?));
                }
                components
            }
            _ => vec![(name.text.clone(), self.lower(value)?)],
        };
        for (text, quantity) in components {
            self.refuse_momentary(quantity.expr, value.span, "an output")?;
            if self.model.outputs.iter().any(|y| y.name == text) {
                let message = format!("there are two outputs named `{text}`");
                return self.report(Diagnostic::error(name.span, message));
            }
            self.model.outputs.push(Output {
                name: text,
                value: quantity.expr,
                dimension: quantity.measure.known(),
                doc: doc.to_string(),
            });
        }
        Some(())
    }
}
