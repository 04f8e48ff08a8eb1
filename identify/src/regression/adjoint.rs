//! The filter backwards: the smoothed departure, and how the likelihood depends on
//! the size of the unexplained forces.

use super::whitener::{INTEGRALS, Mix, Sensor, Update, Whitener, fresh_share, write_directions};
use nalgebra::{DMatrix, DVector};

/// What the readings say about the forces that nothing explains, per coordinate, with
/// `σ²` their variance: `∂ ln L/∂σ² = (score − information)/2`.
#[derive(Debug, Clone)]
pub struct NoiseEvidence {
    /// `Σ λᵀCλ`, with `C` the covariance that a unit of `σ²` adds per interval.
    pub score: DVector<f64>,
    /// `Σ tr CΛ`, its expectation.
    pub information: DVector<f64>,
    /// The same of the variances with which constraints are missed, per holonomic one: `Σ u²`
    /// with `u` its smoothed error in units of its variance.
    pub closure_score: DVector<f64>,
    /// What is expected of that.
    pub closure_information: DVector<f64>,
}

/// What the readings say about the error of one constraint at one sample.
struct ClosureError {
    row: usize,
    /// Its smoothed value, in units of its variance.
    pull: f64,
    /// What is expected of the square of that.
    own: f64,
}

/// The adjoint state of the modified Bryson–Frazier smoother.
struct Adjoint {
    /// `λ`, `3n`.
    vector: DVector<f64>,
    /// `Λ`, `3n×3n`, its covariance; empty if not wanted.
    matrix: Option<DMatrix<f64>>,
}

impl Whitener<'_> {
    /// The departure and force `(δq, δv, f)` given all readings, with the columns'
    /// coefficients `coefficients`: `3n` per sample (modified Bryson–Frazier smoother).
    pub fn smooth(&self, coefficients: &DVector<f64>) -> Vec<DVector<f64>> {
        let weights = coefficients.clone().insert_row(0, 1.0);
        let rows = self.whiten(&Mix::Sum(&weights));
        let predicted = self.predict(&weights);
        let mut smoothed = vec![DVector::zeros(0); self.dynamics.t.len()];
        self.backward(&rows, false, |sample, adjoint, _| {
            smoothed[sample] = &predicted[sample] - &self.covariance[sample] * &adjoint.vector;
        });
        smoothed
    }

    /// The evidence about the unexplained forces' size, with the columns' coefficients
    /// `coefficients`.
    pub fn noise_evidence(&self, coefficients: &DVector<f64>) -> NoiseEvidence {
        let weights = coefficients.clone().insert_row(0, 1.0);
        let rows = self.whiten(&Mix::Sum(&weights));
        let n = self.dynamics.coordinate_count();
        let mut evidence = NoiseEvidence {
            score: DVector::zeros(n),
            information: DVector::zeros(n),
            closure_score: DVector::zeros(self.dynamics.closed.rows()),
            closure_information: DVector::zeros(self.dynamics.closed.rows()),
        };
        let mut directions = DMatrix::zeros(3 * n, 3);
        self.backward(&rows, true, |sample, adjoint, errors| {
            let Some(matrix) = &adjoint.matrix else {
                return;
            };
            for error in errors {
                evidence.closure_score[error.row] += error.pull.powi(2);
                evidence.closure_information[error.row] += error.own;
            }
            let begins = sample == 0 || self.gaps[sample - 1];
            for i in 0..n {
                if begins {
                    evidence.score[i] += adjoint.vector[2 * n + i].powi(2);
                    evidence.information[i] += matrix[(2 * n + i, 2 * n + i)];
                    continue;
                }
                let h = self.dynamics.t[sample] - self.dynamics.t[sample - 1];
                let phi = &self.dynamics.transition[sample - 1];
                write_directions(&mut directions, phi, i, h);
                let pull = directions.tr_mul(&adjoint.vector);
                let spread = directions.tr_mul(&(matrix * &directions));
                let fresh = fresh_share(h);
                for (a, row) in INTEGRALS.iter().enumerate() {
                    for (b, weight) in row.iter().enumerate() {
                        evidence.score[i] += fresh * weight * pull[a] * pull[b];
                        evidence.information[i] += fresh * weight * spread[(a, b)];
                    }
                }
            }
        });
        evidence
    }

    /// Runs the adjoint from the last sample to the first; `see` is shown its state
    /// after the readings of each sample, where it belongs to the prediction, and what was
    /// said about the errors of its constraints.
    fn backward(
        &self,
        rows: &DMatrix<f64>,
        with_matrix: bool,
        mut see: impl FnMut(usize, &Adjoint, &[ClosureError]),
    ) {
        let size = 3 * self.dynamics.coordinate_count();
        let nothing = || Adjoint {
            vector: DVector::zeros(size),
            matrix: with_matrix.then(|| DMatrix::zeros(size, size)),
        };
        let mut adjoint = nothing();
        let mut next = self.updates.len();
        let mut errors = Vec::new();
        for sample in (0..self.dynamics.t.len()).rev() {
            errors.clear();
            if sample + 1 < self.dynamics.t.len() {
                if self.gaps[sample] {
                    adjoint = nothing();
                } else {
                    adjoint.pass(&self.dynamics.transition[sample]);
                }
            }
            while next > 0 && self.updates[next - 1].sample as usize == sample {
                next -= 1;
                let update = &self.updates[next];
                if let Some(place) = self.unit_row(update) {
                    adjoint.undo_at(update, rows[(next, 0)], place);
                    continue;
                }
                let row = self.slope_row(update.sample as usize, update.sensor);
                let (pull, own) = adjoint.undo(update, rows[(next, 0)], &row);
                if let Sensor::Closure(row) = update.sensor {
                    errors.push(ClosureError { row, pull, own });
                }
            }
            see(sample, &adjoint, &errors);
        }
    }

    /// The entry of `δ` that a reading shows, if it shows one alone.
    fn unit_row(&self, update: &Update) -> Option<usize> {
        match update.sensor {
            Sensor::Position(i) => Some(i),
            Sensor::Velocity(i) => Some(self.dynamics.coordinate_count() + i),
            Sensor::Acceleration(_) | Sensor::Closure(_) => None,
        }
    }

    /// One-step predictions of the departure. The innovations follow from the state anew:
    /// known ones would not hold back the round-off of a machine that falls over.
    fn predict(&self, weights: &DVector<f64>) -> Vec<DVector<f64>> {
        let n = self.dynamics.coordinate_count();
        let mix = Mix::Sum(weights);
        let mut state = self.begin(0, &mix);
        let mut shown = DVector::zeros(1);
        let mut predicted = Vec::with_capacity(self.dynamics.t.len());
        let mut next = 0;
        for sample in 0..self.dynamics.t.len() {
            predicted.push(state.column(0).into_owned());
            let direct = self.direct(sample, &mix);
            while next < self.updates.len() && self.updates[next].sample as usize == sample {
                let update = &self.updates[next];
                self.predict_reading(sample, update.sensor, (&state, &direct), &mut shown);
                let reading = self.reading(sample, update.sensor).unwrap_or(shown[0]);
                let mut column = state.column_mut(0);
                column.axpy(reading - shown[0], &update.gain, 1.0);
                next += 1;
            }
            if sample + 1 < self.dynamics.t.len() {
                state = if self.gaps[sample] {
                    self.begin(sample + 1, &mix)
                } else {
                    let mut next = &self.dynamics.transition[sample] * state;
                    let mut pushed = next.rows_mut(0, 2 * n);
                    pushed += &self.dynamics.forcing[sample] * weights;
                    next
                };
            }
        }
        predicted
    }
}

