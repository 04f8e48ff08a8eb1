//! A Kalman filter on the departure: white innovations for data and columns.

use super::error_dynamics::ErrorDynamics;
use super::gram::{BLOCKS, Gram};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Sensor readings minus the curve, and the sensors' noise.
#[derive(Debug, Clone)]
pub struct Readings {
    /// `y_q − q̂`, per coordinate.
    pub position: Vec<Vec<f64>>,
    /// Standard deviation of the position sensors.
    pub position_sd: Vec<f64>,
    /// `y_v − v̂` where velocity is measured.
    pub velocity: Vec<Option<Vec<f64>>>,
    /// Standard deviation of the velocity sensors.
    pub velocity_sd: Vec<f64>,
    /// `y_a` itself where acceleration is measured.
    pub acceleration: Vec<Option<Vec<f64>>>,
    /// Standard deviation of the acceleration sensors.
    pub acceleration_sd: Vec<f64>,
}

/// White forces that stand for whatever no column explains.
#[derive(Debug, Clone, PartialEq)]
pub struct ProcessNoise {
    /// Per coordinate: the standard deviation of a force that lasts
    /// [`CORRELATION`](Self::CORRELATION), in the coordinate's force unit.
    pub force_sd: DVector<f64>,
}

impl ProcessNoise {
    /// How long a force error is thought to last, s; it only sets the unit in
    /// which the intensity of white noise is expressed.
    pub const CORRELATION: f64 = 0.05;
}

/// One scalar reading: `z = h·δ + noise`, and the gain that the filter gives it.
#[derive(Debug, Clone)]
struct Update {
    sample: u32,
    sensor: Sensor,
    gain: DVector<f64>,
    /// Standard deviation of the innovation.
    sd: f64,
}

#[derive(Debug, Clone, Copy)]
enum Sensor {
    Position(usize),
    Velocity(usize),
    Acceleration(usize),
}

/// The filter's gains along the log; the same for the data and every column.
pub struct Whitener<'a> {
    dynamics: &'a ErrorDynamics,
    readings: &'a Readings,
    updates: Vec<Update>,
    /// Predicted covariance per sample, kept for smoothing.
    covariance: Vec<DMatrix<f64>>,
    /// `Σ ln sd`
    log_sd: f64,
    /// Intervals across which nothing is predicted.
    gaps: Vec<bool>,
}

impl<'a> Whitener<'a> {
    /// Runs the filter's covariance along the log.
    pub fn new(dynamics: &'a ErrorDynamics, readings: &'a Readings, noise: &ProcessNoise) -> Self {
        let n = dynamics.coordinate_count();
        let mut whitener = Self {
            dynamics,
            readings,
            updates: Vec::new(),
            covariance: Vec::with_capacity(dynamics.t.len()),
            log_sd: 0.0,
            gaps: gaps(&dynamics.t),
        };
        let initial = whitener.initial_covariance();
        let intensity = noise.force_sd.map(|sd| sd * sd * ProcessNoise::CORRELATION);
        let mut covariance = initial.clone();
        for sample in 0..dynamics.t.len() {
            whitener.covariance.push(covariance.clone());
            whitener.read(sample, &mut covariance);
            if sample + 1 == dynamics.t.len() {
                break;
            }
            covariance = if whitener.gaps[sample] {
                initial.clone()
            } else {
                let h = dynamics.t[sample + 1] - dynamics.t[sample];
                let phi = &dynamics.transition[sample];
                let mut next = phi * covariance * phi.transpose();
                let mobility = &dynamics.mobility[sample];
                let jolt = mobility * DMatrix::from_diagonal(&intensity) * mobility.transpose();
                let mut add = |row: usize, column: usize, factor: f64| {
                    let mut view = next.view_mut((row, column), (n, n));
                    view += &jolt * factor;
                };
                add(0, 0, h * h * h / 3.0);
                add(0, n, h * h / 2.0);
                add(n, 0, h * h / 2.0);
                add(n, n, h);
                (&next + next.transpose()) * 0.5
            };
        }
        whitener
    }

    /// Wide enough to leave the start to the data: the curve is within a few
    /// tens of sensor noises of the truth.
    fn initial_covariance(&self) -> DMatrix<f64> {
        let n = self.dynamics.coordinate_count();
        let h = self.dynamics.t[1] - self.dynamics.t[0];
        let mut covariance = DMatrix::zeros(2 * n, 2 * n);
        for i in 0..n {
            let position = 30.0 * self.readings.position_sd[i];
            let rate = match &self.readings.velocity[i] {
                Some(_) => 30.0 * self.readings.velocity_sd[i],
                None => 30.0 * self.readings.position_sd[i] / h.max(0.02),
            };
            covariance[(i, i)] = position * position;
            covariance[(n + i, n + i)] = rate * rate;
        }
        covariance
    }

