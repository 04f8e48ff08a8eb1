//! The equations along a log: whitened, projected, block by block as Gram matrices.

use super::FitError;
use super::columns::Columns;
use super::frame::Frame;
use super::groups::Group;
use super::narrowing::uncertainty;
use crate::log::{Record, rms};
use crate::machine::{Machine, States};
use crate::regression::{Band, narrowing, said_of_band};
use crate::smooth::smooth;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Blocks of a log that stand and fall together.
pub(super) const BLOCKS: usize = 12;
/// More equations than this say no more.
const MOST_SAMPLES: usize = 20_000;
/// Share of what the inputs exert that no force is known better than to: along a direction in which nothing
/// happens errors of rounding would count as forces, and hide the friction of `identify/tests/floating.rs`.
const EXACTLY: f64 = 1e-5;

/// `r = X x` along a log.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// Per coordinate, a value per sample: what the model leaves unexplained.
    residual: Vec<Vec<f64>>,
    /// Per coordinate, a value per sample: what the inputs exert.
    exerted: Vec<Vec<f64>>,
    /// The same: what the model as given needs to hold still there.
    holding: Vec<Vec<f64>>,
    /// When the samples were taken, s, and how fast each coordinate moved then.
    pub t: Vec<f64>,
    pub velocity: Vec<Vec<f64>>,
    /// Where each coordinate was.
    position: Vec<Vec<f64>>,
    /// Per column, per coordinate, a value per sample.
    columns: Vec<Vec<Vec<f64>>>,
    /// Per sample, directions that no multiplier reaches (`n×(n−m)`, orthonormal);
    /// empty without constraints.
    free: Vec<DMatrix<f64>>,
    /// Per block of consecutive samples: `XᵀX`, `Xᵀr`, `rᵀr`, whitened by `scale`.
    pub blocks: Vec<Block>,
    /// Standard deviation of what the columns cannot explain, per coordinate; under
    /// constraints per free direction.
    pub scale: Vec<f64>,
    /// Effective over actual number of equations: errors follow one another.
    pub news: f64,
    /// How fast each coordinate moves at most in the log that was learnt from.
    pub fastest: Vec<f64>,
    /// How many times narrower the band is in which forces are compared than that in which the log shows
    /// accelerations.
    pub narrowing: usize,
    /// Over how many samples of the log a force is averaged,
    pub window: usize,
    /// of which every so many keeps one,
    stride: usize,
    /// and how long that is, s.
    duration: f64,
    /// Coordinates whose equations are left out.
    pub left_out: Vec<usize>,
}

/// The equation of one coordinate: effort = needed + columns x.
#[derive(Debug, Clone)]
pub(super) struct Row<'a> {
    /// What the inputs exert.
    pub effort: &'a [f64],
    /// What the model as given needs for the motion.
    pub needed: Vec<f64>,
    /// What it needs of that to hold still.
    pub holding: &'a [f64],
    /// Where the coordinate was.
    pub position: &'a [f64],
    /// Its columns.
    pub columns: Vec<&'a [f64]>,
}

/// A block's share of the normal equations.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub gram: DMatrix<f64>,
    pub moment: DVector<f64>,
    pub square: f64,
}

impl Block {
    /// `|r − X x|²`, with a coefficient per column.
    pub fn squared_error(&self, x: &[f64]) -> f64 {
        let mut error = self.square;
        let active: Vec<usize> = (0..x.len()).filter(|&c| x[c] != 0.0).collect();
        for &a in &active {
            error -= 2.0 * x[a] * self.moment[a];
            for &b in &active {
                error += x[a] * x[b] * self.gram[(a, b)];
            }
        }
        error.max(0.0)
    }
}

