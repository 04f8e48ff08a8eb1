//! How far the model is from a log: the figures that are reported before and after.

use super::estimate::Observed;
use crate::log::{Record, rms};
use crate::machine::{
    Begun, Machine, Motion, Rollout, RolloutOptions, Simulated, SolveError, States,
};
use crate::regression::Hold;
use crate::smooth::{SgStates, SmoothError, savgol_states};
use nalgebra::DVector;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Root mean squares per coordinate, and over all.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Errors {
    /// By coordinate, in its unit.
    pub per_coordinate: BTreeMap<String, f64>,
    /// Each coordinate's error as a share of that coordinate's scale, root mean
    /// square over coordinates that have one; a pure number, not a number (`null` in JSON) where
    /// none has.
    pub total: f64,
}

/// Open-loop prediction errors of the positions.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RolloutErrors {
    /// How long each prediction runs, s.
    pub horizon: f64,
    /// How many predictions there were.
    pub windows: usize,
    /// How many of them left every bound.
    pub diverged: usize,
    /// Root mean square over windows and time.
    #[serde(flatten)]
    pub errors: Errors,
}

/// How far a model is from a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Score {
    /// One-step acceleration error: the model at Savitzky–Golay states (order 4,
    /// 0.15 s) against the measured acceleration, or the same filter's derivative
    /// of the best channel there is; the prediction passes the same filter unless
    /// acceleration is measured. Scale: the acceleration's standard deviation.
    pub acceleration: Errors,
    /// The same as a generalised force, `M (a_measured − a_model)`: what acts and
    /// is not in the model, without what constraints hide. Scale: the standard
    /// deviation of `M a`. Where effects were found in the balance of forces
    /// ([`Basis::Forces`](super::Basis)), `M a − Q` instead, in the band in which the log shows
    /// accelerations; scale: the standard deviation of `B u`.
    pub force: Errors,
    /// Open-loop prediction errors. Scale: how far the coordinate moves within a window.
    pub rollout: RolloutErrors,
}

impl Errors {
    /// Root mean squares per coordinate, and as shares of `scale`.
    pub(super) fn of(record: &Record, rms: &[f64], scale: &[f64]) -> Self {
        combine(record, rms, scale)
    }
}

/// What a score is computed with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scoring<'a> {
    pub machine: &'a Machine,
    pub values: &'a [f64],
    pub hold: Hold,
    pub horizon: f64,
    /// How its internal states begin.
    pub begun: &'a Arc<Begun>,
}

/// Open-loop predictions of the positions, per coordinate and sample; not a number
/// where there is none.
#[derive(Debug, Clone)]
pub(super) struct Predicted {
    pub q: Vec<Vec<f64>>,
    /// Where predictions start, and how many samples each runs.
    pub starts: Vec<usize>,
    pub length: usize,
    /// Root mean square of how far each coordinate moves within a prediction.
    pub travel: Vec<f64>,
}

impl Predicted {
    /// Errors of predictions of one `record` less those of others of another, both of the same
    /// motion, one with noise.
    fn beside(&self, record: &Record, others: &Self, of: &Record) -> Errors {
        let coordinates = 0..self.q.len();
        let rms = coordinates.map(|i| {
            let own = self.q[i].iter().zip(&record.q[i]).map(|(p, q)| p - q);
            let other = others.q[i].iter().zip(&of.q[i]).map(|(p, q)| p - q);
            let apart = own.zip(other).map(|(a, b)| a - b);
            // Where one of them has left every bound there is nothing to compare.
            let apart: Vec<f64> = apart.filter(|x| x.is_finite()).collect();
            rms(&apart)
        });
        combine(record, &rms.collect::<Vec<f64>>(), &self.travel)
    }
}

/// A score with the curves that it is made from.
#[derive(Debug, Clone)]
pub(super) struct Look {
    pub score: Score,
    pub states: SgStates,
    /// Samples that the one-step errors are taken over.
    pub inner: Vec<usize>,
    /// Missing generalised force per coordinate and sample.
    pub missing: Vec<Vec<f64>>,
    pub predicted: Predicted,
}

