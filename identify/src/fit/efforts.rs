//! Efforts that are no forces of their joints, told before anything is fitted to them.
//!
//! What a driver logs as effort may be a current, a duty cycle, a command, or the force on the far side
//! of a counterbalance. Fitted as a torque it pulls inertias and friction of all joints away. So each
//! joint's effort is first explained alone, on blocks of the log that the explanation was not
//! fitted to: by friction, rotor and offset; by these beside multiples of the model's own forces, the one
//! that holds it still and the one that moves it; and by these beside all inertias and any law over
//! its position. What none of them explains is not this joint's force. How large an effort ought to
//! be only the force that holds still says: it follows from positions, where accelerations carry noise
//! that makes any multiple small.

use super::columns::Columns;
use super::equations::{BLOCKS, Equations, Row};
use crate::number::rounded;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::f64::consts::TAU;

/// Why an effort is not taken for a force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Reason {
    /// Who asked for the fit says so.
    Stated,
    /// It does not follow from the motion.
    Unrelated {
        /// Share of its variance that the motion explains.
        explained: f64,
    },
    /// It is a small part of the force that holds the joint still.
    Scaled {
        /// How many times the model's.
        factor: f64,
    },
}

/// A joint whose force is not known.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LeftOut {
    /// The coordinate.
    pub coordinate: String,
    /// Why.
    pub reason: Reason,
}

impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { coordinate, reason } = self;
        write!(f, "the force of {coordinate} is not known")?;
        match reason {
            Reason::Stated => Ok(()),
            Reason::Unrelated { explained } => write!(
                f,
                ": what is logged for it does not follow from the motion ({} % of it does)",
                rounded(100.0 * explained.max(0.0))
            ),
            Reason::Scaled { factor } => write!(
                f,
                ": of what the model needs to hold it still {} % is logged, as if it were a current, a \
                 share of the most, or what a counterbalance leaves; a unit can be said by a map of the \
                 log (docs/log-format.md)",
                rounded(100.0 * factor),
            ),
        }
    }
}

/// The motion explains at least this share of the variance of a force.
const FOLLOWS: f64 = 0.2;
/// A multiple of the model's force that is smaller than any mistake of a model makes it.
const TOO_SMALL: f64 = 0.25;
/// The motion explains most of an effort.
const MOSTLY: f64 = 0.7;
/// The force that holds still matters where the error without it is this many times that with it; or
/// where its square is this many times that by which it varies, so that it looks like an offset.
const MATTERS: f64 = 3.0;
/// Waves over a joint's range that any law over its position is made of.
const WAVES: u32 = 12;

/// An effort that varies by less than this share of its size and of what the model needs is round-off:
/// nothing drives there, or always the same.
const DRIVEN: f64 = 1e-9;

/// The coordinates whose efforts are no forces of theirs. Nothing is said under constraints, where
/// efforts are not known apart from multipliers, and of coordinates that nothing drives.
pub(super) fn no_forces(columns: &Columns, equations: &Equations) -> Vec<(usize, Reason)> {
    let each =
        (0..equations.coordinates()).filter_map(|i| Some((i, reason(columns, equations, i)?)));
    each.collect()
}

fn reason(columns: &Columns, equations: &Equations, coordinate: usize) -> Option<Reason> {
    let row = equations.row(coordinate)?;
    let friction = columns
        .groups
        .iter()
        .filter(|group| group.load.is_none() && group.places == [coordinate]);
    let friction: Vec<usize> = friction.flat_map(|group| group.columns.clone()).collect();
    let local: Vec<&[f64]> = friction.iter().map(|&c| row.columns[c]).collect();
    let constant = vec![1.0; row.effort.len()];
    let about_mean = held_out(row.effort, &[&constant], &[]);
    let size = mean_square(row.effort) + mean_square(&row.needed);
    if about_mean <= DRIVEN.powi(2) * size {
        return None;
    }
    let explained = |error: f64| 1.0 - error / about_mean;
    let moving: Vec<f64> = row
        .needed
        .iter()
        .zip(row.holding)
        .map(|(all, still)| all - still)
        .collect();
    let without: Vec<&[f64]> = local.iter().copied().chain([&moving[..]]).collect();
    let with: Vec<&[f64]> = without.iter().copied().chain([row.holding]).collect();
    let [own, without, multiple] =
        [&local, &without, &with].map(|columns| held_out(row.effort, columns, &[]));
    if let Some(factor) = factor(&row, &with) {
        let matters = without > MATTERS * multiple && explained(multiple) > MOSTLY;
        if matters && is_too_small(&factor) {
            return Some(Reason::Scaled { factor: factor[0] });
        }
    }
    let [effort, still] = [row.effort, row.holding].map(mean);
    let spread = held_out(row.holding, &[&constant], &[]);
    let is_most = still.powi(2) > 0.5 * mean_square(&row.needed);
    if is_most && still.powi(2) > MATTERS * spread && is_too_small(&[effort / still]) {
        return Some(Reason::Scaled {
            factor: effort / still,
        });
    }
    // Beside the model as given inertias within what is believed of them, and any law over the joint's own
    // position.
    let left: Vec<f64> = row
        .effort
        .iter()
        .zip(&row.needed)
        .map(|(u, m)| u - m)
        .collect();
    let inertial = (0..columns.inertial).map(|c| row.columns[c]);
    let waves = waves(row.position);
    let waves = waves.iter().map(|wave| &wave[..]);
    let all: Vec<&[f64]> = inertial.chain(local.iter().copied()).chain(waves).collect();
    let scale = mean_square(&left);
    let prior: Vec<f64> = columns.prior.iter().map(|sd| scale / (sd * sd)).collect();
    let any = held_out(&left, &all, &prior);
    let best = explained(own.min(multiple).min(any));
    (best < FOLLOWS).then_some(Reason::Unrelated { explained: best })
}