impl Equations {
    /// Of a log to judge by, where there are those of the log that was `learnt` from: how fast that
    /// moved, and in which band its forces were compared, holds here, too.
    pub fn new(
        machine: &Machine,
        columns: &Columns,
        parameters: &[f64],
        record: &Record,
        learnt: Option<&Self>,
    ) -> Result<Self, FitError> {
        let smoothed = smooth(record)?;
        let states = States::along(record, &smoothed);
        let a: Vec<Vec<f64>> = smoothed.iter().map(|s| s.a.clone()).collect();
        let terms = machine.terms(&states, parameters);
        let n = machine.coordinate_count();
        let mut residual = vec![Vec::with_capacity(terms.len()); n];
        let mut exerted = residual.clone();
        let mut free = Vec::new();
        for (sample, terms) in terms.iter().enumerate() {
            let acceleration = DVector::from_fn(n, |i, _| a[i][sample]);
            let left = &terms.force - &terms.mass_matrix * acceleration;
            for i in 0..n {
                residual[i].push(left[i]);
                exerted[i].push(terms.force[i] - terms.bias_force[i] - terms.applied_force[i]);
            }
            if machine.constraint_count() > 0 {
                free.push(terms.constraint_matrix.clone());
            }
        }
        let still = States {
            v: vec![vec![0.0; states.len()]; n],
            u: vec![vec![0.0; states.len()]; states.u.len()],
            ..states.clone()
        };
        let held = machine.terms(&still, parameters);
        let holding = (0..n).map(|i| held.iter().map(|terms| -terms.force[i]).collect());
        let holding: Vec<Vec<f64>> = holding.collect();
        let fastest = learnt.map_or_else(|| fastest_of(&states.v), |learnt| learnt.fastest.clone());
        let columns_at = |a: &[Vec<f64>]| columns.along(machine, &states, parameters, a, &fastest);
        let along = Along {
            residual,
            exerted,
            holding,
            free,
            fastest: &fastest,
            step: record.step(),
            states: &states,
        };
        let in_band = |times, columns: &[Vec<Vec<f64>>]| {
            let band = Band::of(record, &smoothed, MOST_SAMPLES, times);
            along.in_band((&band, times), columns)
        };
        let narrowing = match learnt {
            Some(learnt) => learnt.narrowing,
            // Under constraints no coordinate's force is known by itself.
            None if machine.constraint_count() > 0 => 1,
            None => {
                let unaccelerated = columns_at(&vec![vec![0.0; states.len()]; n]);
                narrowing(|times| uncertainty(columns, in_band(times, &unaccelerated)))
            }
        };
        Ok(in_band(narrowing, &columns_at(&a)))
    }

    /// What must be known of the band in which forces are compared, where that is narrower than the one in
    /// which the log shows accelerations.
    pub fn said_of_band(&self) -> Option<String> {
        (self.narrowing > 1).then(|| said_of_band(self.duration))
    }

    /// How many coordinates there are.
    pub fn coordinates(&self) -> usize {
        self.residual.len()
    }

