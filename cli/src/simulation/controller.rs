//! A sampled controller: `u = stated + K (reference − readings)`, late and limited.

use super::control_file::{self, File, Reference};
use super::readings::Readings;
use crate::inputs::Inputs;
use crate::mistake::Mistake;
use dynamics_codegen::Model;
use std::collections::VecDeque;
use std::path::Path;

/// State feedback at a rate of its own.
#[derive(Debug)]
pub struct Controller {
    /// Seconds from one sample to the next.
    pub interval: f64,
    /// Which inputs it commands.
    pub inputs: Vec<usize>,
    feedback: Vec<Fed>,
    reference: Inputs,
    /// `K`, a row per commanded input.
    gain: Vec<Vec<f64>>,
    /// Per commanded input.
    limits: Vec<(f64, f64)>,
    /// Samples between a reading and the arrival of the command that follows from it.
    delay: usize,
    /// Commands on their way.
    pending: VecDeque<Vec<f64>>,
    /// The readings at the sample before.
    before: Option<Vec<f64>>,
}

/// What is fed back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fed {
    /// Which of the readings, by its place.
    pub reading: usize,
    /// Whether its change since the sample before, per second, in place of itself.
    pub is_rate: bool,
}

impl Controller {
    /// Reads a file: `docs/control.md` has all keys.
    ///
    /// # Errors
    /// If it is no such file, or names something that the model or a log of it does not have.
    pub fn read(path: &Path, model: &Model) -> Result<Self, Mistake> {
        let File {
            interval,
            delay,
            feedback,
            reference,
            inputs,
            gain,
            limits,
        } = control_file::read(path, model, &Readings::names(model))?;
        let reference = match reference {
            Reference::Constant(values) => Inputs::constant(values),
            Reference::Over(values) => values,
        };
        Ok(Self {
            interval,
            inputs,
            feedback,
            reference,
            gain,
            limits,
            delay,
            pending: VecDeque::new(),
            before: None,
        })
    }

    /// Takes a sample at time `t`; `stated` is what each commanded input would be without
    /// feedback. The command that arrives now, if one does.
    pub fn sample(&mut self, t: f64, readings: &[f64], stated: &[f64]) -> Option<Vec<f64>> {
        let before = self.before.replace(readings.to_vec());
        let fed = |fed: &Fed| match (fed.is_rate, &before) {
            (false, _) => readings[fed.reading],
            (true, Some(before)) => (readings[fed.reading] - before[fed.reading]) / self.interval,
            (true, None) => 0.0,
        };
        let deviation: Vec<f64> = self
            .reference
            .at(t)
            .iter()
            .zip(&self.feedback)
            .map(|(reference, name)| reference - fed(name))
            .collect();
        let command = |row: usize| {
            let pairs = self.gain[row].iter().zip(&deviation);
            let sum: f64 = pairs.map(|(k, deviation)| k * deviation).sum();
            let (lower, upper) = self.limits[row];
            (stated[row] + sum).max(lower).min(upper)
        };
        let command = (0..self.inputs.len()).map(command).collect();
        self.pending.push_back(command);
        if self.pending.len() > self.delay {
            return self.pending.pop_front();
        }
        None
    }
}
