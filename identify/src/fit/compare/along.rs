//! A log as states and measured accelerations, and what a model says there.

use super::super::{Correction, FitError};
use super::ConstraintError;
use crate::log::Record;
use crate::machine::{Hold, Machine, Motion, SolveError, States};
use crate::smooth::{SgStates, savgol_states};
use crate::trace::{Errors, deviation, errors, filtered, inner_samples};
use nalgebra::DVector;

/// A log through the reference pipeline (Savitzky–Golay, order 4, 0.15 s).
pub(super) struct Along {
    pub record: Record,
    pub smooth: SgStates,
    /// Samples that figures are taken over and points are taken from.
    pub inner: Vec<usize>,
    states: States,
}

impl Along {
    pub fn new(machine: &Machine, record: Record, parameters: &[f64]) -> Result<Self, FitError> {
        let smooth = savgol_states(&record)?;
        let states = States::filtered(&record, &smooth);
        Ok(Self {
            states: machine.remember(&states, Hold::Linear, parameters)?,
            inner: inner_samples(&record, &smooth),
            smooth,
            record,
        })
    }

    pub fn len(&self) -> usize {
        self.record.len()
    }

    /// Where the accelerations come from, in words.
    pub fn measured(&self) -> String {
        let from = |i: usize| match (&self.record.ddq[i], &self.record.dq[i]) {
            (Some(_), _) => "as logged",
            (None, Some(_)) => "from logged velocities",
            (None, None) => "from positions",
        };
        let all: Vec<&str> = (0..self.record.q.len()).map(from).collect();
        match all.first() {
            Some(first) if all.iter().all(|x| x == first) => (*first).to_string(),
            _ => {
                let names = self.record.coordinates.iter().zip(&all);
                let each: Vec<String> =
                    names.map(|(name, from)| format!("{name} {from}")).collect();
                each.join(", ")
            }
        }
    }

    /// Predictions as the filter that the measurement passed shows them.
    fn seen(&self, coordinate: usize, predicted: &[f64]) -> Vec<f64> {
        match self.record.ddq[coordinate] {
            Some(_) => predicted.to_vec(),
            None => filtered(&self.record, &self.smooth, predicted),
        }
    }

    /// Measured less predicted accelerations; per coordinate, a value per sample.
    fn misses(&self, predicted: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let miss = |(i, predicted): (usize, &Vec<f64>)| {
            let seen = self.seen(i, predicted);
            let pairs = self.smooth.a[i].iter().zip(seen);
            pairs.map(|(measured, seen)| measured - seen).collect()
        };
        predicted.iter().enumerate().map(miss).collect()
    }

    /// Acceleration errors of a model with accelerations added.
    pub fn errors(&self, model: &Predicted, added: &[Vec<f64>]) -> Errors {
        let pick = |values: &[f64]| -> Vec<f64> { self.inner.iter().map(|&k| values[k]).collect() };
        let misses: Vec<Vec<f64>> = (self.misses(&model.with(added)).iter())
            .map(|miss| pick(miss))
            .collect();
        let scale: Vec<f64> = (self.smooth.a.iter())
            .map(|a| deviation(&pick(a)))
            .collect();
        errors(&self.record, &misses, &scale)
    }
}

/// What a model says along a log.
pub(super) struct Predicted {
    pub motions: Vec<Motion>,
    /// Accelerations per coordinate and sample.
    pub acceleration: Vec<Vec<f64>>,
    /// What is measured beyond them.
    pub residual: Vec<Vec<f64>>,
}

impl Predicted {
    /// The model with parameters, corrected if there is a correction.
    ///
    /// # Errors
    /// If the equation of motion has no solution somewhere along the log.
    pub fn new(
        machine: &Machine,
        along: &Along,
        parameters: &[f64],
        correction: Option<&Correction>,
    ) -> Result<Self, SolveError> {
        let changes = correction.map(|c| c.along(machine, &along.states, parameters));
        let motions = machine.motion_with(&along.states, parameters, |sample, terms| {
            if let Some((mass, force)) = changes.as_ref().map(|all| &all[sample]) {
                terms.mass_matrix += mass;
                terms.force -= force;
            }
        })?;
        let acceleration: Vec<Vec<f64>> = (0..machine.coordinate_count())
            .map(|i| motions.iter().map(|m| m.acceleration[i]).collect())
            .collect();
        Ok(Self {
            residual: along.misses(&acceleration),
            acceleration,
            motions,
        })
    }

    fn with(&self, added: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let sum = |(a, more): (&Vec<f64>, &Vec<f64>)| {
            a.iter().zip(more).map(|(a, more)| a + more).collect()
        };
        self.acceleration.iter().zip(added).map(sum).collect()
    }

    /// The residual acceleration at a sample, `n`.
    pub fn residual_at(&self, sample: usize) -> DVector<f64> {
        DVector::from_fn(self.residual.len(), |i, _| self.residual[i][sample])
    }

    /// `‖A a − b‖` with accelerations added, over some samples.
    pub fn constraint_error(
        &self,
        samples: &[usize],
        added: &[Vec<f64>],
    ) -> Option<ConstraintError> {
        let first = self.motions.first()?;
        if first.terms.constraint_bias.is_empty() || samples.is_empty() {
            return None;
        }
        let predicted = self.with(added);
        let (mut squares, mut max) = (0.0, 0.0_f64);
        for &sample in samples {
            let terms = &self.motions[sample].terms;
            let a = DVector::from_fn(predicted.len(), |i, _| predicted[i][sample]);
            let miss = (&terms.constraint_matrix * a - &terms.constraint_bias).norm();
            squares += miss * miss;
            max = max.max(miss);
        }
        Some(ConstraintError {
            rms: (squares / samples.len() as f64).sqrt(),
            max,
        })
    }
}
