//! A Kalman filter on the departure: white innovations for data and columns.

use super::error_dynamics::{CORRELATION, ErrorDynamics};
use super::gram::{BLOCKS, Gram};
use super::process_noise::ProcessNoise;
use super::readings::{Readings, Sensor};
use super::small::congruence;
use crate::log::longest_step;
use nalgebra::{DMatrix, DMatrixViewMut, DVector, DVectorView};
use rayon::prelude::*;

/// One scalar reading: `z = h·δ + noise`.
#[derive(Debug, Clone)]
pub(super) struct Update {
    /// The sample next to which it was made.
    pub(super) sample: u32,
    pub(super) sensor: Sensor,
    /// The row of the log that it stands in.
    pub(super) reading: u32,
    /// Standard deviation of the innovation.
    pub(super) sd: f64,
}

/// The filter's gains along the log; the same for the data and every column.
pub struct Whitener<'a> {
    pub(super) dynamics: &'a ErrorDynamics,
    pub(super) readings: &'a Readings,
    pub(super) updates: Vec<Update>,
    /// What the filter makes of a unit of each innovation, `3n` numbers after the other.
    gains: Vec<f64>,
    /// `Σ ln sd`
    log_sd: f64,
    /// Intervals across which nothing is predicted.
    pub(super) gaps: Vec<bool>,
}

impl<'a> Whitener<'a> {
    /// Runs the filter's covariance along the log.
    pub fn new(dynamics: &'a ErrorDynamics, readings: &'a Readings, noise: &ProcessNoise) -> Self {
        Self::along(dynamics, readings, noise, |_| {})
    }

    /// The same; `see` is shown the covariance that is predicted for each sample.
    pub(super) fn along(
        dynamics: &'a ErrorDynamics,
        readings: &'a Readings,
        noise: &ProcessNoise,
        mut see: impl FnMut(&DMatrix<f64>),
    ) -> Self {
        let mut whitener = Self {
            dynamics,
            readings,
            updates: Vec::new(),
            gains: Vec::new(),
            log_sd: readings.log_slope,
            gaps: gaps(&dynamics.t),
        };
        let n = dynamics.coordinate_count();
        let initial = whitener.initial_covariance(noise);
        let mut covariance = initial.clone();
        let mut row = DVector::zeros(initial.nrows());
        let mut column = row.clone();
        for sample in 0..dynamics.t.len() {
            see(&covariance);
            let mut update = |sensor, reading: usize, sd| {
                let update = Update {
                    sample: sample as u32,
                    sensor,
                    reading: reading as u32,
                    sd,
                };
                whitener.update(update, &mut covariance, (&mut row, &mut column));
            };
            readings.each(n, sample, &dynamics.moments, &mut update);
            for (row, &sd) in noise.closure_sd.iter().enumerate() {
                update(Sensor::Closure(row), sample, sd);
            }
            if sample + 1 == dynamics.t.len() {
                break;
            }
            if whitener.gaps[sample] {
                covariance.copy_from(&initial);
                continue;
            }
            let h = dynamics.t[sample + 1] - dynamics.t[sample];
            let phi = &dynamics.transition[sample];
            congruence(phi, &mut covariance);
            add_fresh_force(&mut covariance, phi, (noise, &dynamics.unseen[sample]), h);
            if let Some(forbidden) = dynamics.forbidden.get(sample) {
                add_forbidden(&mut covariance, forbidden, &dynamics.acceleration_scale, h);
            }
        }
        whitener
    }

    /// Wide enough to leave the start to the data: the curve is within a few
    /// tens of sensor noises of the truth.
    fn initial_covariance(&self, noise: &ProcessNoise) -> DMatrix<f64> {
        let n = self.dynamics.coordinate_count();
        let h = self.dynamics.t[1] - self.dynamics.t[0];
        let mut covariance = DMatrix::zeros(3 * n, 3 * n);
        for i in 0..n {
            let position = 30.0 * self.readings.position_sd[i];
            let rate = match &self.readings.velocity[i] {
                Some(_) => 30.0 * self.readings.velocity_sd[i],
                None => 30.0 * self.readings.position_sd[i] / h.max(0.02),
            };
            covariance[(i, i)] = position * position;
            covariance[(n + i, n + i)] = rate * rate;
            covariance[(2 * n + i, 2 * n + i)] = noise.force_sd[i].powi(2);
        }
        covariance
    }

