//! The balance of forces along a log: what acts beside the model, and what an effect would add.

use crate::log::{Record, rms};
use crate::machine::{Machine, SensitivityTape, SolveError, States};
use crate::regression::{Band, Hold};
use crate::smooth::{SmoothError, Smoothed, smooth};
use nalgebra::DVector;

/// More equations than this many per coordinate say no more.
pub(super) const MOST_SAMPLES: usize = 2000;

/// Inputs that exert less than this share of the forces that act on a coordinate do not drive it:
/// what is missing there is no share of them.
const DRIVES: f64 = 1e-3;

/// Generalised forces, per coordinate and kept sample.
pub(super) type Forces = Vec<Vec<f64>>;

/// Forces that are known beside a model's, as the left side has them: of states and accelerations.
pub(crate) type Beside<'a> = dyn Fn(&States, &[Vec<f64>]) -> Vec<Vec<f64>> + 'a;

/// A log with its accelerations.
#[derive(Debug, Clone)]
pub(super) struct Balance {
    states: States,
    accelerations: Vec<Vec<f64>>,
    band: Band,
    /// How many times narrower the band is than that in which the log shows accelerations.
    pub narrowing: usize,
    hold: Hold,
}

impl Balance {
    /// Of a log whose inputs do this between samples, in a band that is so many times narrower than that in which
    /// the log shows accelerations.
    ///
    /// # Errors
    /// If the log cannot be smoothed.
    pub fn narrowed(record: &Record, hold: Hold, narrowing: usize) -> Result<Self, SmoothError> {
        let smoothed = smooth(record)?;
        let band = Band::of(record, &smoothed, MOST_SAMPLES, narrowing);
        Ok(Self::everywhere(record, &smoothed, hold).limited_to(band, narrowing))
    }

    /// Of a log that was smoothed, at each sample by itself.
    pub fn everywhere(record: &Record, smoothed: &[Smoothed], hold: Hold) -> Self {
        Self {
            states: States::along(record, smoothed),
            accelerations: smoothed.iter().map(|s| s.a.clone()).collect(),
            band: Band::everything(),
            narrowing: 0,
            hold,
        }
    }

    /// The same in a band.
    pub fn limited_to(self, band: Band, narrowing: usize) -> Self {
        Self {
            band,
            narrowing,
            ..self
        }
    }

    /// The same as if nothing were accelerated along the curve.
    pub fn unaccelerated(&self) -> Self {
        let mut still = self.clone();
        still.accelerations.iter_mut().for_each(|a| a.fill(0.0));
        still
    }

    /// How long a force is averaged over, s.
    pub fn averaged_over(&self) -> f64 {
        let t = &self.states.t;
        let step = (t[t.len() - 1] - t[0]) / (t.len() - 1).max(1) as f64;
        self.band.window() as f64 * step
    }

    /// That of another log, seen in the same way.
    ///
    /// # Errors
    /// If the log cannot be smoothed.
    pub fn of_another(&self, record: &Record) -> Result<Self, SmoothError> {
        Self::narrowed(record, self.hold, self.narrowing)
    }

    /// When the samples are that are kept, s.
    pub fn t(&self) -> Vec<f64> {
        let t = self.states.t.iter().step_by(self.band.stride());
        t.copied().collect()
    }