    /// The equation of one coordinate by itself; `None` under constraints, where it is not known apart
    /// from what multipliers exert.
    pub fn row(&self, coordinate: usize) -> Option<Row<'_>> {
        let effort = &self.exerted[coordinate];
        let pairs = effort.iter().zip(&self.residual[coordinate]);
        self.free.is_empty().then(|| Row {
            needed: pairs.map(|(effort, left)| effort - left).collect(),
            effort,
            holding: &self.holding[coordinate],
            position: &self.position[coordinate],
            columns: self.columns.iter().map(|c| &c[coordinate][..]).collect(),
        })
    }

    /// Takes the equations of some coordinates out: nothing is measured there, and nothing missing. What
    /// couples them to others goes, too.
    pub fn leave_out(&mut self, coordinates: &[usize], groups: &[Group]) {
        if coordinates.is_empty() {
            return;
        }
        for &i in coordinates {
            self.residual[i].fill(0.0);
            self.columns
                .iter_mut()
                .for_each(|column| column[i].fill(0.0));
        }
        let is_out = |group: &&Group| group.places.iter().any(|i| coordinates.contains(i));
        for group in groups.iter().filter(is_out) {
            for column in group.columns.clone() {
                self.columns[column].iter_mut().for_each(|c| c.fill(0.0));
            }
        }
        self.left_out = coordinates.to_vec();
        self.scale = self.scale_of(&self.residual);
        self.gather();
    }

    /// How many samples of the log there are, about.
    pub fn log_samples(&self) -> usize {
        self.samples() * self.stride
    }

    /// How many columns are not nothing all along.
    pub fn moving_columns(&self) -> usize {
        let is_moving = |column: &&Vec<Vec<f64>>| column.iter().flatten().any(|x| *x != 0.0);
        self.columns.iter().filter(is_moving).count()
    }

    fn samples(&self) -> usize {
        self.residual.first().map_or(0, Vec::len)
    }

    /// The normal equations of all blocks at the present scale.
    fn gather(&mut self) {
        let samples = self.samples();
        let bounds: Vec<usize> = (0..=BLOCKS).map(|b| b * samples / BLOCKS).collect();
        self.blocks = bounds
            .windows(2)
            .map(|pair| self.block(pair[0], pair[1]))
            .collect();
    }

    /// Squares of what `x` leaves of a block, by coordinate, in units of the scale; under
    /// constraints by direction that no multiplier reaches.
    pub fn squared_errors(&self, block: usize, x: &[f64]) -> Vec<f64> {
        let bound = |block: usize| block * self.samples() / BLOCKS;
        let range = bound(block)..bound(block + 1);
        let mut left: Vec<Vec<f64>> = self
            .residual
            .iter()
            .map(|r| r[range.clone()].to_vec())
            .collect();
        for (column, &value) in self.columns.iter().zip(x).filter(|(_, x)| **x != 0.0) {
            for (left, column) in left.iter_mut().zip(column) {
                let pairs = left.iter_mut().zip(&column[range.clone()]);
                pairs.for_each(|(left, c)| *left -= value * c);
            }
        }
        let mut squares = vec![0.0; self.scale.len()];
        for k in 0..range.len() {
            for (direction, square) in squares.iter_mut().enumerate() {
                let value = match self.free.get(range.start + k) {
                    None => left[direction][k],
                    Some(z) => (0..left.len())
                        .map(|i| z[(i, direction)] * left[i][k])
                        .sum(),
                };
                *square += (value / self.scale[direction]).powi(2);
            }
        }
        squares
    }

    fn block(&self, from: usize, to: usize) -> Block {
        let (n, p) = (self.residual.len(), self.columns.len());
        let width = self.free.first().map_or(n, DMatrix::ncols);
        let rows = (to - from) * width;
        let mut x = DMatrix::zeros(rows, p);
        let mut r = DVector::zeros(rows);
        for sample in from..to {
            let first = (sample - from) * width;
            let put = |values: &dyn Fn(usize) -> f64, target: &mut dyn FnMut(usize, f64)| match self
                .free
                .get(sample)
            {
                None => (0..n).for_each(|i| target(i, values(i) / self.scale[i])),
                Some(z) => (0..width).for_each(|k| {
                    let sum: f64 = (0..n).map(|i| z[(i, k)] * values(i)).sum();
                    target(k, sum / self.scale[k]);
                }),
            };
            put(&|i| self.residual[i][sample], &mut |k, value| {
                r[first + k] = value
            });
            for (column, values) in self.columns.iter().enumerate() {
                put(&|i| values[i][sample], &mut |k, value| {
                    x[(first + k, column)] = value
                });
            }
        }
        Block {
            gram: x.tr_mul(&x),
            moment: x.tr_mul(&r),
            square: r.norm_squared(),
        }
    }

    /// What is left per coordinate with the corrections `x`; under constraints what is
    /// left in the directions that no multiplier reaches.
    pub fn left(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut left = self.residual.clone();
        for (column, &value) in self.columns.iter().zip(x).filter(|(_, x)| **x != 0.0) {
            for (left, column) in left.iter_mut().zip(column) {
                for (left, c) in left.iter_mut().zip(column) {
                    *left -= value * c;
                }
            }
        }
        self.seen(left)
    }

    /// What the inputs exert, per coordinate and sample; under constraints what no multiplier
    /// takes up.
    pub fn exerted(&self) -> Vec<Vec<f64>> {
        self.seen(self.exerted.clone())
    }

    /// The part of forces in the directions that no multiplier reaches.
    fn seen(&self, mut forces: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for (sample, z) in self.free.iter().enumerate() {
            let all = DVector::from_fn(forces.len(), |i, _| forces[i][sample]);
            let seen = z * z.tr_mul(&all);
            for i in 0..forces.len() {
                forces[i][sample] = seen[i];
            }
        }
        forces
    }

    /// Root mean squares of forces in the directions that are fitted, where they are as much as can be measured.
    fn scale_of(&self, forces: &[Vec<f64>]) -> Vec<f64> {
        let exerted = self.exerted.iter().map(|force| rms(force));
        let least = (EXACTLY * exerted.fold(0.0, f64::max)).max(f64::MIN_POSITIVE);
        let Some(first) = self.free.first() else {
            return forces.iter().map(|f| rms(f).max(least)).collect();
        };
        let along = |k: usize| -> Vec<f64> {
            let each = self.free.iter().enumerate();
            each.map(|(sample, z)| {
                (0..forces.len())
                    .map(|i| z[(i, k)] * forces[i][sample])
                    .sum()
            })
            .collect()
        };
        let directions = 0..first.ncols();
        directions.map(|k| rms(&along(k)).max(least)).collect()
    }

    /// Root mean square of what is left, per coordinate.
    pub fn rms(&self, x: &[f64]) -> Vec<f64> {
        self.left(x).iter().map(|left| rms(left)).collect()
    }

    /// Takes the scale and the memory of the errors from what `x` leaves.
    pub fn reweigh(&mut self, x: &[f64]) {
        let left = self.left(x);
        self.scale = self.scale_of(&left);
        let correlation = |left: &Vec<f64>| {
            let (mut follow, mut square) = (0.0, 0.0);
            for pair in left.windows(2) {
                follow += pair[0] * pair[1];
                square += pair[0] * pair[0];
            }
            if square > 0.0 {
                (follow / square).clamp(0.0, 0.999)
            } else {
                0.0
            }
        };
        // Of a coordinate that is left out nothing is left.
        let known = left.iter().filter(|left| rms(left) > 0.0);
        let known: Vec<f64> = known.map(correlation).collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        // An autoregressive error of first order.
        self.news = (1.0 - mean) / (1.0 + mean);
        self.gather();
    }
}