/// Why a score could not be computed.
#[derive(Debug, thiserror::Error)]
pub(super) enum ScoreError {
    #[error(transparent)]
    Smooth(#[from] SmoothError),
    #[error(transparent)]
    Solve(#[from] SolveError),
}

impl Scoring<'_> {
    pub fn score(&self, record: &Record) -> Result<Score, ScoreError> {
        Ok(self.look(record)?.score)
    }

    /// The score with the curves that it is made from.
    pub fn look(&self, record: &Record) -> Result<Look, ScoreError> {
        let states = savgol_states(record)?;
        let (acceleration, force, missing) = self.one_step(record, &states, &[])?;
        let (rollout, predicted) = self.rollout(record, &states);
        let inner = inner_samples(record, &states);
        Ok(Look {
            score: Score {
                acceleration,
                force,
                rollout,
            },
            states,
            inner,
            missing,
            predicted,
        })
    }

    /// Generalised forces that the model lacks, per coordinate and sample.
    ///
    /// # Errors
    /// If the log cannot be smoothed, or the equation of motion not be solved along it.
    pub fn missing(&self, record: &Record) -> Result<Vec<Vec<f64>>, ScoreError> {
        let (_, _, missing) = self.one_step(record, &savgol_states(record)?, &[])?;
        Ok(missing)
    }

    /// The score that remains because of sensor noise, and of what filters make of sharp
    /// corners: the curve seen through sensors as noisy as these. What the curve itself is
    /// beside the model, where forces remain that nothing explains, is not part of it.
    pub fn noise_floor(
        &self,
        observed: &Observed,
        forces_remain: bool,
        seed: u64,
    ) -> Result<Score, ScoreError> {
        let curve = &observed.curve;
        let along = self.along(&observed.record, curve)?;
        let motions = self.machine.motion(&along, self.values)?;
        let mut clean = observed.record.clone();
        clean.q.clone_from(&curve.q);
        for i in 0..curve.q.len() {
            if clean.dq[i].is_some() {
                clean.dq[i] = Some(curve.v[i].clone());
            }
            if clean.ddq[i].is_some() {
                clean.ddq[i] = Some(motions.iter().map(|m| m.acceleration[i]).collect());
            }
        }
        if !forces_remain {
            return self.score(&with_noise(clean, observed, seed));
        }
        let (_, own) = self.rollout(&clean, &savgol_states(&clean)?);
        let beside = unexplained_forces(&clean, curve, &motions);
        let noisy = with_noise(clean.clone(), observed, seed);
        let states = savgol_states(&noisy)?;
        let (acceleration, force) = self.one_step_with(&noisy, &states, &beside)?;
        let (mut rollout, predicted) = self.rollout(&noisy, &states);
        rollout.errors = predicted.beside(&noisy, &own, &clean);
        Ok(Score {
            acceleration,
            force,
            rollout,
        })
    }

    /// Acceleration and force errors with generalised forces (per coordinate and sample)
    /// added to those of the model.
    pub fn one_step_with(
        &self,
        record: &Record,
        states: &SgStates,
        added: &[Vec<f64>],
    ) -> Result<(Errors, Errors), ScoreError> {
        let (acceleration, force, _) = self.one_step(record, states, added)?;
        Ok((acceleration, force))
    }

    /// Acceleration errors, force errors, and the latter per coordinate and sample. What is
    /// `added` to the model's forces may be empty.
    fn one_step(
        &self,
        record: &Record,
        states: &SgStates,
        added: &[Vec<f64>],
    ) -> Result<(Errors, Errors, Vec<Vec<f64>>), ScoreError> {
        let at = self.along(record, &self.filtered(record, states))?;
        let mut motions = self.machine.motion(&at, self.values)?;
        let n = record.q.len();
        if !added.is_empty() {
            for (sample, motion) in motions.iter_mut().enumerate() {
                let force = DVector::from_fn(n, |i, _| added[i][sample]);
                motion.acceleration += motion.factorisation.mobility() * force;
            }
        }
        let inner = inner_samples(record, states);
        let pick = |values: &[f64]| inner.iter().map(|&k| values[k]).collect::<Vec<f64>>();
        let misses: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let predicted: Vec<f64> = motions.iter().map(|m| m.acceleration[i]).collect();
                let smooth = match record.ddq[i] {
                    Some(_) => predicted,
                    None => filtered(record, states, &predicted),
                };
                states.a[i]
                    .iter()
                    .zip(&smooth)
                    .map(|(a, b)| a - b)
                    .collect()
            })
            .collect();
        let inner_of = |columns: &[Vec<f64>]| columns.iter().map(|c| pick(c)).collect::<Vec<_>>();
        let scale = scales(&inner_of(&states.a));
        let acceleration = errors(record, &inner_of(&misses), &scale);
        let mut forces = vec![vec![0.0; record.len()]; n];
        let mut inertial = vec![vec![0.0; record.len()]; n];
        for (sample, motion) in motions.iter().enumerate() {
            for i in 0..n {
                for j in 0..n {
                    let m = motion.terms.mass_matrix[(i, j)];
                    forces[i][sample] += m * misses[j][sample];
                    inertial[i][sample] += m * states.a[j][sample];
                }
            }
        }
        let force_scale = scales(&inner_of(&inertial));
        let force = errors(record, &inner_of(&forces), &force_scale);
        Ok((acceleration, force, forces))
    }

    /// A curve with what the machine remembers there, and with inputs as the accelerations of the
    /// record show them: filtered, a sample sees both sides of a jump.
    fn along(&self, record: &Record, curve: &States) -> Result<States, SolveError> {
        if as_measured(record) {
            return self.machine.felt(curve, self.hold, self.values);
        }
        let along = self.machine.remember(curve, self.hold, self.values)?;
        Ok(match self.hold {
            Hold::Previous => along.between_jumps(&record.segments()),
            Hold::Linear => along,
        })
    }

    /// The filtered motion of a record, with internal states that begin where they do.
    fn filtered(&self, record: &Record, states: &SgStates) -> States {
        States {
            begun: Arc::clone(self.begun),
            ..States::filtered(record, states)
        }
    }

    /// Predictions from the estimated states (on the constraints), window by window.
    fn rollout(&self, record: &Record, states: &SgStates) -> (RolloutErrors, Predicted) {
        let step = record.step();
        let length = ((self.horizon / step).round() as usize).clamp(1, record.len() - 1);
        let starts: Vec<usize> = record
            .segments()
            .into_iter()
            .flat_map(|range| {
                // One-sided filter windows give poor starts.
                let begin = range.start + states.filter.window / 2;
                (begin..range.end.saturating_sub(length)).step_by(length)
            })
            .collect();
        let mut state = self.starts(record, states, &starts);
        let inputs = self
            .machine
            .inputs_over(&record.t, &record.u, self.hold, self.values);
        let n = record.q.len();
        let (mut squares, mut travel) = (vec![0.0; n], vec![0.0; n]);
        let mut lost = vec![false; starts.len()];
        let options = RolloutOptions {
            max_step: step.min(2e-3).max(step / 8.0),
            ..Default::default()
        };
        let rollout = Rollout::new(self.machine, self.values, options);
        let mut count = vec![0_usize; n];
        let mut predicted = Predicted {
            q: vec![vec![f64::NAN; record.len()]; n],
            starts: starts.clone(),
            length,
            travel: vec![f64::NAN; n],
        };
        for k in 0..length {
            let at = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
                let pick = |u: &Vec<f64>| starts.iter().map(|s| u[s + k]).collect();
                columns.iter().map(pick).collect()
            };
            let (begin, end) = (at(&inputs[0]), at(&inputs[1]));
            let t: Vec<f64> = starts.iter().map(|s| record.t[s + k]).collect();
            if rollout.advance(&mut state, &t, step, &begin, &end).is_err() {
                lost.fill(true);
                break;
            }
            for (window, &start) in starts.iter().enumerate() {
                let outside = |i: usize| {
                    let miss = state.q[i][window] - record.q[i][start + k + 1];
                    miss.is_nan() || miss.abs() >= OUTSIDE
                };
                if lost[window] || (0..n).any(outside) {
                    lost[window] = true;
                    for i in 0..n {
                        // Stays where the log is, so that the others go on.
                        state.q[i][window] = states.q[i][start + k + 1];
                        state.v[i][window] = states.v[i][start + k + 1];
                    }
                    state.z.iter_mut().for_each(|z| z[window] = 0.0);
                    continue;
                }
                for i in 0..n {
                    let measured = record.q[i][start + k + 1];
                    predicted.q[i][start + k + 1] = state.q[i][window];
                    if record.is_set_aside(i, start + k + 1) {
                        continue;
                    }
                    count[i] += 1;
                    squares[i] += (state.q[i][window] - measured).powi(2);
                    travel[i] += (measured - record.q[i][start]).powi(2);
                }
            }
        }
        let mean = |(sum, count): (&f64, &usize)| (sum / (*count).max(1) as f64).sqrt();
        let rms: Vec<f64> = squares.iter().zip(&count).map(mean).collect();
        predicted.travel = travel.iter().zip(&count).map(mean).collect();
        let errors = RolloutErrors {
            horizon: length as f64 * step,
            windows: starts.len(),
            diverged: lost.iter().filter(|&&l| l).count(),
            errors: combine(record, &rms, &predicted.travel),
        };
        (errors, predicted)
    }

    /// Internal states at the starts; where they cannot be found, as at the beginning.
    fn remembered(&self, record: &Record, states: &SgStates, starts: &[usize]) -> Vec<Vec<f64>> {
        let along = self.filtered(record, states);
        let Ok(along) = self.machine.remember(&along, self.hold, self.values) else {
            return Vec::new();
        };
        let pick = |z: &Vec<f64>| starts.iter().map(|&start| z[start]).collect();
        along.memory.z.iter().map(pick).collect()
    }

    fn starts(&self, record: &Record, states: &SgStates, starts: &[usize]) -> Simulated {
        let n = record.q.len();
        let mut simulated = Simulated {
            q: vec![Vec::new(); n],
            v: vec![Vec::new(); n],
            z: self.remembered(record, states, starts),
        };
        for &start in starts {
            let mut q: Vec<f64> = states.q.iter().map(|q| q[start]).collect();
            let mut v: Vec<f64> = states.v.iter().map(|v| v[start]).collect();
            self.machine
                .project(record.t[start], &mut q, &mut v, self.values);
            for i in 0..n {
                simulated.q[i].push(q[i]);
                simulated.v[i].push(v[i]);
            }
        }
        simulated
    }
}

