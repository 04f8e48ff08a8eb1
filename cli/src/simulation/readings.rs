//! What is seen of a motion at one time: the columns of a log, the outputs, the sensors.

use super::signal::{Side, Signal};
use crate::mistake::Mistake;
use crate::noise;
use crate::start::stopped;
use dynamics_codegen::{Model, System, Tape};
use identify::machine::{Instruments, Machine, Memory, Motion, Sensors, Simulated, States};

/// The quantities that can be read off a moving machine.
pub(super) struct Readings<'a> {
    machine: &'a Machine,
    parameters: &'a [f64],
    sensors: Sensors,
    outputs: Tape,
    instruments: Instruments,
}

impl<'a> Readings<'a> {
    pub fn new(machine: &'a Machine, parameters: &'a [f64]) -> Self {
        let model = &machine.compiled.model;
        let outputs = &machine.compiled.system.outputs;
        Self {
            outputs: Tape::new(&model.graph, outputs, &System::arguments(model)),
            sensors: machine.clone().sensors(&[]),
            instruments: machine.clone().instruments(&[]),
            machine,
            parameters,
        }
    }

    /// Their names: the columns of a log, the outputs, then the sensors.
    pub fn names(model: &Model) -> Vec<String> {
        let outputs = model.outputs.iter().map(|output| output.name.clone());
        let sensors = model.sensors.iter().map(|sensor| sensor.name.clone());
        let columns = noise::columns(model).into_iter();
        columns.chain(outputs).chain(sensors).collect()
    }

    /// Per sensor by how much later than its reading what it shows is, s.
    pub fn leads(&self) -> Vec<f64> {
        let leads = self.instruments.leads(self.parameters);
        leads.map_or_else(|| vec![0.0; self.instruments.count()], |(leads, _)| leads)
    }

    /// Their values in this order, without noise.
    pub fn at(
        &self,
        simulated: &Simulated,
        t: f64,
        signal: &Signal,
        side: Side,
    ) -> Result<Vec<f64>, Mistake> {
        let column = |values: &[f64]| values.iter().map(|&value| vec![value]).collect();
        let (u, late) = (signal.inputs(t, side), signal.delayed(t, side));
        let states = States {
            t: vec![t],
            q: simulated.q.clone(),
            v: simulated.v.clone(),
            u: column(&u),
            memory: Memory {
                delay_rate: vec![vec![0.0]; late.len()],
                delayed: column(&late),
                z: simulated.z.clone(),
                ..Memory::default()
            },
            ..States::default()
        };
        let pressed = self
            .machine
            .pressed(&states, self.parameters)
            .map_err(|error| stopped(error, t))?;
        let motions: Vec<Motion> = pressed.into_iter().map(|pressed| pressed.motion).collect();
        let a: Vec<Vec<f64>> = motions[0].acceleration.iter().map(|&a| vec![a]).collect();
        let states = self.machine.at_rest(&states, self.parameters);
        let read = self.sensors.read(&states, &a, self.parameters);
        let memory = &states.memory;
        let mut arguments = vec![t];
        for group in [&states.q, &states.v, &states.u, &memory.delayed, &memory.z] {
            arguments.extend(group.iter().map(|column| column[0]));
        }
        arguments.extend(self.parameters);
        let columns = read.columns(&self.machine.compiled.model, &states);
        let mut values: Vec<f64> = columns.iter().flatten().copied().collect();
        values.extend(motions[0].acceleration.iter());
        values.extend(u);
        values.extend(self.outputs.evaluate(&arguments));
        let shown = self.instruments.read(&states, &motions, self.parameters);
        values.extend(shown.iter().flatten());
        Ok(values)
    }
}
