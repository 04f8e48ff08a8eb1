//! What sensors read along a motion.

use super::closure::Closure;
use super::shifted::shifted;
use super::{Machine, States};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::{Column, Model, System, Tape};

/// The sensors of a machine: readings of positions and velocities, and their derivatives
/// by some parameters.
#[derive(Debug, Clone)]
pub struct Sensors {
    tape: Tape,
    /// How much each reading owes to the velocity and to the position of its coordinate; `None`
    /// if no reading owes anything to a velocity.
    lead: Option<Tape>,
    coordinates: usize,
    /// Which of the variables change a reading of a motion that stays as it is, by their
    /// places, ascending.
    pub sensing: Vec<usize>,
    /// What holonomic constraints owe to the variables.
    pub closure: Closure,
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
    /// How much later the motion is that is read, s; empty where sensors are on time.
    pub ahead: Vec<Vec<f64>>,
    /// By how much the position, the velocity and the acceleration there may be off, where that is outside of
    /// what is known of the motion; empty where sensors are on time.
    pub doubt: [Vec<Vec<f64>>; 3],
    /// Velocities and accelerations of the motion that is read.
    pub motion: [Vec<Vec<f64>>; 2],
    /// Per sensing variable, `∂q/∂s`.
    pub q_by: Vec<Vec<Vec<f64>>>,
    /// Per sensing variable, `∂v/∂s`.
    pub v_by: Vec<Vec<Vec<f64>>>,
}

impl Machine {
    /// The sensors, with derivatives by those `variables` that change readings of a motion
    /// that stays as it is.
    pub fn sensors(&mut self, variables: &[Variable]) -> Sensors {
        let closure = self.closure(variables);
        let (model, system) = (&mut self.compiled.model, &self.compiled.system);
        let mut outputs = system.measured.clone();
        outputs.extend(&system.measured_rates);
        let readings = outputs.clone();
        for (index, &reading) in system.measured.iter().enumerate() {
            let position = Variable::Position(index).symbol(model);
            outputs.extend(model.graph.derivatives(&[reading], position));
        }
        let mut owes = |variable: fn(usize) -> Variable| -> Vec<ExprId> {
            let each = (0..model.coordinates.len()).map(|index| {
                let symbol = variable(index).symbol(model);
                model.graph.derivatives(&[system.measured[index]], symbol)[0]
            });
            each.collect()
        };
        let leads = owes(Variable::Velocity);
        let slopes = owes(Variable::Position);
        let is_late = leads.iter().any(|&lead| !model.graph.is_zero(lead));
        let leads = [leads, slopes].concat();
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
            lead: is_late.then(|| Tape::new(&model.graph, &leads, &arguments)),
            tape: Tape::new(&model.graph, &outputs, &arguments),
            coordinates: model.coordinates.len(),
            sensing,
            closure,
        }
    }

    /// Whether a sensor reads anything but its position.
    pub fn has_sensor_errors(&self) -> bool {
        !self.compiled.model.measured.is_empty()
    }
}

impl Sensors {
    /// The readings where the machine is in `states` with these accelerations, one column
    /// per coordinate. What a reading owes to its velocity, `q + s q̇`, is `s` seconds of time
    /// to first order, and taken as that to all: the motion is read there.
    pub fn read(
        &self,
        states: &States,
        accelerations: &[Vec<f64>],
        parameters: &[f64],
    ) -> Measured {
        let n = self.coordinates;
        let (mut there, mut acceleration) = (states.clone(), accelerations.to_vec());
        let mut leads = Vec::new();
        let mut ahead = vec![Vec::new(); n];
        let mut doubt = [0, 1, 2].map(|_| vec![Vec::new(); n]);
        if let Some(lead) = &self.lead {
            leads = lead.evaluate_all(&columns(states, accelerations, parameters), states.len());
            let slopes = leads.split_off(n);
            for (i, (lead, slope)) in leads.iter().zip(&slopes).enumerate() {
                if lead.iter().any(|s| *s != 0.0) {
                    let by: Vec<f64> = lead.iter().zip(slope).map(|(l, s)| l / s).collect();
                    let moved = shifted(states, i, &accelerations[i], &by);
                    (there.q[i], there.v[i], acceleration[i]) = (moved.q, moved.v, moved.a);
                    ahead[i] = by;
                    let of_channel = doubt.iter_mut().zip(moved.doubt);
                    of_channel.for_each(|(doubt, own)| doubt[i] = own);
                }
            }
        }
        let columns = columns(&there, &acceleration, parameters);
        let mut values = self.tape.evaluate_all(&columns, states.len()).into_iter();
        let mut group = || -> Vec<Vec<f64>> { values.by_ref().take(n).collect() };
        let (mut q, mut v, slope) = (group(), group(), group());
        // The time is in the states now.
        for (i, lead) in leads.iter().enumerate() {
            for (k, lead) in lead.iter().enumerate() {
                q[i][k] -= lead * there.v[i][k];
                v[i][k] -= lead * acceleration[i][k];
            }
        }
        let (mut q_by, mut v_by) = (Vec::new(), Vec::new());
        for _ in &self.sensing {
            q_by.push(group());
            v_by.push(group());
        }
        Measured {
            q,
            v,
            slope,
            ahead,
            doubt,
            motion: [there.v, acceleration],
            q_by,
            v_by,
        }
    }
}

impl Measured {
    /// What is read of all positions, then of all velocities, of a model in `states`: of poses
    /// and twists, which no sensor of a coordinate reads, themselves.
    pub fn columns(&self, model: &Model, states: &States) -> Vec<Vec<f64>> {
        let (mut positions, mut velocities) = (states.q.clone(), states.v.clone());
        let mut place = 0;
        for index in 0..model.coordinates.len() {
            match model.pose_of(index) {
                Some(pose) if pose.first == index => place += 7,
                Some(_) => {}
                None => {
                    positions[place].clone_from(&self.q[index]);
                    velocities[index].clone_from(&self.v[index]);
                    place += 1;
                }
            }
        }
        positions.extend(velocities);
        positions
    }
}

/// What the tapes of sensors are evaluated with.
fn columns<'a>(
    states: &'a States,
    accelerations: &'a [Vec<f64>],
    parameters: &'a [f64],
) -> Vec<Column<'a>> {
    let mut columns = states.columns(parameters);
    columns.extend(accelerations.iter().map(|a| Column::Each(a)));
    columns
}