/// A prediction this far off has left the log for good, m or rad.
const OUTSIDE: f64 = 1e3;

/// Whether all accelerations are a sensor's, and none a filter's.
fn as_measured(record: &Record) -> bool {
    record.ddq.iter().all(Option::is_some)
}

/// Samples with a whole filter window around them: at the ends of a segment the
/// filter extrapolates, and its derivatives say little. Where predictions pass the filter, too,
/// so do those of every sample in the window. Where that leaves nothing, one window must do.
pub(crate) fn inner_samples(record: &Record, states: &SgStates) -> Vec<usize> {
    let half = states.filter.window / 2;
    let passes = if as_measured(record) { 1 } else { 2 };
    let inside = |margin: usize| -> Vec<usize> {
        let segments = record.segments().into_iter();
        segments
            .flat_map(|range| range.start + margin..range.end.saturating_sub(margin))
            .collect()
    };
    let inner = inside(passes * half);
    match inner.is_empty() {
        true => inside(half),
        false => inner,
    }
}

/// Generalised forces per coordinate and sample that the curve has and the model has not,
/// `M (dv/dt − a)`; none where accelerations are measured, as those were taken from the model.
fn unexplained_forces(record: &Record, curve: &States, motions: &[Motion]) -> Vec<Vec<f64>> {
    let n = record.q.len();
    let mut forces = vec![vec![0.0; record.len()]; n];
    for range in record.segments() {
        for k in range.clone() {
            let (before, after) = (k.max(range.start + 1) - 1, (k + 1).min(range.end - 1));
            let span = record.t[after] - record.t[before];
            let Motion {
                acceleration,
                terms,
                ..
            } = &motions[k];
            let beside = DVector::from_fn(n, |j, _| match record.ddq[j] {
                None if span > 0.0 => {
                    (curve.v[j][after] - curve.v[j][before]) / span - acceleration[j]
                }
                _ => 0.0,
            });
            let force = &terms.mass_matrix * beside;
            for i in 0..n {
                forces[i][k] = force[i];
            }
        }
    }
    forces
}

