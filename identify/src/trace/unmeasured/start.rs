//! A first curve: what sensors say without the model's dynamics.
//!
//! Each coordinate's acceleration comes and goes at random (R. A. Singer, *IEEE Trans. Aerosp.
//! Electron. Syst.* 6, 1970), `ȧ = −a/τ + w`: over times longer than `τ` it averages to nothing, so
//! that accelerometers show where gravity points. An iterated extended Kalman filter takes in what
//! is read, sample by sample, and a Rauch–Tung–Striebel smoother goes back. How large accelerations
//! are, and where the machine began, the evidence of the log's beginning decides.

use super::super::estimate::Observed;
use super::dials::{Dials, Rows};
use super::{CHOSEN, UNKNOWN, WITHIN};
use crate::log::longest_step;
use crate::machine::{Machine, SolveError, States};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::dimension::Dimension;
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

/// How long an acceleration lasts, s.
const LASTING: f64 = 0.5;
/// Accelerations that are tried, per s² in the coordinate's unit.
const SIZES: [f64; 6] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
/// Positions at which an unmeasured angle is thought to begin, beside zero, rad.
const TURNED: [f64; 2] = [-2.0, 2.0];
/// Samples whose evidence decides, round by round,
const LOOKED_AT: [usize; 3] = [75, 200, 600];
/// and the share of what was tried that a round leaves.
const LEFT: usize = 3;
/// Rounds in which a sample's readings are taken in, and halvings of a step that leads uphill.
const ROUNDS: usize = 15;
const HALVINGS: usize = 6;
/// A change of this share of a standard deviation ends the rounds.
const SETTLED: f64 = 1e-2;

/// The curve that the sensors show, on which `cyclic` coordinates begin at zero.
///
/// # Errors
/// If the filter finds no finite motion at all.
pub(super) fn start(
    machine: &mut Machine,
    values: &[f64],
    observed: &Observed,
    cyclic: &[bool],
) -> Result<States, SolveError> {
    let n = machine.coordinate_count();
    let by = (0..n)
        .map(Variable::Position)
        .chain((0..n).map(Variable::Velocity));
    let instruments = machine.instruments(&by.collect::<Vec<Variable>>());
    let leads = instruments.leads(values);
    let dials = Dials {
        machine,
        leads: leads.map_or_else(|| vec![0.0; instruments.count()], |(leads, _)| leads),
        instruments: &instruments,
        values,
        observed,
    };
    let guesses = guesses(machine, observed, cyclic);
    let tries = guesses
        .iter()
        .flat_map(|guess| SIZES.map(|size| (guess, size)));
    let mut tries: Vec<(&Vec<f64>, f64)> = tries.collect();
    let evidence = |&(guess, size): &(&Vec<f64>, f64), looked_at: usize| {
        let filter = Filter {
            dials: &dials,
            cyclic,
            size,
        };
        let evidence: f64 = filter
            .run(guess, looked_at.min(observed.record.len()))
            .iter()
            .map(|s| s.evidence)
            .sum();
        if evidence.is_finite() {
            evidence
        } else {
            f64::NEG_INFINITY
        }
    };
    for looked_at in LOOKED_AT {
        let all: Vec<f64> = tries
            .par_iter()
            .map(|one| evidence(one, looked_at))
            .collect();
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.retain(|&one| all[one] > f64::NEG_INFINITY);
        // Stable: of equals the one that comes first is kept.
        order.sort_by(|&a, &b| all[b].total_cmp(&all[a]));
        order.truncate(tries.len().div_ceil(LEFT));
        tries = order.iter().map(|&one| tries[one]).collect();
    }
    let &(guess, size) = tries.first().ok_or(SolveError::NotFinite { sample: 0 })?;
    let filter = Filter {
        dials: &dials,
        cyclic,
        size,
    };
    let smoothed = filter.backward(&filter.run(guess, observed.record.len()));
    let is_finite = |x: &DVector<f64>| x.iter().all(|x| x.is_finite());
    if let Some(sample) = smoothed.iter().position(|x| !is_finite(x)) {
        return Err(SolveError::NotFinite { sample });
    }
    Ok(with_unmeasured(observed, &smoothed))
}

