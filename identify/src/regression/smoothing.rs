//! The smoothed departure: what all readings together say of each sample.

use super::error_dynamics::ErrorDynamics;
use super::process_noise::ProcessNoise;
use super::readings::Readings;
use super::whitener::{Mix, Whitener};
use nalgebra::{DMatrix, DVector};

/// A filter that remembers how well it knew each sample before it was read.
pub struct Smoothing<'a> {
    whitener: Whitener<'a>,
    /// Predicted covariance per sample.
    covariance: Vec<DMatrix<f64>>,
}

impl<'a> Smoothing<'a> {
    /// Runs the filter's covariance along the log.
    pub fn new(dynamics: &'a ErrorDynamics, readings: &'a Readings, noise: &ProcessNoise) -> Self {
        let mut covariance = Vec::with_capacity(dynamics.t.len());
        let whitener = Whitener::along(dynamics, readings, noise, |predicted| {
            covariance.push(predicted.clone());
        });
        Self {
            whitener,
            covariance,
        }
    }

    /// The departure and force `(δq, δv, f)` given all readings, with the columns'
    /// coefficients `coefficients`: `3n` per sample (modified Bryson–Frazier smoother).
    pub fn smooth(&self, coefficients: &DVector<f64>) -> Vec<DVector<f64>> {
        let weights = coefficients.clone().insert_row(0, 1.0);
        let rows = self.whitener.whiten(&Mix::Sum(&weights));
        let predicted = self.predict(&weights);
        let mut smoothed = vec![DVector::zeros(0); self.whitener.dynamics.t.len()];
        self.whitener.backward(&rows, false, |sample, adjoint, _| {
            smoothed[sample] = &predicted[sample] - &self.covariance[sample] * &adjoint.vector;
        });
        smoothed
    }

    /// Variances of the departure and force `(δq, δv, f)` given all readings: `3n` per sample,
    /// the diagonal of `P − P Λ P`.
    pub fn variances(&self) -> Vec<DVector<f64>> {
        let nothing = DMatrix::zeros(self.whitener.updates.len(), 1);
        let mut variances = vec![DVector::zeros(0); self.whitener.dynamics.t.len()];
        self.whitener
            .backward(&nothing, true, |sample, adjoint, _| {
                let covariance = &self.covariance[sample];
                let known = adjoint.matrix.as_ref().map(|matrix| {
                    let known = covariance * matrix * covariance;
                    known.diagonal()
                });
                let left =
                    known.map_or(covariance.diagonal(), |known| covariance.diagonal() - known);
                // Negative only by rounding.
                variances[sample] = left.map(|variance| variance.max(0.0));
            });
        variances
    }

    /// One-step predictions of the departure. The innovations follow from the state anew:
    /// known ones would not hold back the round-off of a machine that falls over.
    fn predict(&self, weights: &DVector<f64>) -> Vec<DVector<f64>> {
        let whitener = &self.whitener;
        let mix = Mix::Sum(weights);
        let mut state = whitener.begin(0, &mix);
        let mut after = state.clone();
        let mut shown = DVector::zeros(1);
        let mut row = DVector::zeros(state.nrows());
        let mut predicted = Vec::with_capacity(whitener.dynamics.t.len());
        let mut next = 0;
        for sample in 0..whitener.dynamics.t.len() {
            predicted.push(state.column(0).into_owned());
            let direct = whitener.direct(sample, &mix);
            while next < whitener.updates.len() && whitener.updates[next].sample as usize == sample
            {
                let update = &whitener.updates[next];
                let read = (&mut row, &mut shown);
                whitener.predict_reading(update, &mix, (&state, &direct), read);
                let reading = whitener.reading(update).unwrap_or(shown[0]);
                let mut column = state.column_mut(0);
                column.axpy(reading - shown[0], &whitener.gain(next), 1.0);
                next += 1;
            }
            if sample + 1 < whitener.dynamics.t.len() {
                whitener.advance(sample, &mix, &mut state, &mut after);
            }
        }
        predicted
    }
}