    /// Takes in the readings of one sample, one scalar at a time.
    fn read(&mut self, sample: usize, covariance: &mut DMatrix<f64>) {
        let n = self.dynamics.coordinate_count();
        for i in 0..n {
            self.update(
                sample,
                Sensor::Position(i),
                self.readings.position_sd[i],
                covariance,
            );
            if self.readings.velocity[i].is_some() {
                self.update(
                    sample,
                    Sensor::Velocity(i),
                    self.readings.velocity_sd[i],
                    covariance,
                );
            }
            if self.readings.acceleration[i].is_some() {
                let sd = self.readings.acceleration_sd[i];
                self.update(sample, Sensor::Acceleration(i), sd, covariance);
            }
        }
    }

    fn update(
        &mut self,
        sample: usize,
        sensor: Sensor,
        noise_sd: f64,
        covariance: &mut DMatrix<f64>,
    ) {
        let n = self.dynamics.coordinate_count();
        let (column, own) = match sensor {
            Sensor::Position(i) => (covariance.column(i).into_owned(), covariance[(i, i)]),
            Sensor::Velocity(i) => (
                covariance.column(n + i).into_owned(),
                covariance[(n + i, n + i)],
            ),
            Sensor::Acceleration(i) => {
                let row = self.dynamics.slope[sample].row(i).transpose();
                let column = &*covariance * &row;
                let own = row.dot(&column);
                (column, own)
            }
        };
        let variance = own.max(0.0) + noise_sd * noise_sd;
        let gain = &column / variance;
        covariance.ger(-1.0 / variance, &column, &column, 1.0);
        let sd = variance.sqrt();
        self.log_sd += sd.ln();
        self.updates.push(Update {
            sample: sample as u32,
            sensor,
            gain,
            sd,
        });
    }

    /// `Σ ln sd` of all innovations: the part of the negative log likelihood that
    /// does not depend on the fit.
    pub fn log_sd(&self) -> f64 {
        self.log_sd
    }

    /// Number of scalar readings.
    pub fn reading_count(&self) -> usize {
        self.updates.len()
    }