/// The measured coordinates as they are, the others as found.
fn with_unmeasured(observed: &Observed, smoothed: &[DVector<f64>]) -> States {
    let mut curve = observed.curve.clone();
    let n = curve.q.len();
    for i in (0..n).filter(|&i| !observed.record.is_measured(i)) {
        curve.q[i] = smoothed.iter().map(|x| x[i]).collect();
        curve.v[i] = smoothed.iter().map(|x| x[n + i]).collect();
    }
    curve
}

/// Where the machine may have begun: at zero, or with one unmeasured angle turned.
fn guesses(machine: &Machine, observed: &Observed, cyclic: &[bool]) -> Vec<Vec<f64>> {
    let coordinates = &machine.compiled.model.coordinates;
    let zero = vec![0.0; coordinates.len()];
    let turned = |i: usize| {
        let zero = zero.clone();
        TURNED.map(|angle| {
            let mut guess = zero.clone();
            guess[i] = angle;
            guess
        })
    };
    let angles = (0..coordinates.len()).filter(|&i| {
        let is_open = !observed.record.is_measured(i) && !cyclic[i];
        is_open && coordinates[i].dimension == Some(Dimension::ONE)
    });
    std::iter::once(zero.clone())
        .chain(angles.flat_map(turned))
        .collect()
}

/// Means and covariances of `(q, v, a)`, `3n`, at one sample.
struct Step {
    predicted: (DVector<f64>, DMatrix<f64>),
    filtered: (DVector<f64>, DMatrix<f64>),
    /// Log evidence of the sample's readings, given those before (Laplace's method).
    evidence: f64,
}

struct Filter<'a> {
    dials: &'a Dials<'a>,
    cyclic: &'a [bool],
    /// Standard deviation of accelerations.
    size: f64,
}

impl Filter<'_> {
    fn run(&self, guess: &[f64], samples: usize) -> Vec<Step> {
        let t = &self.dials.observed.record.t;
        let longest = longest_step(t);
        let mut steps: Vec<Step> = Vec::with_capacity(samples);
        for sample in 0..samples {
            let predicted = match steps.last() {
                Some(last) if t[sample] - t[sample - 1] <= longest => {
                    self.ahead(&last.filtered, t[sample] - t[sample - 1])
                }
                Some(last) => self.anew(last.filtered.0.as_slice()),
                None => self.anew(guess),
            };
            steps.push(self.taken_in(sample, predicted));
        }
        steps
    }

    /// What is known where nothing came before: positions near `guess`.
    fn anew(&self, guess: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.dials.machine.coordinate_count();
        let mean = DVector::from_fn(3 * n, |row, _| if row < n { guess[row] } else { 0.0 });
        let sd = [UNKNOWN[0], UNKNOWN[1], self.size];
        let is_chosen = |row: usize| row < n && self.cyclic[row];
        let sd = |row: usize| match is_chosen(row) {
            true => WITHIN * CHOSEN,
            false => sd[row / n],
        };
        let variances = DVector::from_fn(3 * n, |row, _| sd(row).powi(2));
        (mean, DMatrix::from_diagonal(&variances))
    }

    /// `Φ` over `h` seconds.
    fn transition(&self, h: f64) -> DMatrix<f64> {
        let n = self.dials.machine.coordinate_count();
        let decay = (-h / LASTING).exp();
        let moved = LASTING * (1.0 - decay);
        let mut phi = DMatrix::identity(3 * n, 3 * n);
        for i in 0..n {
            phi[(i, n + i)] = h;
            phi[(i, 2 * n + i)] = LASTING * (h - moved);
            phi[(n + i, 2 * n + i)] = moved;
            phi[(2 * n + i, 2 * n + i)] = decay;
        }
        phi
    }

    fn ahead(
        &self,
        (mean, covariance): &(DVector<f64>, DMatrix<f64>),
        h: f64,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.dials.machine.coordinate_count();
        let phi = self.transition(h);
        let mut next = &phi * covariance * phi.transpose();
        // A Wiener process in the acceleration, with its first two integrals.
        let fresh = 2.0 * self.size.powi(2) / LASTING;
        let integrals = [
            [h.powi(5) / 20.0, h.powi(4) / 8.0, h.powi(3) / 6.0],
            [h.powi(4) / 8.0, h.powi(3) / 3.0, h.powi(2) / 2.0],
            [h.powi(3) / 6.0, h.powi(2) / 2.0, h],
        ];
        for i in 0..n {
            for (a, row) in integrals.iter().enumerate() {
                for (b, integral) in row.iter().enumerate() {
                    next[(a * n + i, b * n + i)] += fresh * integral;
                }
            }
        }
        (phi * mean, next)
    }

    /// Takes in the readings of a sample by Gauss–Newton steps from the prediction `m, P`: the
    /// state is `m + P w`, so that its prior costs `½ wᵀ P w`.
    fn taken_in(&self, sample: usize, predicted: (DVector<f64>, DMatrix<f64>)) -> Step {
        let (mean, prior) = &predicted;
        let at = |weights: &DVector<f64>| mean + prior * weights;
        let cost = |rows: &Rows, weights: &DVector<f64>| {
            rows.misfit() + 0.5 * weights.dot(&(prior * weights))
        };
        let mut weights = DVector::zeros(mean.len());
        let mut rows = self.dials.at(sample, mean);
        let mut now = cost(&rows, &weights);
        for _ in 0..ROUNDS {
            let Some(update) = Update::new(prior, &rows) else {
                break;
            };
            let wanted = update.weights(&rows, &(at(&weights) - mean));
            let mut change = wanted - &weights;
            let mut taken = false;
            for _ in 0..HALVINGS {
                let next = &weights + &change;
                let there = self.dials.at(sample, &at(&next));
                let then = cost(&there, &next);
                // The rows that are numbers may be others there.
                if then <= now || there.miss.len() > rows.miss.len() {
                    (weights, rows, now, taken) = (next, there, then, true);
                    break;
                }
                change *= 0.5;
            }
            if !taken || change.dot(&(prior * &change)) < SETTLED * SETTLED {
                break;
            }
        }
        let filtered = match Update::new(prior, &rows) {
            Some(update) => (at(&weights), update.covariance(prior)),
            None => predicted.clone(),
        };
        let spread = Update::new(prior, &rows).map_or(0.0, |update| update.half_log_determinant());
        Step {
            evidence: -now - spread,
            filtered,
            predicted,
        }
    }

    /// The smoothed states, `3n` each.
    fn backward(&self, steps: &[Step]) -> Vec<DVector<f64>> {
        let t = &self.dials.observed.record.t;
        let longest = longest_step(t);
        let mut smoothed: Vec<DVector<f64>> = steps.iter().map(|s| s.filtered.0.clone()).collect();
        for k in (0..steps.len().saturating_sub(1)).rev() {
            let h = t[k + 1] - t[k];
            let next = &steps[k + 1].predicted;
            let regular = Cholesky::new(next.1.clone()).filter(|_| h <= longest);
            if let Some(regular) = regular {
                let (mean, covariance) = &steps[k].filtered;
                let pull = regular.solve(&(&smoothed[k + 1] - &next.0));
                smoothed[k] = mean + covariance * self.transition(h).transpose() * pull;
            }
        }
        smoothed
    }
}

