//! All that is read at one sample, as functions of position, velocity and acceleration.

use super::super::estimate::Observed;
use crate::log::is_aside;
use crate::machine::{Instruments, Machine, States};
use dynamics_codegen::model::ConstraintKind;
use nalgebra::{DMatrix, DVector, RowDVector};

/// How far a constraint is trusted, in what a coordinate's unit changes in it: its positions,
/// velocities and accelerations.
const CLOSED: [f64; 3] = [1e-4, 1e-3, 1e-2];

/// Readings at a state `x = (q, v, a)`, `3n`, to first order.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// `y − h(x)`.
    pub miss: Vec<f64>,
    /// `∂h/∂x`, a row each.
    pub slope: Vec<RowDVector<f64>>,
    /// Standard deviations.
    pub sd: Vec<f64>,
}

/// What reads a log's samples: measured coordinates, the model's sensors, its constraints.
pub(super) struct Dials<'a> {
    pub machine: &'a Machine,
    /// With derivatives by positions and velocities.
    pub instruments: &'a Instruments,
    pub values: &'a [f64],
    /// Per sensor by how much later than its reading what it shows is, s.
    pub leads: Vec<f64>,
    pub observed: &'a Observed,
}

impl Dials<'_> {
    /// All that is read at a sample, at the state `x`.
    pub fn at(&self, sample: usize, x: &DVector<f64>) -> Rows {
        let mut rows = Rows {
            miss: Vec::new(),
            slope: Vec::new(),
            sd: Vec::new(),
        };
        self.positions(sample, x, &mut rows);
        let states = self.states(sample, x);
        self.sensors(sample, x, &states, &mut rows);
        if self.machine.constraint_count() > 0 {
            self.constraints(x, &states, &mut rows);
        }
        rows
    }

    fn states(&self, sample: usize, x: &DVector<f64>) -> States {
        let n = self.machine.coordinate_count();
        let column = |row: usize| vec![x[row]];
        let states = States {
            t: vec![self.observed.record.t[sample]],
            q: (0..n).map(column).collect(),
            v: (n..2 * n).map(column).collect(),
            u: self
                .observed
                .record
                .u
                .iter()
                .map(|u| vec![u[sample]])
                .collect(),
            ..States::default()
        };
        self.machine.at_rest(&states, self.values)
    }

    fn positions(&self, sample: usize, x: &DVector<f64>, rows: &mut Rows) {
        let Observed { record, .. } = self.observed;
        let n = record.q.len();
        for i in (0..n).filter(|&i| record.is_measured(i)) {
            let [q, v, a] = record.aside.of(i).map(|flags| !is_aside(flags, sample));
            let mut add = |row: usize, is_read: bool, values: Option<&Vec<f64>>, sd: f64| {
                if let Some(values) = values.filter(|_| is_read) {
                    rows.push(values[sample] - x[row], unit(3 * n, row), sd);
                }
            };
            add(i, q, Some(&record.q[i]), self.observed.position_sd[i]);
            add(
                n + i,
                v,
                record.dq[i].as_ref(),
                self.observed.velocity_sd[i],
            );
            add(
                2 * n + i,
                a,
                record.ddq[i].as_ref(),
                self.observed.acceleration_sd[i],
            );
        }
    }

    /// Of the model's sensors those that show no force of a constraint: that needs the model.
    fn sensors(&self, sample: usize, x: &DVector<f64>, states: &States, rows: &mut Rows) {
        let (n, m) = (
            self.machine.coordinate_count(),
            self.machine.constraint_count(),
        );
        let accelerations = (2 * n..3 * n).map(|row| vec![x[row]]);
        let solved: Vec<Vec<f64>> = accelerations.chain(vec![vec![0.0]; m]).collect();
        let mut accelerated = DMatrix::zeros(n, 3 * n);
        accelerated.columns_mut(2 * n, n).fill_with_identity();
        let own = [(accelerated, DMatrix::zeros(m, 3 * n))];
        let shown = self.instruments.read_at(states, &solved, self.values);
        let slopes = self
            .instruments
            .slopes_at(states, &solved, &own, self.values);
        let readings = self
            .observed
            .record
            .sensed
            .iter()
            .flat_map(|sensed| &sensed.readings);
        for reading in readings.filter(|reading| reading.is_new(sample)) {
            let sensor = reading.sensor;
            if !self.instruments.weighing()[sensor] {
                let slope = slopes[0].row(sensor).into_owned();
                // What is read some time before or behind the sample, to first order.
                let moved = slope.columns(0, 2 * n) * x.rows(n, 2 * n);
                let shown = shown[sensor][0] + self.leads[sensor] * moved[(0, 0)];
                rows.push(reading.near(shown, sample) - shown, slope, reading.sd);
            }
        }
    }

    fn constraints(&self, x: &DVector<f64>, states: &States, rows: &mut Rows) {
        let n = self.machine.coordinate_count();
        let terms = self.machine.terms(states, self.values).remove(0);
        let acceleration = x.rows(2 * n, n);
        let demanded = &terms.constraint_bias - &terms.constraint_matrix * acceleration;
        for (row, kind) in self.machine.constraint_kinds().iter().enumerate() {
            let gradient = terms.constraint_matrix.row(row);
            let scale = gradient.amax().max(f64::MIN_POSITIVE.sqrt());
            let mut add = |level: usize, miss: f64| {
                let mut slope = RowDVector::zeros(3 * n);
                slope.columns_mut(level * n, n).copy_from(&gradient);
                rows.push(miss, slope, scale * CLOSED[level]);
            };
            if *kind == ConstraintKind::Holonomic {
                add(0, -terms.constraint_residual[row]);
            }
            add(1, -terms.constraint_rate[row]);
            add(2, demanded[row]);
        }
    }
}

impl Rows {
    fn push(&mut self, miss: f64, slope: RowDVector<f64>, sd: f64) {
        // A sensor that shows nothing that is a number here says nothing here.
        if miss.is_finite() && slope.iter().all(|x| x.is_finite()) && sd.is_finite() {
            self.miss.push(miss);
            self.slope.push(slope);
            self.sd.push(sd);
        }
    }

    /// `½ Σ (miss/sd)²`
    pub fn misfit(&self) -> f64 {
        let pairs = self.miss.iter().zip(&self.sd);
        pairs.map(|(miss, sd)| 0.5 * (miss / sd).powi(2)).sum()
    }
}

fn unit(size: usize, place: usize) -> RowDVector<f64> {
    let mut row = RowDVector::zeros(size);
    row[place] = 1.0;
    row
}