    /// Takes in one reading, whose standard deviation is that of its sensor yet. The last two are there to be
    /// written to.
    fn update(
        &mut self,
        update: Update,
        covariance: &mut DMatrix<f64>,
        (row, column): (&mut DVector<f64>, &mut DVector<f64>),
    ) {
        let own = match self.unit_row(&update) {
            Some(place) => {
                column.copy_from(&covariance.column(place));
                column[place]
            }
            None => {
                self.write_slope(&update, row);
                column.gemv(1.0, covariance, row, 0.0);
                row.dot(column)
            }
        };
        let variance = own.max(0.0) + update.sd * update.sd;
        covariance.ger(-1.0 / variance, column, column, 1.0);
        let sd = variance.sqrt();
        self.log_sd += sd.ln();
        self.gains.extend(column.iter().map(|x| x / variance));
        self.updates.push(Update { sd, ..update });
    }

    /// What a unit of an innovation moves the state by, `3n`.
    pub(super) fn gain(&self, update: usize) -> DVectorView<'_, f64> {
        let size = 3 * self.dynamics.coordinate_count();
        DVectorView::from_slice(&self.gains[update * size..][..size], size)
    }

    /// `Σ ln sd` of all innovations, of readings as they stand on the dials: the part of the
    /// negative log likelihood that does not depend on the fit.
    pub fn log_sd(&self) -> f64 {
        self.log_sd
    }

    /// Negative log likelihood of the readings as they stand, `Σ ln sd + ½ Σ e²` of the innovations
    /// `e`, for each of [`BLOCKS`] runs of the log, nats up to a constant of the log.
    pub fn costs(&self) -> Vec<f64> {
        let rows = self.whiten(&Mix::Columns(&[0]));
        let blocks = self.blocks();
        let slope = self.readings.log_slope / blocks.len() as f64;
        let cost = |(update, e): (&Update, &f64)| update.sd.ln() + 0.5 * e * e;
        let of = |range: std::ops::Range<usize>| {
            let pairs = self.updates[range.clone()]
                .iter()
                .zip(&rows.as_slice()[range]);
            slope + pairs.map(cost).sum::<f64>()
        };
        blocks.into_iter().map(of).collect()
    }

    /// Number of the model's sensors that the log has.
    pub fn instrument_count(&self) -> usize {
        self.readings.instruments.len()
    }

    /// Number of scalar readings. What a constraint demands is none.
    pub fn reading_count(&self) -> usize {
        self.updates.len() - self.dynamics.closed.rows() * self.dynamics.t.len()
    }

    /// Products of the data and some whitened columns (counted from zero), by blocks
    /// of the log.
    pub fn gram(&self, columns: &[usize]) -> Gram {
        let all: Vec<usize> = std::iter::once(0)
            .chain(columns.iter().map(|c| c + 1))
            .collect();
        let rows = self.whiten(&Mix::Columns(&all));
        Gram::new(&rows, &self.blocks(), self.reading_count())
    }

    /// For each group of columns the products of data, `base` and the group.
    pub fn grams(&self, base: &[usize], groups: &[&[usize]]) -> Vec<Gram> {
        let first: Vec<usize> = std::iter::once(0)
            .chain(base.iter().map(|c| c + 1))
            .collect();
        let known = self.whiten(&Mix::Columns(&first));
        let blocks = self.blocks();
        let start = Gram::new(&known, &blocks, self.reading_count());
        groups
            .par_chunks(GROUPS)
            .flat_map_iter(|chunk| {
                let columns: Vec<usize> =
                    chunk.iter().flat_map(|g| g.iter().map(|c| c + 1)).collect();
                let rows = self.whiten(&Mix::Columns(&columns));
                let mut next = 0;
                chunk
                    .iter()
                    .map(|group| {
                        let own = rows.columns(next, group.len()).into_owned();
                        next += group.len();
                        start.extended(&known, &own, &blocks)
                    })
                    .collect::<Vec<Gram>>()
            })
            .collect()
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

    /// Whitened innovations of some columns of `forcing`, the data among them counted
    /// as the first; or of the one column `data − Σ cⱼ columnⱼ`.
    pub(super) fn whiten(&self, mix: &Mix<'_>) -> DMatrix<f64> {
        let count = mix.count();
        let data = mix.position_of_data();
        let mut state = self.begin(0, mix);
        let mut rows = DMatrix::zeros(self.updates.len(), count);
        let mut after = state.clone();
        let mut next = 0;
        let mut innovation = DVector::zeros(count);
        let mut row = DVector::zeros(state.nrows());
        for sample in 0..self.dynamics.t.len() {
            let direct = self.direct(sample, mix);
            while next < self.updates.len() && self.updates[next].sample as usize == sample {
                let update = &self.updates[next];
                let read = (&mut row, &mut innovation);
                self.predict_reading(update, mix, (&state, &direct), read);
                innovation.neg_mut();
                if let (Some(reading), Some(data)) = (self.reading(update), data) {
                    innovation[data] += reading;
                }
                let gain = self.gain(next);
                for column in 0..count {
                    state
                        .column_mut(column)
                        .axpy(innovation[column], &gain, 1.0);
                    rows[(next, column)] = innovation[column] / update.sd;
                }
                next += 1;
            }
            if sample + 1 < self.dynamics.t.len() {
                self.advance(sample, mix, &mut state, &mut after);
            }
        }
        // Columns are what a unit coefficient adds to the prediction, so their
        // innovations carry the opposite sign of the data's.
        for column in 0..count {
            if data != Some(column) {
                rows.column_mut(column).neg_mut();
            }
        }
        rows
    }

    /// The departure at the next sample; `after` is there to be written to.
    pub(super) fn advance(
        &self,
        sample: usize,
        mix: &Mix<'_>,
        state: &mut DMatrix<f64>,
        after: &mut DMatrix<f64>,
    ) {
        if self.gaps[sample] {
            *state = self.begin(sample + 1, mix);
            return;
        }
        after.gemm(1.0, &self.dynamics.transition[sample], state, 0.0);
        let n = self.dynamics.coordinate_count();
        mix.add(&self.dynamics.forcing[sample], after.rows_mut(0, 2 * n));
        std::mem::swap(state, after);
    }

    /// The departure where nothing came before: none, or, where columns change what is read,
    /// such that it is read as it was.
    pub(super) fn begin(&self, sample: usize, mix: &Mix<'_>) -> DMatrix<f64> {
        let n = self.dynamics.coordinate_count();
        let mut state = DMatrix::zeros(3 * n, mix.count());
        if let Some(sensed) = self.dynamics.sensed.of(sample, mix) {
            let mut seen = state.rows_mut(0, 2 * n);
            seen -= sensed.rows(0, 2 * n);
        }
        state
    }
}

