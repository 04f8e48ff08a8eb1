//! What the model's sensors show, without noise, and how that changes.

use super::{Machine, Motion, States};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::graph::{ExprId, SymbolId};
use dynamics_codegen::{Column, Model, System, Tape};
use nalgebra::{DMatrix, DVector};

/// The sensors of a model on tapes, with derivatives by some variables.
#[derive(Debug, Clone)]
pub struct Instruments {
    values: Tape,
    /// Per variable, then per acceleration and multiplier: the derivatives of all sensors.
    slopes: Tape,
    /// Per sensor by how much later than its reading what it shows is, of the parameters; then,
    /// per variable, the derivatives of that. `None` if all sensors are on time, whatever the
    /// variables.
    leads: Option<Tape>,
    /// Per sensor, whether a multiplier is part of what it shows.
    weighing: Vec<bool>,
    count: usize,
    variables: usize,
    accelerations: usize,
    multipliers: usize,
}

impl Machine {
    /// The sensors that the model states, with derivatives by `variables`.
    pub fn instruments(&mut self, variables: &[Variable]) -> Instruments {
        let (model, system) = (&mut self.compiled.model, &self.compiled.system);
        let arguments = System::arguments_of_sensors(model);
        let by: Vec<_> = variables.iter().map(|v| v.symbol(model)).collect();
        let leads = leads(model, &system.sensor_leads, &by);
        let mut slopes = Vec::new();
        for variable in variables {
            let displacement = variable.displacement(model);
            slopes.extend(model.graph.directional(&system.sensors, &displacement));
        }
        for symbol in model
            .accelerations
            .iter()
            .copied()
            .chain(model.multiplier_symbols())
        {
            slopes.extend(model.graph.derivatives(&system.sensors, symbol));
        }
        let multipliers = model.multiplier_symbols();
        let weighs = |sensor| {
            let mut each = multipliers.iter();
            each.any(|&symbol| model.graph.depends_on(&[sensor], symbol))
        };
        Instruments {
            leads,
            weighing: system
                .sensors
                .iter()
                .map(|&sensor| weighs(sensor))
                .collect(),
            accelerations: model.accelerations.len(),
            multipliers: multipliers.len(),
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

    /// Per sensor, whether it shows forces that constraints exert: a load cell.
    pub fn weighing(&self) -> &[bool] {
        &self.weighing
    }

    /// By how much later than its reading what each sensor shows is, s, and how that changes with
    /// the variables, `sensors × variables`; `None` if all are on time, whatever the variables.
    pub fn leads(&self, parameters: &[f64]) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let tape = self.leads.as_ref()?;
        let values = tape.evaluate(parameters);
        let (leads, slopes) = values.split_at(self.count);
        let slopes = DMatrix::from_column_slice(self.count, self.variables, slopes);
        Some((leads.to_vec(), slopes))
    }

    /// What they show at every state, one column per sensor. `motions` are those at the states.
    pub fn read(&self, states: &States, motions: &[Motion], parameters: &[f64]) -> Vec<Vec<f64>> {
        self.read_at(states, &solved(motions), parameters)
    }

    /// The same where `solved` are accelerations and multipliers, one column each, whatever the
    /// model says of them.
    pub fn read_at(
        &self,
        states: &States,
        solved: &[Vec<f64>],
        parameters: &[f64],
    ) -> Vec<Vec<f64>> {
        self.evaluate((&self.values, self.count), states, solved, parameters)
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
        self.slopes_at(states, &solved(motions), derivatives, parameters)
    }

    /// The same where `solved` are accelerations and multipliers, one column each. Columns of
    /// `derivatives` beyond the variables' are those of something that sensors feel in
    /// accelerations and multipliers alone, such as a force.
    pub fn slopes_at(
        &self,
        states: &States,
        solved: &[Vec<f64>],
        derivatives: &[(DMatrix<f64>, DMatrix<f64>)],
        parameters: &[f64],
    ) -> Vec<DMatrix<f64>> {
        let (n, m) = (self.accelerations, self.multipliers);
        let all = self.variables + n + m;
        let tape = (&self.slopes, self.count * all);
        let values = self.evaluate(tape, states, solved, parameters);
        let at = |(sample, (da, dlambda)): (usize, &(DMatrix<f64>, DMatrix<f64>))| {
            let entry = |row: usize, by: usize| values[by * self.count + row][sample];
            let direct = DMatrix::from_fn(self.count, self.variables, entry);
            let by_a = DMatrix::from_fn(self.count, n, |row, i| entry(row, self.variables + i));
            let by_lambda =
                DMatrix::from_fn(self.count, m, |row, k| entry(row, self.variables + n + k));
            // Without a sensor there is no symbol for an acceleration either.
            let felt = by_a * da.rows(0, n) + by_lambda * dlambda.rows(0, m);
            direct.resize_horizontally(da.ncols(), 0.0) + felt
        };
        derivatives.iter().enumerate().map(at).collect()
    }

    fn evaluate(
        &self,
        (tape, outputs): (&Tape, usize),
        states: &States,
        solved: &[Vec<f64>],
        parameters: &[f64],
    ) -> Vec<Vec<f64>> {
        if outputs == 0 {
            return Vec::new();
        }
        let mut columns = states.columns(parameters);
        columns.extend(solved.iter().map(|column| Column::Each(column)));
        tape.evaluate_all(&columns, states.len())
    }
}

/// The times of sensors with their derivatives, where any is not null.
fn leads(model: &mut Model, leads: &[ExprId], by: &[SymbolId]) -> Option<Tape> {
    let mut outputs = leads.to_vec();
    for &symbol in by {
        outputs.extend(model.graph.derivatives(leads, symbol));
    }
    let on_time = outputs.iter().all(|&lead| model.graph.is_zero(lead));
    let parameters: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    (!on_time).then(|| Tape::new(&model.graph, &outputs, &parameters))
}

/// Accelerations and multipliers of motions, one column each.
fn solved(motions: &[Motion]) -> Vec<Vec<f64>> {
    let columns = |of: fn(&Motion) -> &DVector<f64>| -> Vec<Vec<f64>> {
        let width = motions.first().map_or(0, |motion| of(motion).len());
        let column = |i: usize| motions.iter().map(|motion| of(motion)[i]).collect();
        (0..width).map(column).collect()
    };
    let mut all = columns(|motion| &motion.acceleration);
    all.extend(columns(|motion| &motion.multiplier));
    all
}
