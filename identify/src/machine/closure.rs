//! What positions owe to holonomic constraints.
//!
//! A constraint `c(q, t) = 0` is a sensor that always reads zero: whatever moves the machine, it
//! says how far off a position is, or a length that the constraint is made of.

use super::{Machine, States};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::model::ConstraintKind;
use dynamics_codegen::{System, Tape};

/// `∂c/∂s` of the holonomic constraints by those of some variables that they depend on.
#[derive(Debug, Clone)]
pub struct Closure {
    tape: Tape,
    rows: usize,
    /// Which of the variables, by their places, ascending.
    pub closing: Vec<usize>,
}

impl Machine {
    /// Which constraints are holonomic.
    pub fn holonomic_rows(&self) -> Vec<usize> {
        let kinds = self.constraint_kinds().iter().enumerate();
        let holonomic = kinds.filter(|(_, kind)| **kind == ConstraintKind::Holonomic);
        holonomic.map(|(row, _)| row).collect()
    }

    /// Derivatives of the holonomic constraints by those `variables` that they depend on.
    pub fn closure(&mut self, variables: &[Variable]) -> Closure {
        let rows = self.holonomic_rows();
        let (model, system) = (&mut self.compiled.model, &self.compiled.system);
        let residuals: Vec<_> = rows
            .iter()
            .map(|&r| system.constraint_residual[r])
            .collect();
        let (mut closing, mut outputs) = (Vec::new(), Vec::new());
        for (place, variable) in variables.iter().enumerate() {
            let symbol = variable.symbol(model);
            if model.graph.depends_on(&residuals, symbol) {
                closing.push(place);
                outputs.extend(model.graph.derivatives(&residuals, symbol));
            }
        }
        Closure {
            tape: Tape::new(&model.graph, &outputs, &System::arguments(model)),
            rows: rows.len(),
            closing,
        }
    }
}

impl Closure {
    /// `∂c/∂s` at every state: per closing variable and row, in this order, one column.
    pub fn slopes(&self, states: &States, parameters: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let columns = states.columns(parameters);
        let mut values = self.tape.evaluate_all(&columns, states.len()).into_iter();
        let variables = self.closing.iter();
        variables
            .map(|_| values.by_ref().take(self.rows).collect())
            .collect()
    }
}