    /// Products of all whitened columns, the data first, by blocks of the log.
    pub fn gram(&self) -> Gram {
        let width = self.dynamics.columns + 1;
        let threads = rayon::current_num_threads().max(1);
        let per = width.div_ceil(threads).max(8);
        let parts: Vec<DMatrix<f64>> = (0..width)
            .step_by(per)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|first| self.whiten(first, per.min(width - first), None))
            .collect();
        let mut rows = DMatrix::zeros(self.updates.len(), width);
        let mut next = 0;
        for part in parts {
            rows.columns_mut(next, part.ncols()).copy_from(&part);
            next += part.ncols();
        }
        Gram::new(&rows, &self.blocks())
    }

    /// Boundaries of the blocks in rows.
    fn blocks(&self) -> Vec<std::ops::Range<usize>> {
        let samples = self.dynamics.t.len();
        let row_at = |sample: usize| {
            self.updates
                .partition_point(|u| (u.sample as usize) < sample)
        };
        (0..BLOCKS)
            .map(|b| row_at(b * samples / BLOCKS)..row_at((b + 1) * samples / BLOCKS))
            .collect()
    }

    /// Whitened innovations of `count` columns from `first` on. With `mixture`,
    /// of the single column `data − Σ cⱼ columnⱼ` instead.
    fn whiten(&self, first: usize, count: usize, mixture: Option<&DVector<f64>>) -> DMatrix<f64> {
        let n = self.dynamics.coordinate_count();
        let pick = |all: &DMatrix<f64>| match mixture {
            None => all.columns(first, count).into_owned(),
            Some(weights) => DMatrix::from_column_slice(all.nrows(), 1, (all * weights).as_slice()),
        };
        let mut state = DMatrix::zeros(2 * n, count);
        let mut rows = DMatrix::zeros(self.updates.len(), count);
        let mut next = 0;
        for sample in 0..self.dynamics.t.len() {
            let direct = pick(&self.dynamics.acceleration[sample]);
            while next < self.updates.len() && self.updates[next].sample as usize == sample {
                let update = &self.updates[next];
                let mut innovation = self.predicted(sample, update.sensor, &state, &direct) * -1.0;
                if let (Some(data), true) = (self.reading(sample, update.sensor), first == 0) {
                    innovation[0] += data;
                }
                for column in 0..count {
                    state
                        .column_mut(column)
                        .axpy(innovation[column], &update.gain, 1.0);
                    rows[(next, column)] = innovation[column] / update.sd;
                }
                next += 1;
            }
            if sample + 1 < self.dynamics.t.len() {
                state = if self.gaps[sample] {
                    DMatrix::zeros(2 * n, count)
                } else {
                    &self.dynamics.transition[sample] * state + pick(&self.dynamics.forcing[sample])
                };
            }
        }
        // Columns are what a unit coefficient adds to the prediction, so their
        // innovations carry the opposite sign of the data's.
        for column in 0..count {
            if mixture.is_none() && first + column > 0 {
                rows.column_mut(column).neg_mut();
            }
        }
        rows
    }

    /// What the departure would make a sensor read.
    fn predicted(
        &self,
        sample: usize,
        sensor: Sensor,
        state: &DMatrix<f64>,
        direct: &DMatrix<f64>,
    ) -> DVector<f64> {
        let n = self.dynamics.coordinate_count();
        match sensor {
            Sensor::Position(i) => state.row(i).transpose(),
            Sensor::Velocity(i) => state.row(n + i).transpose(),
            Sensor::Acceleration(i) => {
                let slope = self.dynamics.slope[sample].row(i);
                (slope * state + direct.row(i)).transpose()
            }
        }
    }

    fn reading(&self, sample: usize, sensor: Sensor) -> Option<f64> {
        match sensor {
            Sensor::Position(i) => Some(self.readings.position[i][sample]),
            Sensor::Velocity(i) => self.readings.velocity[i].as_ref().map(|v| v[sample]),
            Sensor::Acceleration(i) => self.readings.acceleration[i].as_ref().map(|a| a[sample]),
        }
    }

    /// The departure `δ̂` given all readings, with the columns' coefficients
    /// `coefficients`: `2n` per sample (modified Bryson–Frazier smoother).
    pub fn smooth(&self, coefficients: &DVector<f64>) -> Vec<DVector<f64>> {
        let n = self.dynamics.coordinate_count();
        let weights = coefficients.clone().insert_row(0, 1.0);
        let rows = self.whiten(0, 1, Some(&weights));
        let predicted = self.predict(&weights, &rows);
        let mut adjoint = DVector::zeros(2 * n);
        let mut smoothed = vec![DVector::zeros(2 * n); self.dynamics.t.len()];
        let mut next = self.updates.len();
        for sample in (0..self.dynamics.t.len()).rev() {
            if sample + 1 < self.dynamics.t.len() {
                adjoint = if self.gaps[sample] {
                    DVector::zeros(2 * n)
                } else {
                    self.dynamics.transition[sample].tr_mul(&adjoint)
                };
            }
            while next > 0 && self.updates[next - 1].sample as usize == sample {
                next -= 1;
                let update = &self.updates[next];
                let pull = update.gain.dot(&adjoint) + rows[(next, 0)] / update.sd;
                match update.sensor {
                    Sensor::Position(i) => adjoint[i] -= pull,
                    Sensor::Velocity(i) => adjoint[n + i] -= pull,
                    Sensor::Acceleration(i) => {
                        adjoint -= self.dynamics.slope[sample].row(i).transpose() * pull;
                    }
                }
            }
            smoothed[sample] = &predicted[sample] - &self.covariance[sample] * &adjoint;
        }
        smoothed
    }

    /// One-step predictions of the departure, from known innovations.
    fn predict(&self, weights: &DVector<f64>, rows: &DMatrix<f64>) -> Vec<DVector<f64>> {
        let n = self.dynamics.coordinate_count();
        let mut state = DVector::zeros(2 * n);
        let mut predicted = Vec::with_capacity(self.dynamics.t.len());
        let mut next = 0;
        for sample in 0..self.dynamics.t.len() {
            predicted.push(state.clone());
            while next < self.updates.len() && self.updates[next].sample as usize == sample {
                let update = &self.updates[next];
                state.axpy(rows[(next, 0)] * update.sd, &update.gain, 1.0);
                next += 1;
            }
            if sample + 1 < self.dynamics.t.len() {
                state = if self.gaps[sample] {
                    DVector::zeros(2 * n)
                } else {
                    &self.dynamics.transition[sample] * state
                        + &self.dynamics.forcing[sample] * weights
                };
            }
        }
        predicted
    }
}

/// Intervals more than five times as long as usual.
fn gaps(t: &[f64]) -> Vec<bool> {
    let mut steps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    let all = steps.clone();
    steps.sort_by(f64::total_cmp);
    let usual = steps[steps.len() / 2];
    all.into_iter().map(|step| step > 5.0 * usual).collect()
}