/// A prediction through the filter that the measurement passed.
pub(crate) fn filtered(record: &Record, states: &SgStates, values: &[f64]) -> Vec<f64> {
    let segments = record.segments().into_iter();
    let parts = segments.map(|range| {
        states
            .filter
            .apply(&record.t[range.clone()], &values[range], 0)
    });
    parts.flatten().collect()
}

pub(crate) fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// A scale below this share of the largest is round-off of it, by a wide margin: units and
/// joints differ by six orders of magnitude at most, sums of doubles are good to twelve.
pub(super) const NEGLIGIBLE: f64 = 1e-9;

/// The standard deviation of each column, to measure errors by; zero where a column does not
/// vary, but for round-off: there errors have no scale.
pub(super) fn scales(columns: &[Vec<f64>]) -> Vec<f64> {
    let mut scales: Vec<f64> = columns.iter().map(|column| deviation(column)).collect();
    let largest = scales.iter().copied().fold(0.0, f64::max);
    for scale in &mut scales {
        if *scale <= NEGLIGIBLE * largest {
            *scale = 0.0;
        }
    }
    scales
}

pub(crate) fn errors(record: &Record, misses: &[Vec<f64>], scale: &[f64]) -> Errors {
    let rms: Vec<f64> = misses
        .iter()
        .map(|miss| (miss.iter().map(|x| x * x).sum::<f64>() / miss.len() as f64).sqrt())
        .collect();
    combine(record, &rms, scale)
}