/// Columns whitened at once.
const GROUPS: usize = 24;

/// Which columns to whiten.
pub(super) enum Mix<'a> {
    /// Each of these, the data being number zero.
    Columns(&'a [usize]),
    /// One weighted sum of all, the data first.
    Sum(&'a DVector<f64>),
}

impl Mix<'_> {
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Columns(columns) => columns.len(),
            Self::Sum(_) => 1,
        }
    }

    fn position_of_data(&self) -> Option<usize> {
        match self {
            Self::Columns(columns) => columns.iter().position(|&c| c == 0),
            Self::Sum(_) => Some(0),
        }
    }

    pub(super) fn of(&self, all: &DMatrix<f64>) -> DMatrix<f64> {
        let mut mixed = DMatrix::zeros(all.nrows(), self.count());
        self.add(all, mixed.rows_mut(0, all.nrows()));
        mixed
    }

    /// Adds what it makes of columns to others.
    fn add(&self, all: &DMatrix<f64>, mut to: DMatrixViewMut<'_, f64>) {
        match self {
            Self::Columns(columns) => {
                let size = all.nrows();
                for (mut sum, &column) in to.column_iter_mut().zip(*columns) {
                    let own = &all.as_slice()[column * size..][..size];
                    let sums = sum.as_mut_slice().iter_mut().zip(own);
                    sums.for_each(|(sum, own)| *sum += own);
                }
            }
            Self::Sum(weights) => {
                // Of many columns few have a weight: the others are not even read.
                let mut sum = to.column_mut(0);
                for (column, &weight) in all.column_iter().zip(weights.iter()) {
                    if weight != 0.0 {
                        sum.axpy(weight, &column, 1.0);
                    }
                }
            }
        }
    }
}

