//! Whether a machine answers to what its log says of a moment: a blow of one sample is real where
//! a velocity jumps with it.

use crate::log::{mad_sd, median_step};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// How far before and after a moment a position is looked at: in time \[s\], and at least in
/// samples.
const REACH: (f64, usize) = (0.05, 8);
/// How late a machine may answer \[s\].
const LATEST: f64 = 0.1;
/// A jump of the velocity above this many times its ordinary size is an answer, if it is also this
/// many times as large as those shortly before and after.
const REMARKABLE: (f64, f64) = (6.0, 3.0);
/// Powers of time in the motion that a jump is added to.
const POWERS: usize = 6;
/// Moments from which the ordinary size is known.
const MOMENTS: usize = 400;
/// What rounding makes of a jump, as a share of the largest that the travel would allow.
const ROUNDING: f64 = 1e-9;

/// The positions of a log, without wild samples, and how much their velocities ordinarily jump.
pub(super) struct Answers<'a> {
    t: &'a [f64],
    positions: &'a [Vec<f64>],
    ordinary: Vec<f64>,
    reach: usize,
    latest: usize,
}

impl<'a> Answers<'a> {
    pub fn new(t: &'a [f64], positions: &'a [Vec<f64>]) -> Self {
        let step = median_step(t).max(f64::MIN_POSITIVE);
        let samples = |seconds: f64| (seconds / step).round().min(t.len() as f64) as usize;
        let mut answers = Self {
            t,
            positions,
            ordinary: Vec::new(),
            reach: samples(REACH.0).max(REACH.1),
            latest: samples(LATEST).max(REACH.1),
        };
        let stride = t.len().div_ceil(MOMENTS).max(1);
        let ordinary = positions.iter().map(|q| {
            let jumps = (0..t.len()).step_by(stride);
            let jumps: Vec<f64> = jumps.filter_map(|k| answers.jump(q, k)).collect();
            let most = q
                .iter()
                .fold(0.0, |most: f64, x| most.max((x - q[0]).abs()));
            let rounding = ROUNDING * most / step;
            mad_sd(&jumps).unwrap_or(f64::INFINITY).max(rounding)
        });
        answers.ordinary = ordinary.collect();
        answers
    }

    /// Whether a velocity jumps with, or soon after, some samples.
    pub fn to(&self, run: &Range<usize>) -> bool {
        let (first, last) = (run.start.saturating_sub(1), run.end + self.latest);
        // Of windows that do not hold these moments.
        let before = first.saturating_sub(2 * self.reach)..first.saturating_sub(self.reach);
        let after = last + self.reach..last + 2 * self.reach;
        let mut each = self.positions.iter().zip(&self.ordinary);
        each.any(|(q, ordinary)| {
            let beside = self
                .largest(q, before.clone())
                .max(self.largest(q, after.clone()));
            let least = (REMARKABLE.0 * ordinary).max(REMARKABLE.1 * beside);
            self.largest(q, first..last) > least
        })
    }

    /// The largest jump of a velocity at some samples.
    fn largest(&self, q: &[f64], moments: Range<usize>) -> f64 {
        let stride = (self.reach / REACH.1).max(1);
        let jumps = moments.step_by(stride).filter_map(|k| self.jump(q, k));
        jumps.fold(0.0, |largest, jump| largest.max(jump.abs()))
    }

    /// By how much the velocity jumps at sample `k` of a position that is a polynomial otherwise.
    fn jump(&self, q: &[f64], k: usize) -> Option<f64> {
        let first = k.checked_sub(self.reach)?;
        let last = k + self.reach;
        if last >= self.t.len() {
            return None;
        }
        let span = self.t[last] - self.t[first];
        let count = last - first + 1;
        let basis = DMatrix::from_fn(count, POWERS + 1, |row, column| {
            let s = (self.t[first + row] - self.t[k]) / span;
            match column {
                POWERS => s.max(0.0),
                power => s.powi(power as i32),
            }
        });
        let values = DVector::from_fn(count, |row, _| q[first + row] - q[k]);
        let normal = basis.tr_mul(&basis).cholesky()?;
        let fitted = normal.solve(&basis.tr_mul(&values));
        Some(fitted[POWERS] / span)
    }
}