/// What is compared along a log, in no band yet.
struct Along<'a> {
    residual: Vec<Vec<f64>>,
    exerted: Vec<Vec<f64>>,
    holding: Vec<Vec<f64>>,
    free: Vec<DMatrix<f64>>,
    fastest: &'a [f64],
    step: f64,
    states: &'a States,
}

impl Along<'_> {
    /// The equations in a band that is so many times narrower than that in which the log shows accelerations,
    /// with these columns.
    fn in_band(&self, (band, narrowing): (&Band, usize), columns: &[Vec<Vec<f64>>]) -> Equations {
        let limited = |forces: &[Vec<f64>]| -> Vec<Vec<f64>> {
            forces.iter().map(|force| band.limit(force)).collect()
        };
        let kept = |values: &[f64]| -> Vec<f64> {
            values.iter().step_by(band.stride()).copied().collect()
        };
        let n = self.residual.len();
        let frame = Frame::new(n, self.free.iter());
        let free = self.free.iter().step_by(band.stride());
        let mut equations = Equations {
            scale: Vec::new(),
            residual: limited(&self.residual),
            exerted: limited(&self.exerted),
            holding: limited(&self.holding),
            t: kept(&self.states.t),
            velocity: self.states.v.iter().map(|v| kept(v)).collect(),
            position: self.states.q.iter().map(|q| kept(q)).collect(),
            columns: (columns.par_iter()).map(|column| limited(column)).collect(),
            free: free.map(|a| frame.at(a)).collect(),
            blocks: Vec::new(),
            news: 1.0,
            fastest: self.fastest.to_vec(),
            narrowing,
            window: band.window(),
            stride: band.stride(),
            duration: band.window() as f64 * self.step,
            left_out: Vec::new(),
        };
        equations.scale = equations.scale_of(&equations.residual);
        equations.gather();
        equations
    }
}

fn fastest_of(v: &[Vec<f64>]) -> Vec<f64> {
    v.iter()
        .map(|v| v.iter().fold(0.0_f64, |m, x| m.max(x.abs())))
        .collect()
}