/// White noise on the accelerations that constraints forbid, for what integration and
/// linearisation leave there: nothing else would ever correct it.
fn add_forbidden(
    covariance: &mut DMatrix<f64>,
    forbidden: &DMatrix<f64>,
    scale: &DVector<f64>,
    h: f64,
) {
    let n = scale.len();
    let intensity = scale.map(|a| 2.0 * CORRELATION * (FORBIDDEN_SHARE * a).powi(2));
    let jolt = forbidden * DMatrix::from_diagonal(&intensity) * forbidden.transpose();
    let mut add = |row: usize, column: usize, factor: f64| {
        let mut view = covariance.view_mut((row, column), (n, n));
        view += &jolt * factor;
    };
    add(0, 0, h * h * h / 3.0);
    add(0, n, h * h / 2.0);
    add(n, 0, h * h / 2.0);
    add(n, n, h);
}

/// Its size, as a share of the machine's accelerations.
const FORBIDDEN_SHARE: f64 = 1e-3;

/// What `h` seconds of white noise on `ḟ` do to `(f, v, q)`, in units of `f`'s fresh
/// variance, `v/(P h)` and `q/(P h²)`: the covariance of a Wiener process and its first
/// two integrals.
pub(super) const INTEGRALS: [[f64; 3]; 3] = [
    [1.0, 1.0 / 2.0, 1.0 / 6.0],
    [1.0 / 2.0, 1.0 / 3.0, 1.0 / 8.0],
    [1.0 / 6.0, 1.0 / 8.0, 1.0 / 20.0],
];

/// What `h` seconds of a white force do to `(v, q)`, in units of its variance over that time,
/// `v/(P h)` and `q/(P h²)`: the covariance of a Wiener process and its integral.
pub(super) const INTEGRALS_OF_JITTER: [[f64; 2]; 2] = [[1.0, 1.0 / 2.0], [1.0 / 2.0, 1.0 / 3.0]];

/// The unexplained forces' fresh part, how it has moved the machine by the end of the interval,
/// and how white forces have.
fn add_fresh_force(
    covariance: &mut DMatrix<f64>,
    phi: &DMatrix<f64>,
    (noise, unseen): (&ProcessNoise, &DVector<f64>),
    h: f64,
) {
    let n = noise.force_sd.len();
    let decay = |i: usize| phi[(2 * n + i, 2 * n + i)];
    // To the first order in h the transition holds P h.
    let pushed = |row: usize, i: usize| phi[(n + row, 2 * n + i)];
    // (f, v, q) begin at rows 2n, n and 0; q takes another h.
    let weight = |a: usize, b: usize, power: i32| INTEGRALS[a][b] * h.powi(power);
    let (of_f, of_vf, of_qf) = (weight(0, 0, 0), weight(1, 0, 0), weight(2, 0, 1));
    for i in 0..n {
        let variance = noise.force_sd[i].powi(2) * fresh_share(decay(i));
        covariance[(2 * n + i, 2 * n + i)] += of_f * variance;
        for row in 0..n {
            let own = pushed(row, i) * variance;
            for (place, own) in [(n + row, of_vf * own), (row, of_qf * own)] {
                covariance[(place, 2 * n + i)] += own;
                covariance[(2 * n + i, place)] += own;
            }
        }
    }
    // What both do to (v, v), (q, v) and (q, q).
    let [of_v, of_qv, of_q] = [(0, 0), (1, 0), (1, 1)].map(|(a, b)| {
        let power = h.powi((a + b) as i32);
        let each = (0..n).map(|i| {
            let (lasting, white) = (noise.force_sd[i].powi(2), noise.jitter[i].powi(2) / h);
            let white = white + (noise.unseen * unseen[i]).powi(2);
            let lasting = lasting * fresh_share(decay(i)) * INTEGRALS[1 + a][1 + b];
            power * (lasting + white * INTEGRALS_OF_JITTER[a][b])
        });
        each.collect::<Vec<f64>>()
    });
    for i in 0..n {
        for row in 0..n {
            let through = |sizes: &[f64]| -> f64 {
                let each = sizes.iter().enumerate();
                each.map(|(k, size)| pushed(row, k) * size * pushed(i, k))
                    .sum()
            };
            let across = through(&of_qv);
            covariance[(n + row, n + i)] += through(&of_v);
            covariance[(n + row, i)] += across;
            covariance[(row, n + i)] += across;
            covariance[(row, i)] += through(&of_q);
        }
    }
}

/// Share of an unexplained force's variance that is new after it has fallen by a factor `decay`.
pub(super) fn fresh_share(decay: f64) -> f64 {
    1.0 - decay * decay
}

/// Intervals across which nothing is predicted.
fn gaps(t: &[f64]) -> Vec<bool> {
    let longest = longest_step(t);
    t.windows(2).map(|w| w[1] - w[0] > longest).collect()
}
