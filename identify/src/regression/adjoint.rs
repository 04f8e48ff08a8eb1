//! The filter backwards: how the likelihood depends on the size of the unexplained forces.

use super::readings::Sensor;
use super::small::congruence_transposed;
use super::whitener::{INTEGRALS, INTEGRALS_OF_JITTER, Mix, Update, Whitener, fresh_share};
use nalgebra::{DMatrix, DVector, DVectorView};

/// What the readings say about the forces that nothing explains, per coordinate, with
/// `σ²` their variance: `∂ ln L/∂σ² = (score − information)/2`.
#[derive(Debug, Clone)]
pub struct NoiseEvidence {
    /// `Σ λᵀCλ`, with `C` the covariance that a unit of `σ²` adds per interval.
    pub score: DVector<f64>,
    /// `Σ tr CΛ`, its expectation.
    pub information: DVector<f64>,
    /// The same of the white forces' variances.
    pub jitter_score: DVector<f64>,
    /// What is expected of that.
    pub jitter_information: DVector<f64>,
    /// The same of the square of the share that inputs do between samples.
    pub unseen_score: f64,
    /// What is expected of that.
    pub unseen_information: f64,
    /// The same of the variances with which constraints are missed, per holonomic one: `Σ u²`
    /// with `u` its smoothed error in units of its variance.
    pub closure_score: DVector<f64>,
    /// What is expected of that.
    pub closure_information: DVector<f64>,
    /// The same of the variances of the model's sensors that the log has.
    pub instrument_score: DVector<f64>,
    /// What is expected of that.
    pub instrument_information: DVector<f64>,
}

/// What the readings say about the error of one of them, or of a constraint.
pub(super) struct ReadingError {
    pub(super) sensor: Sensor,
    /// The row of the log that it stands in.
    pub(super) reading: usize,
    /// Its smoothed value, in units of its variance.
    pub(super) pull: f64,
    /// What is expected of the square of that.
    pub(super) own: f64,
}

impl NoiseEvidence {
    fn count(&mut self, error: &ReadingError) {
        let (score, information, place) = match error.sensor {
            Sensor::Closure(row) => (&mut self.closure_score, &mut self.closure_information, row),
            Sensor::Instrument(place) => (
                &mut self.instrument_score,
                &mut self.instrument_information,
                place,
            ),
            _ => return,
        };
        score[place] += error.pull.powi(2);
        information[place] += error.own;
    }
}

/// The adjoint state of the modified Bryson–Frazier smoother.
pub(super) struct Adjoint {
    /// `λ`, `3n`.
    pub(super) vector: DVector<f64>,
    /// `Λ`, `3n×3n`, its covariance; empty if not wanted.
    pub(super) matrix: Option<DMatrix<f64>>,
    /// There to be written to, `3n`.
    image: DVector<f64>,
}

impl Whitener<'_> {
    /// The evidence about the unexplained forces' size, with the columns' coefficients
    /// `coefficients`.
    pub fn noise_evidence(&self, coefficients: &DVector<f64>) -> NoiseEvidence {
        let weights = coefficients.clone().insert_row(0, 1.0);
        let rows = self.whiten(&Mix::Sum(&weights));
        let n = self.dynamics.coordinate_count();
        let mut evidence = NoiseEvidence {
            score: DVector::zeros(n),
            information: DVector::zeros(n),
            jitter_score: DVector::zeros(n),
            jitter_information: DVector::zeros(n),
            unseen_score: 0.0,
            unseen_information: 0.0,
            closure_score: DVector::zeros(self.dynamics.closed.rows()),
            closure_information: DVector::zeros(self.dynamics.closed.rows()),
            instrument_score: DVector::zeros(self.instrument_count()),
            instrument_information: DVector::zeros(self.instrument_count()),
        };
        self.backward(&rows, true, |sample, adjoint, errors| {
            let Some(matrix) = &adjoint.matrix else {
                return;
            };
            for error in errors {
                evidence.count(error);
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
                let (pull, spread) = along_force(&adjoint.vector, matrix, (phi, i, h));
                let fresh = fresh_share(phi[(2 * n + i, 2 * n + i)]);
                for (a, row) in INTEGRALS.iter().enumerate() {
                    for (b, weight) in row.iter().enumerate() {
                        evidence.score[i] += fresh * weight * pull[a] * pull[b];
                        evidence.information[i] += fresh * weight * spread[a][b];
                    }
                }
                let (mut score, mut information) = (0.0, 0.0);
                for (a, row) in INTEGRALS_OF_JITTER.iter().enumerate() {
                    for (b, weight) in row.iter().enumerate() {
                        score += weight * pull[1 + a] * pull[1 + b];
                        information += weight * spread[1 + a][1 + b];
                    }
                }
                evidence.jitter_score[i] += score / h;
                evidence.jitter_information[i] += information / h;
                let unseen = self.dynamics.unseen[sample - 1][i].powi(2);
                evidence.unseen_score += unseen * score;
                evidence.unseen_information += unseen * information;
            }
        });
        evidence
    }

    /// Runs the adjoint from the last sample to the first; `see` is shown its state
    /// after the readings of each sample, where it belongs to the prediction, and what was
    /// said about the errors of these, and of its constraints.
    pub(super) fn backward(
        &self,
        rows: &DMatrix<f64>,
        with_matrix: bool,
        mut see: impl FnMut(usize, &Adjoint, &[ReadingError]),
    ) {
        let size = 3 * self.dynamics.coordinate_count();
        let nothing = || Adjoint {
            vector: DVector::zeros(size),
            matrix: with_matrix.then(|| DMatrix::zeros(size, size)),
            image: DVector::zeros(size),
        };
        let mut adjoint = nothing();
        let mut row = DVector::zeros(size);
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
                let reading = (update, self.gain(next), rows[(next, 0)]);
                let (pull, own) = match self.unit_row(update) {
                    Some(place) => adjoint.undo_at(reading, place),
                    None => {
                        self.write_slope(update, &mut row);
                        adjoint.undo(reading, &row)
                    }
                };
                errors.push(ReadingError {
                    sensor: update.sensor,
                    reading: update.reading as usize,
                    pull,
                    own,
                });
            }
            see(sample, &adjoint, &errors);
        }
    }
}

