//! The equations along a log: whitened, projected, block by block as Gram matrices.

use super::FitError;
use super::columns::Columns;
use super::frame::Frame;
use crate::log::{Record, rms};
use crate::machine::{Machine, States};
use crate::regression::Band;
use crate::smooth::smooth;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Blocks of a log that stand and fall together.
pub(super) const BLOCKS: usize = 12;
/// More equations than this say no more.
const MOST_SAMPLES: usize = 20_000;

/// `r = X x` along a log.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// Per coordinate, a value per sample: what the model leaves unexplained.
    residual: Vec<Vec<f64>>,
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
}

/// A block's share of the normal equations.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub gram: DMatrix<f64>,
    pub moment: DVector<f64>,
    pub square: f64,
}

impl Equations {
    /// `fastest` is how fast each coordinate moved in the log that was learnt from; this
    /// one, if there is none.
    pub fn new(
        machine: &Machine,
        columns: &Columns,
        parameters: &[f64],
        record: &Record,
        fastest: Option<&[f64]>,
    ) -> Result<Self, FitError> {
        let smoothed = smooth(record)?;
        let states = States::along(record, &smoothed);
        let a: Vec<Vec<f64>> = smoothed.iter().map(|s| s.a.clone()).collect();
        let terms = machine.terms(&states, parameters);
        let n = machine.coordinate_count();
        let mut residual = vec![Vec::with_capacity(terms.len()); n];
        let mut free = Vec::new();
        for (sample, terms) in terms.iter().enumerate() {
            let acceleration = DVector::from_fn(n, |i, _| a[i][sample]);
            let left = &terms.force - &terms.mass_matrix * acceleration;
            for i in 0..n {
                residual[i].push(left[i]);
            }
            if machine.constraint_count() > 0 {
                free.push(terms.constraint_matrix.clone());
            }
        }
        let fastest = fastest.map_or_else(|| fastest_of(&states.v), <[f64]>::to_vec);
        let columns = columns.along(machine, &states, parameters, &a, &fastest);
        let band = Band::of(record, &smoothed, MOST_SAMPLES);
        let residual: Vec<Vec<f64>> = residual.iter().map(|r| band.limit(r)).collect();
        let columns: Vec<Vec<Vec<f64>>> = (columns.par_iter())
            .map(|column| column.iter().map(|c| band.limit(c)).collect())
            .collect();
        let frame = Frame::new(n, free.iter());
        let free = (free.iter().step_by(band.stride()))
            .map(|a| frame.at(a))
            .collect();
        let mut equations = Self {
            scale: Vec::new(),
            residual,
            columns,
            free,
            blocks: Vec::new(),
            news: 1.0,
            fastest,
        };
        equations.scale = equations.scale_of(&equations.residual);
        equations.gather();
        Ok(equations)
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
    fn left(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut left = self.residual.clone();
        for (column, &value) in self.columns.iter().zip(x).filter(|(_, x)| **x != 0.0) {
            for (left, column) in left.iter_mut().zip(column) {
                for (left, c) in left.iter_mut().zip(column) {
                    *left -= value * c;
                }
            }
        }
        for (sample, z) in self.free.iter().enumerate() {
            let all = DVector::from_fn(left.len(), |i, _| left[i][sample]);
            let seen = z * z.tr_mul(&all);
            for i in 0..left.len() {
                left[i][sample] = seen[i];
            }
        }
        left
    }

    /// Root mean squares of forces in the directions that are fitted.
    fn scale_of(&self, forces: &[Vec<f64>]) -> Vec<f64> {
        let Some(first) = self.free.first() else {
            return forces.iter().map(|f| positive(rms(f))).collect();
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
        (0..first.ncols())
            .map(|k| positive(rms(&along(k))))
            .collect()
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
        let mean = left.iter().map(correlation).sum::<f64>() / left.len().max(1) as f64;
        // An autoregressive error of first order.
        self.news = (1.0 - mean) / (1.0 + mean);
        self.gather();
    }
}

fn fastest_of(v: &[Vec<f64>]) -> Vec<f64> {
    v.iter()
        .map(|v| v.iter().fold(0.0_f64, |m, x| m.max(x.abs())))
        .collect()
}

fn positive(x: f64) -> f64 {
    x.max(f64::MIN_POSITIVE)
}