/// Readings with the covariance `S = H P Hᵀ + R` of their innovations.
struct Update {
    slope: DMatrix<f64>,
    innovation: Cholesky<f64, nalgebra::Dyn>,
}

impl Update {
    fn new(prior: &DMatrix<f64>, rows: &Rows) -> Option<Self> {
        if rows.miss.is_empty() {
            return None;
        }
        let slope = DMatrix::from_rows(&rows.slope);
        let variances = DVector::from_iterator(rows.sd.len(), rows.sd.iter().map(|sd| sd * sd));
        let spread = &slope * prior * slope.transpose() + DMatrix::from_diagonal(&variances);
        let innovation = Cholesky::new(spread)?;
        Some(Self { slope, innovation })
    }

    /// `w = Hᵀ S⁻¹ (y − h + H δ)`, where the state departs by `δ` from its prediction.
    fn weights(&self, rows: &Rows, departure: &DVector<f64>) -> DVector<f64> {
        let miss = DVector::from_column_slice(&rows.miss) + &self.slope * departure;
        self.slope.tr_mul(&self.innovation.solve(&miss))
    }

    /// `P − P Hᵀ S⁻¹ H P`
    fn covariance(&self, prior: &DMatrix<f64>) -> DMatrix<f64> {
        let across = &self.slope * prior;
        let left = prior - across.tr_mul(&self.innovation.solve(&across));
        0.5 * (&left + left.transpose())
    }

    fn half_log_determinant(&self) -> f64 {
        let factor = self.innovation.l_dirty();
        factor.diagonal().iter().map(|x| x.abs().ln()).sum()
    }
}
