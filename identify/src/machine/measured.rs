//! What sensors read along a motion.

use super::{Machine, States};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::{Column, System, Tape};

/// The sensors of a machine: readings of positions and velocities, and their derivatives
/// by some parameters.
#[derive(Debug, Clone)]
pub struct Sensors {
    tape: Tape,
    coordinates: usize,
    /// Which of the variables change a reading of a motion that stays as it is, by their
    /// places, ascending.
    pub sensing: Vec<usize>,
}

/// Readings at every sample, one column per coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Of positions.
    pub q: Vec<Vec<f64>>,
    /// Of velocities.
    pub v: Vec<Vec<f64>>,
    /// How much the reading of a position changes with the position.
    pub slope: Vec<Vec<f64>>,
    /// Per sensing variable, `∂q/∂s`.
    pub q_by: Vec<Vec<Vec<f64>>>,
    /// Per sensing variable, `∂v/∂s`.
    pub v_by: Vec<Vec<Vec<f64>>>,
}

impl Machine {
    /// The sensors, with derivatives by those `variables` that change readings of a motion
    /// that stays as it is.
    pub fn sensors(&mut self, variables: &[Variable]) -> Sensors {
        let (model, system) = (&mut self.compiled.model, &self.compiled.system);
        let mut outputs = system.measured.clone();
        outputs.extend(&system.measured_rates);
        let readings = outputs.clone();
        for (index, &reading) in system.measured.iter().enumerate() {
            let position = Variable::Position(index).symbol(model);
            outputs.extend(model.graph.derivatives(&[reading], position));
        }
        let mut sensing = Vec::new();
        for (place, variable) in variables.iter().enumerate() {
            let symbol = variable.symbol(model);
            if model.graph.depends_on(&readings, symbol) {
                sensing.push(place);
                outputs.extend(model.graph.derivatives(&readings, symbol));
            }
        }
        let mut arguments = System::arguments(model);
        arguments.extend(&system.acceleration);
        Sensors {
            tape: Tape::new(&model.graph, &outputs, &arguments),
            coordinates: model.coordinates.len(),
            sensing,
        }
    }

    /// Whether a sensor reads anything but its position.
    pub fn has_sensor_errors(&self) -> bool {
        !self.compiled.model.measured.is_empty()
    }
}

impl Sensors {
    /// The readings where the machine is in `states` with these accelerations, one column
    /// per coordinate.
    pub fn read(
        &self,
        states: &States,
        accelerations: &[Vec<f64>],
        parameters: &[f64],
    ) -> Measured {
        let mut columns = states.columns(parameters);
        columns.extend(accelerations.iter().map(|a| Column::Each(a)));
        let mut values = self.tape.evaluate_all(&columns, states.len()).into_iter();
        let n = self.coordinates;
        let mut group = || -> Vec<Vec<f64>> { values.by_ref().take(n).collect() };
        let (q, v, slope) = (group(), group(), group());
        let (mut q_by, mut v_by) = (Vec::new(), Vec::new());
        for _ in &self.sensing {
            q_by.push(group());
            v_by.push(group());
        }
        Measured {
            q,
            v,
            slope,
            q_by,
            v_by,
        }
    }
}