/// `λ` and `Λ` along what a unit of force `i` has done by the end of an interval: in `f` itself,
/// in `v` and in `q`.
fn along_force(
    vector: &DVector<f64>,
    matrix: &DMatrix<f64>,
    (phi, i, h): (&DMatrix<f64>, usize, f64),
) -> ([f64; 3], [[f64; 3]; 3]) {
    let n = vector.len() / 3;
    // To the first order in h the transition holds P h.
    let pushed = |row: usize| phi[(n + row, 2 * n + i)];
    // Of `v` and `q`: where they begin, and what a velocity makes of them.
    let moved = [(n, 1.0), (0, h)];
    let own = 2 * n + i;
    let mut pull = [vector[own], 0.0, 0.0];
    let mut spread = [[0.0; 3]; 3];
    spread[0][0] = matrix[(own, own)];
    for (a, (first, factor)) in (1..).zip(moved) {
        for row in 0..n {
            let weight = factor * pushed(row);
            pull[a] += weight * vector[first + row];
            spread[0][a] += weight * matrix[(own, first + row)];
            for (b, (second, factor)) in (1..).zip(moved) {
                let across = (0..n).map(|s| pushed(s) * matrix[(first + row, second + s)]);
                spread[a][b] += weight * factor * across.sum::<f64>();
            }
        }
        spread[a][0] = spread[0][a];
    }
    (pull, spread)
}

/// A reading, its gain and its whitened innovation.
type Read<'a> = (&'a Update, DVectorView<'a, f64>, f64);

impl Adjoint {
    /// `λ ← Φᵀλ`, `Λ ← ΦᵀΛΦ`
    fn pass(&mut self, transition: &DMatrix<f64>) {
        self.image.gemv_tr(1.0, transition, &self.vector, 0.0);
        std::mem::swap(&mut self.vector, &mut self.image);
        if let Some(matrix) = &mut self.matrix {
            // `undo` relies on symmetry: what round-off leaves of the other part would grow.
            congruence_transposed(transition, matrix);
        }
    }

    /// [`Adjoint::undo`] for `h` a unit vector: only one row and column change.
    fn undo_at(&mut self, (update, gain, innovation): Read<'_>, place: usize) -> (f64, f64) {
        let pull = gain.dot(&self.vector) + innovation / update.sd;
        self.vector[place] -= pull;
        let mut own = 1.0 / (update.sd * update.sd);
        if let Some(matrix) = &mut self.matrix {
            let image = &mut self.image;
            image.gemv(1.0, matrix, &gain, 0.0);
            own += gain.dot(image);
            let mut column = matrix.column_mut(place);
            column -= &*image;
            let mut row = matrix.row_mut(place);
            for (entry, change) in row.iter_mut().zip(image.iter()) {
                *entry -= change;
            }
            matrix[(place, place)] += own;
        }
        (pull, own)
    }

    /// With `C = I − K hᵀ`: `λ ← Cᵀλ − h ν/S`, `Λ ← CᵀΛC + h hᵀ/S`. Returns the reading's
    /// smoothed error in units of its variance, and what is expected of its square.
    fn undo(&mut self, (update, gain, innovation): Read<'_>, row: &DVector<f64>) -> (f64, f64) {
        let pull = gain.dot(&self.vector) + innovation / update.sd;
        self.vector.axpy(-pull, row, 1.0);
        let mut own = 1.0 / (update.sd * update.sd);
        if let Some(matrix) = &mut self.matrix {
            let image = &mut self.image;
            image.gemv(1.0, matrix, &gain, 0.0);
            own += gain.dot(image);
            matrix.ger(-1.0, row, image, 1.0);
            matrix.ger(-1.0, image, row, 1.0);
            matrix.ger(own, row, row, 1.0);
        }
        (pull, own)
    }
}
