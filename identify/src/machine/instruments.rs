//! What the model's sensors show, without noise, and how that changes.

use super::{Machine, Motion, States};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::{Column, System, Tape};
use nalgebra::DMatrix;

/// The sensors of a model on tapes, with derivatives by some variables.
#[derive(Debug, Clone)]
pub struct Instruments {
    values: Tape,
    /// Per variable, then per acceleration and multiplier: the derivatives of all sensors.
    slopes: Tape,
    count: usize,
    variables: usize,
}

impl Machine {
    /// The sensors that the model states, with derivatives by `variables`.
    pub fn instruments(&mut self, variables: &[Variable]) -> Instruments {
        let (model, system) = (&mut self.compiled.model, &self.compiled.system);
        let arguments = System::arguments_of_sensors(model);
        let mut by: Vec<_> = variables.iter().map(|v| v.symbol(model)).collect();
        by.extend(&model.accelerations);
        by.extend(model.multiplier_symbols());
        let mut slopes = Vec::new();
        for symbol in by {
            slopes.extend(model.graph.derivatives(&system.sensors, symbol));
        }
        Instruments {
            values: Tape::new(&model.graph, &system.sensors, &arguments),
            slopes: Tape::new(&model.graph, &slopes, &arguments),
            count: system.sensors.len(),
            variables: variables.len(),
        }
    }
}

impl Instruments {
    /// How many sensors there are; each component of a vector counts.
    pub fn count(&self) -> usize {
        self.count
    }

    /// What they show at every state, one column per sensor. `motions` are those at the states.
    pub fn read(&self, states: &States, motions: &[Motion], parameters: &[f64]) -> Vec<Vec<f64>> {
        evaluate(&self.values, self.count, states, motions, parameters)
    }

    /// `∂y/∂s` at every state, `sensors × variables`, along the motion that the model demands:
    /// through accelerations and multipliers, too, whose `derivatives` are those of
    /// [`SensitivityTape::evaluate`](super::SensitivityTape::evaluate) by the same variables. What
    /// a parameter does through the past (delayed inputs, internal states) is in them as far as it
    /// changes accelerations and multipliers.
    pub fn slopes(
        &self,
        states: &States,
        motions: &[Motion],
        derivatives: &[(DMatrix<f64>, DMatrix<f64>)],
        parameters: &[f64],
    ) -> Vec<DMatrix<f64>> {
        let (n, m) = motions.first().map_or((0, 0), |motion| {
            (motion.acceleration.len(), motion.multiplier.len())
        });
        // Without a sensor there is no symbol for an acceleration either.
        let n = if self.count == 0 { 0 } else { n };
        let all = self.variables + n + m;
        let values = evaluate(&self.slopes, self.count * all, states, motions, parameters);
        let at = |(sample, (da, dlambda)): (usize, &(DMatrix<f64>, DMatrix<f64>))| {
            let entry = |row: usize, by: usize| values[by * self.count + row][sample];
            let direct = DMatrix::from_fn(self.count, self.variables, entry);
            let by_a = DMatrix::from_fn(self.count, n, |row, i| entry(row, self.variables + i));
            let by_lambda =
                DMatrix::from_fn(self.count, m, |row, k| entry(row, self.variables + n + k));
            direct + by_a * da.rows(0, n) + by_lambda * dlambda
        };
        derivatives.iter().enumerate().map(at).collect()
    }
}

fn evaluate(
    tape: &Tape,
    outputs: usize,
    states: &States,
    motions: &[Motion],
    parameters: &[f64],
) -> Vec<Vec<f64>> {
    if outputs == 0 {
        return Vec::new();
    }
    let solved = |of: &dyn Fn(&Motion) -> Vec<f64>| -> Vec<Vec<f64>> {
        let rows: Vec<Vec<f64>> = motions.iter().map(of).collect();
        let width = rows.first().map_or(0, Vec::len);
        (0..width)
            .map(|i| rows.iter().map(|row| row[i]).collect())
            .collect()
    };
    let a = solved(&|motion| motion.acceleration.as_slice().to_vec());
    let lambda = solved(&|motion| motion.multiplier.as_slice().to_vec());
    let mut columns = states.columns(parameters);
    columns.extend(a.iter().chain(&lambda).map(|column| Column::Each(column)));
    tape.evaluate_all(&columns, states.len())
}