impl Adjoint {
    /// `λ ← Φᵀλ`, `Λ ← ΦᵀΛΦ`
    fn pass(&mut self, transition: &DMatrix<f64>) {
        self.vector = transition.tr_mul(&self.vector);
        if let Some(matrix) = &mut self.matrix {
            let passed = transition.tr_mul(&(&*matrix * transition));
            // `undo` relies on symmetry: what round-off leaves of the other part would grow.
            *matrix = (&passed + passed.transpose()) * 0.5;
        }
    }

    /// [`Adjoint::undo`] for `h` a unit vector: only one row and column change.
    fn undo_at(&mut self, update: &Update, innovation: f64, place: usize) {
        let pull = update.gain.dot(&self.vector) + innovation / update.sd;
        self.vector[place] -= pull;
        if let Some(matrix) = &mut self.matrix {
            let image = &*matrix * &update.gain;
            let own = update.gain.dot(&image) + 1.0 / (update.sd * update.sd);
            let mut column = matrix.column_mut(place);
            column -= &image;
            let mut row = matrix.row_mut(place);
            for (entry, change) in row.iter_mut().zip(image.iter()) {
                *entry -= change;
            }
            matrix[(place, place)] += own;
        }
    }

    /// With `C = I − K hᵀ`: `λ ← Cᵀλ − h ν/S`, `Λ ← CᵀΛC + h hᵀ/S`. Returns the reading's
    /// smoothed error in units of its variance, and what is expected of its square.
    fn undo(&mut self, update: &Update, innovation: f64, row: &DVector<f64>) -> (f64, f64) {
        let pull = update.gain.dot(&self.vector) + innovation / update.sd;
        self.vector.axpy(-pull, row, 1.0);
        let mut own = 1.0 / (update.sd * update.sd);
        if let Some(matrix) = &mut self.matrix {
            let image = &*matrix * &update.gain;
            own += update.gain.dot(&image);
            matrix.ger(-1.0, row, &image, 1.0);
            matrix.ger(-1.0, &image, row, 1.0);
            matrix.ger(own, row, row, 1.0);
        }
        (pull, own)
    }
}