    /// `M a − Q`: what acts and is not in the model. `M` need not be regular.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn missing(&self, machine: &Machine, values: &[f64]) -> Result<Forces, SolveError> {
        self.missing_beside(machine, values, None)
    }

    /// The same with forces `beside` the model's.
    ///
    /// # Errors
    /// As there.
    pub fn missing_beside(
        &self,
        machine: &Machine,
        values: &[f64],
        beside: Option<&Beside<'_>>,
    ) -> Result<Forces, SolveError> {
        let missing = self.missing_unlimited(machine, values, beside)?;
        Ok(missing.iter().map(|force| self.band.limit(force)).collect())
    }

    /// The same at every sample.
    ///
    /// # Errors
    /// As there.
    pub fn missing_everywhere(
        &self,
        machine: &Machine,
        values: &[f64],
    ) -> Result<Forces, SolveError> {
        let missing = self.missing_unlimited(machine, values, None)?;
        let limited = missing
            .iter()
            .map(|force| self.band.limit_everywhere(force));
        Ok(limited.collect())
    }

    fn missing_unlimited(
        &self,
        machine: &Machine,
        values: &[f64],
        beside: Option<&Beside<'_>>,
    ) -> Result<Forces, SolveError> {
        let states = self.remembered(machine, values)?;
        let terms = machine.terms(&states, values);
        let n = machine.coordinate_count();
        let mut missing = vec![Vec::with_capacity(terms.len()); n];
        for (sample, terms) in terms.iter().enumerate() {
            let a = DVector::from_fn(n, |i, _| self.accelerations[i][sample]);
            let left = &terms.mass_matrix * a - &terms.force;
            (0..n).for_each(|i| missing[i].push(left[i]));
        }
        if let Some(beside) = beside {
            let more = beside(&states, &self.accelerations);
            for (missing, more) in missing.iter_mut().zip(&more) {
                missing
                    .iter_mut()
                    .zip(more)
                    .for_each(|(m, more)| *m += more);
            }
        }
        Ok(missing)
    }

    /// `B u`: what the inputs exert, the scale of what is missing; zero along a coordinate that
    /// they do not drive, where it would be round-off.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn exerted(&self, machine: &Machine, values: &[f64]) -> Result<Forces, SolveError> {
        let states = self.remembered(machine, values)?;
        let n = machine.coordinate_count();
        let mut exerted = vec![Vec::with_capacity(states.len()); n];
        let mut others = exerted.clone();
        for terms in &machine.terms(&states, values) {
            let other = &terms.bias_force + &terms.applied_force;
            let force = &terms.force - &other;
            (0..n).for_each(|i| exerted[i].push(force[i]));
            (0..n).for_each(|i| others[i].push(other[i]));
        }
        let of_coordinate = |(force, other): (&Vec<f64>, &Vec<f64>)| {
            let mut force = self.band.limit(force);
            if rms(&force) <= DRIVES * rms(&self.band.limit(other)) {
                force.fill(0.0);
            }
            force
        };
        Ok(exerted.iter().zip(&others).map(of_coordinate).collect())
    }

    /// The curve with what a machine remembers along it.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn remembered(&self, machine: &Machine, values: &[f64]) -> Result<States, SolveError> {
        machine.remember(&self.states, self.hold, values)
    }

    /// What a unit of each of the tape's variables adds to the forces, `∂Q/∂s − ∂M/∂s a`, at `states` with what is
    /// remembered there; but not through that.
    pub fn added(&self, states: &States, tape: &SensitivityTape, values: &[f64]) -> Vec<Forces> {
        let nothing = vec![0.0; self.t().len()];
        // A long log's rows are one after another limited, and let go.
        let limited = |row: Option<Vec<f64>>| match row {
            Some(mut row) => {
                row.iter_mut().for_each(|x| *x = -*x);
                self.band.limited(row)
            }
            None => nothing.clone(),
        };
        let rows = tape.residuals(states, values, &self.accelerations);
        let mut limited = rows.into_iter().map(limited);
        let n = self.accelerations.len();
        let columns = limited.len() / n.max(1);
        (0..columns)
            .map(|_| limited.by_ref().take(n).collect())
            .collect()
    }

    /// The log of a machine that moves along this curve as the model demands, with forces `beside`
    /// it, in the same inputs: `u + B⁺ (M a − Q)`.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn obeying(
        &self,
        record: &Record,
        machine: &Machine,
        values: &[f64],
        beside: Option<&Beside<'_>>,
    ) -> Result<Record, SolveError> {
        let missing = self.missing_unlimited(machine, values, beside)?;
        let states = self.remembered(machine, values)?;
        let terms = machine.terms(&states, values);
        let mut obeying = record.clone();
        obeying.q.clone_from(&self.states.q);
        let (n, k) = (machine.coordinate_count(), machine.input_count());
        for (sample, terms) in terms.iter().enumerate() {
            let force = DVector::from_fn(n, |i, _| missing[i][sample]);
            let inputs = terms.input_matrix.columns(0, k).into_owned();
            let demanded = inputs.svd(true, true).solve(&force, SMALL_INPUT);
            for (j, u) in demanded
                .unwrap_or_else(|_| DVector::zeros(k))
                .iter()
                .enumerate()
            {
                obeying.u[j][sample] += u;
            }
        }
        Ok(obeying)
    }
}

/// Singular values of `B` below this are none.
const SMALL_INPUT: f64 = 1e-9;