fn combine(record: &Record, rms: &[f64], scale: &[f64]) -> Errors {
    // A coordinate that never moves has no scale and says nothing; where none has one, there is
    // no share.
    let shares: Vec<f64> = rms
        .iter()
        .zip(scale)
        .filter(|&(_, &s)| s > 0.0)
        .map(|(r, s)| (r / s).powi(2))
        .collect();
    Errors {
        per_coordinate: record
            .coordinates
            .iter()
            .cloned()
            .zip(rms.iter().copied())
            .collect(),
        total: (shares.iter().sum::<f64>() / shares.len() as f64).sqrt(),
    }
}

pub(super) fn with_noise(mut record: Record, observed: &Observed, seed: u64) -> Record {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    // An error is what is left of the one before, and what makes it as large again.
    let mut shake = |values: &mut Vec<f64>, sd: f64, memory: f64| {
        let mut error = 0.0;
        for (k, value) in values.iter_mut().enumerate() {
            let draw: f64 = StandardNormal.sample(&mut random);
            let kept = if k == 0 { 0.0 } else { memory };
            error = kept * error + (1.0 - kept * kept).sqrt() * sd * draw;
            *value += error;
        }
    };
    let memory = &observed.sensor_memory.0;
    let measured: Vec<bool> = (0..record.q.len()).map(|i| record.is_measured(i)).collect();
    for i in (0..record.q.len()).filter(|&i| measured[i]) {
        shake(&mut record.q[i], observed.position_sd[i], memory[0][i]);
        if let Some(values) = &mut record.dq[i] {
            shake(values, observed.velocity_sd[i], memory[1][i]);
        }
        if let Some(values) = &mut record.ddq[i] {
            shake(values, observed.acceleration_sd[i], memory[2][i]);
        }
    }
    for (input, sd) in observed.noisy_inputs() {
        shake(&mut record.u[input], sd, 0.0);
    }
    for (i, [q, v]) in observed
        .echo
        .iter()
        .enumerate()
        .filter(|(i, _)| !measured[*i])
    {
        let add = |values: &mut [f64], by: &[f64]| {
            values
                .iter_mut()
                .zip(by)
                .for_each(|(value, by)| *value += by);
        };
        add(&mut record.q[i], q);
        record.dq[i].iter_mut().for_each(|values| add(values, v));
    }
    observed.felt_in(&record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Aside;

    /// The round-off of a filter along a locked joint is not its size.
    #[test]
    fn what_does_not_move_has_no_scale() {
        let moving = vec![1.0, -1.0, 1.0, -1.0];
        let locked = vec![3e-12, -2e-12, 1e-12, 0.0];
        assert_eq!(scales(&[moving, locked.clone()])[1], 0.0);
        assert!(
            scales(std::slice::from_ref(&locked))[0] > 0.0,
            "nothing to compare it with"
        );
        let record = Record {
            coordinates: vec!["a".into(), "b".into()],
            inputs: Vec::new(),
            t: vec![0.0; 4],
            q: vec![vec![0.0; 4]; 2],
            dq: vec![None; 2],
            ddq: vec![None; 2],
            u: Vec::new(),
            commanded: Vec::new(),
            aside: Aside::default(),
            doubts: Vec::new(),
            sensed: None,
            warnings: Vec::new(),
        };
        let shares = |scale: [f64; 2]| combine(&record, &[0.5, 0.5], &scale).total;
        assert_eq!(shares([1.0, 0.0]), 0.5);
        assert!(shares([0.0, 0.0]).is_nan());
    }
}