/// Whether all of some estimates of a multiple are far too small. One that is too large may be that of
/// a light hand with a load.
fn is_too_small(factors: &[f64]) -> bool {
    factors.iter().all(|factor| factor.abs() < TOO_SMALL)
}

/// Sines and cosines over the range of a position.
fn waves(position: &[f64]) -> Vec<Vec<f64>> {
    let bounds = (f64::INFINITY, f64::NEG_INFINITY);
    let (least, most) = position
        .iter()
        .fold(bounds, |(least, most), &q| (least.min(q), most.max(q)));
    let way = (most - least).max(f64::MIN_POSITIVE);
    let each = (1..=WAVES).flat_map(|k| {
        let turn = TAU * f64::from(k) / way;
        [f64::sin, f64::cos].map(|wave| position.iter().map(|q| wave(turn * (q - least))).collect())
    });
    each.collect()
}

/// The multiple of the last column in the effort, from all blocks and from all but each.
fn factor(row: &Row<'_>, columns: &[&[f64]]) -> Option<Vec<f64>> {
    let samples = row.effort.len();
    let bound = |block: usize| block * samples / BLOCKS;
    let out = (0..BLOCKS).map(|block| bound(block)..bound(block + 1));
    let each = std::iter::once(0..0).chain(out).map(|out| {
        let x = solve(row.effort, columns, &[], |k| !out.contains(&k))?;
        x.iter().next_back().copied()
    });
    each.collect()
}

/// Mean square of what a regression on some columns leaves of blocks that it was not fitted to;
/// `ridge` has the weight that draws each of the first coefficients to zero.
fn held_out(target: &[f64], columns: &[&[f64]], ridge: &[f64]) -> f64 {
    let samples = target.len();
    let bound = |block: usize| block * samples / BLOCKS;
    let errors = (0..BLOCKS).map(|block| {
        let out = bound(block)..bound(block + 1);
        let Some(x) = solve(target, columns, ridge, |k| !out.contains(&k)) else {
            return f64::INFINITY;
        };
        let left = |k: usize| {
            let said: f64 = columns.iter().zip(x.iter()).map(|(c, x)| x * c[k]).sum();
            (target[k] - said).powi(2)
        };
        out.map(left).sum()
    });
    errors.sum::<f64>() / samples.max(1) as f64
}

/// Least squares over some samples. `None` where the columns do not determine it.
fn solve(
    target: &[f64],
    columns: &[&[f64]],
    ridge: &[f64],
    takes: impl Fn(usize) -> bool,
) -> Option<DVector<f64>> {
    let samples: Vec<usize> = (0..target.len()).filter(|&k| takes(k)).collect();
    let x = DMatrix::from_fn(samples.len(), columns.len(), |row, c| {
        columns[c][samples[row]]
    });
    let y = DVector::from_fn(samples.len(), |row, _| target[samples[row]]);
    let mut gram = x.tr_mul(&x);
    for c in 0..columns.len() {
        // Columns that say nothing get nothing.
        let more = ridge.get(c).copied().unwrap_or_default();
        gram[(c, c)] += more + (1e-10 * gram[(c, c)]).max(f64::MIN_POSITIVE.sqrt());
    }
    Some(gram.cholesky()?.solve(&x.tr_mul(&y)))
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
