//! Coordinates whose beginning is a matter of choice.
//!
//! A wheeled robot's place and heading on the floor change nothing that it feels: wherever it is
//! thought to begin, the same sensors show the same. Such a coordinate need not be determined; it begins
//! at zero, which says what the other places are counted from. Precisely: a change of its position
//! reaches no sensor, however long one waits, and never comes back to itself. It may change where
//! others of the kind go, as heading changes the way over the floor.

use crate::log::Record;
use crate::machine::{Machine, States};
use dynamics_codegen::derive::Variable;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// States at which is asked what depends on what. What is no identity fails at almost any one.
const TRIED: usize = 5;
/// What changes by less than this share of the largest change does not change.
const DEPENDS: f64 = 1e-9;

/// Whether each unmeasured coordinate may begin anywhere; none if the model cannot be asked.
pub(super) fn cyclic(machine: &mut Machine, values: &[f64], record: &Record) -> Vec<bool> {
    let n = machine.coordinate_count();
    let Some(dependence) = Dependence::of(machine, values, record) else {
        return vec![false; n];
    };
    let is_free = |i: usize| !record.is_measured(i) && dependence.leads_nowhere(i);
    (0..n).map(is_free).collect()
}

/// What follows from which position or velocity, over all the states that were tried.
struct Dependence {
    /// `|∂a/∂(q, v)|`, `n×2n`.
    acceleration: DMatrix<bool>,
    /// Whether what is measured changes at once with `(q, v)`, `2n`.
    seen: Vec<bool>,
}

impl Dependence {
    fn of(machine: &mut Machine, values: &[f64], record: &Record) -> Option<Self> {
        let n = machine.coordinate_count();
        let positions = (0..n).map(Variable::Position);
        let by: Vec<Variable> = positions.chain((0..n).map(Variable::Velocity)).collect();
        let (tape, instruments) = (machine.sensitivity(&by), machine.instruments(&by));
        let states = machine.at_rest(&drawn(n, record.u.len()), values);
        let motions = machine.motion(&states, values).ok()?;
        let slopes = tape.evaluate(&states, values, &motions);
        let shown = instruments.slopes(&states, &motions, &slopes, values);
        let sensed = record.sensed.iter().flat_map(|sensed| &sensed.readings);
        let rows: Vec<usize> = sensed.map(|reading| reading.sensor).collect();
        let shown: Vec<DMatrix<f64>> = shown.iter().map(|all| all.select_rows(&rows)).collect();
        let accelerations: Vec<DMatrix<f64>> = slopes.into_iter().map(|(slope, _)| slope).collect();
        let shown = changes(&shown)?;
        Some(Self {
            acceleration: changes(&accelerations)?,
            seen: (0..2 * n)
                .map(|column| {
                    record.is_measured(column % n) || shown.column(column).iter().any(|&s| s)
                })
                .collect(),
        })
    }

    /// Whether a position's change reaches neither a sensor nor the coordinate itself.
    fn leads_nowhere(&self, position: usize) -> bool {
        let n = self.acceleration.nrows();
        let mut reached = vec![false; n];
        let mut next: Vec<usize> = self.moved_by(position).collect();
        while let Some(i) = next.pop() {
            if !std::mem::replace(&mut reached[i], true) {
                next.extend(self.moved_by(i).chain(self.moved_by(n + i)));
            }
        }
        let shows = |i: usize| reached[i] && (self.seen[i] || self.seen[n + i]);
        !self.seen[position] && !reached[position] && !(0..n).any(shows)
    }

    /// The coordinates whose acceleration changes with an entry of `(q, v)`.
    fn moved_by(&self, entry: usize) -> impl Iterator<Item = usize> {
        let column = self.acceleration.column(entry);
        (0..column.len()).filter(move |&i| column[i])
    }
}

/// Which entries are not zero in all matrices, to rounding; `None` if one is no number.
fn changes(all: &[DMatrix<f64>]) -> Option<DMatrix<bool>> {
    let first = all.first()?;
    let mut largest = DMatrix::<f64>::zeros(first.nrows(), first.ncols());
    for matrix in all {
        largest.zip_apply(matrix, |a, b| {
            *a = if b.is_nan() { b } else { a.max(b.abs()) }
        });
    }
    let is_finite = largest.iter().all(|x| x.is_finite());
    // Without a sensor nothing is shown.
    let scale = largest.iter().copied().fold(1.0, f64::max);
    is_finite.then(|| largest.map(|x| x > DEPENDS * scale))
}

/// Some states, none of them special.
fn drawn(coordinates: usize, inputs: usize) -> States {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut columns = |count: usize| -> Vec<Vec<f64>> {
        let column = |_| (0..TRIED).map(|_| random.random_range(-1.0..1.0)).collect();
        (0..count).map(column).collect()
    };
    States {
        q: columns(coordinates),
        v: columns(coordinates),
        u: columns(inputs),
        t: vec![0.0; TRIED],
        ..States::default()
    }
}
