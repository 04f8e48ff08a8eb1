//! What a machine does at places along the curve.

use super::closed::Missed;
use super::mover::{Columns, Mover};
use super::shown::{Derivatives, Places, Shown, shown};
use super::trails::Visited;
use crate::machine::{Memory, Motion, SolveError, States};
use nalgebra::{DMatrix, DVector};

/// One place along the curve, of `n` coordinates and `p` columns.
pub(super) struct Local {
    /// `a | G`, `n×(1+p)`
    pub acceleration: DMatrix<f64>,
    /// `[∂a/∂q, ∂a/∂v]`, `n×2n`
    pub slope: DMatrix<f64>,
    /// The motion that the model demands here.
    pub motion: Motion,
    /// What the model's sensors show here, where that is asked for.
    pub shown: Option<Shown>,
}

impl Local {
    /// `P`, `n×n`
    pub(super) fn mobility(&self) -> DMatrix<f64> {
        self.motion.factorisation.mobility()
    }

    /// `[∂a/∂q, ∂a/∂v, P]`, `n×3n`
    pub(super) fn slope_and_mobility(&self) -> DMatrix<f64> {
        let n = self.slope.nrows();
        let mut slope = self.slope.clone().resize_horizontally(3 * n, 0.0);
        slope.columns_mut(2 * n, n).copy_from(&self.mobility());
        slope
    }

    /// `I − P M`, where there are constraints.
    pub(super) fn forbidden(&self, mobility: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let Motion {
            terms, multiplier, ..
        } = &self.motion;
        let n = mobility.nrows();
        let is_constrained = !multiplier.is_empty();
        is_constrained.then(|| DMatrix::identity(n, n) - mobility * &terms.mass_matrix)
    }

    /// Squares of the terms that balance, summed per coordinate.
    pub(super) fn force_size(&self) -> DVector<f64> {
        let Motion {
            terms,
            acceleration,
            ..
        } = &self.motion;
        let inertial = &terms.mass_matrix * acceleration;
        let actuated = &terms.force - &terms.bias_force;
        let square = |x: &DVector<f64>| x.component_mul(x);
        square(&inertial) + square(&terms.bias_force) + square(&actuated)
    }

    /// How far off holonomic constraints are, given which of the constraints these are.
    pub(super) fn missed(&self, holonomic: &[usize]) -> Missed {
        let terms = &self.motion.terms;
        Missed {
            residual: terms.constraint_residual.select_rows(holonomic),
            gradient: terms.constraint_matrix.select_rows(holonomic),
        }
    }
}

/// What is found at the beginnings, middles and ends of some intervals, one behind the other.
pub(super) struct Looked {
    /// Where intervals go on in one another, the last of them ends in one more.
    beginnings: Vec<Local>,
    middles: Vec<Local>,
    /// Empty where the ends are the next beginnings.
    ends: Vec<Local>,
}

impl Looked {
    /// Looks there. Where each interval begins as the one before it ends, one look does for both.
    ///
    /// # Errors
    /// If the equation of motion has no unique solution at one of the places; its sample is the interval.
    pub fn new(
        mover: Mover<'_>,
        columns: &[Columns<'_>],
        [beginnings, middles, ends]: &[Visited; 3],
    ) -> Result<Self, SolveError> {
        let at = |mover, places: &Visited| locals(mover, columns, &places.states, &places.memories);
        let mut looked = Self {
            beginnings: at(mover, beginnings)?,
            middles: at(mover.unseen(), middles)?,
            ends: Vec::new(),
        };
        if ends.goes_on_in(beginnings) {
            let last = looked.middles.len() - 1;
            let end = at(mover.unseen(), &ends.only(last));
            let end = end.map_err(|error| error.offset(last))?;
            looked.beginnings.extend(end);
        } else {
            looked.ends = at(mover.unseen(), ends)?;
        }
        Ok(looked)
    }

    /// The beginnings, one per interval.
    pub fn into_beginnings(mut self) -> Vec<Local> {
        self.beginnings.truncate(self.middles.len());
        self.beginnings
    }

    /// The beginnings, middles and ends, one of each per interval.
    pub fn nodes(&self) -> [&[Local]; 3] {
        let intervals = self.middles.len();
        let ends = match &self.ends[..] {
            [] => &self.beginnings[1..],
            ends => ends,
        };
        [&self.beginnings[..intervals], &self.middles, ends]
    }
}

/// What the machine does in these states; `memories` are those of the blocks of columns.
///
/// # Errors
/// If the equation of motion has no unique solution in one of them, or no finite slope.
pub(super) fn locals(
    mover: Mover<'_>,
    columns: &[Columns<'_>],
    states: &States,
    memories: &[Memory],
) -> Result<Vec<Local>, SolveError> {
    let Mover { parameters, .. } = mover;
    let motions = mover.machine.motion(states, parameters)?;
    let slopes = mover.slopes.evaluate(states, parameters, &motions);
    let unbounded =
        |(slope, _): &(DMatrix<f64>, DMatrix<f64>)| slope.iter().any(|x| !x.is_finite());
    if let Some(sample) = slopes.iter().position(unbounded) {
        return Err(SolveError::NotFinite { sample });
    }
    let pairs = columns.iter().zip(memories);
    let of_block = pairs.map(|(block, memory)| {
        let own = States {
            memory: memory.clone(),
            ..states.clone()
        };
        let derivatives = block.tape.evaluate(&own, block.parameters, &motions);
        (derivatives, memory)
    });
    let blocks: Vec<(Derivatives, &Memory)> = of_block.collect();
    let places = Places {
        states,
        motions: &motions,
        slopes: &slopes,
        blocks: &blocks,
    };
    let seen = mover.instruments;
    let seen = seen.map(|instruments| shown(instruments, parameters, columns, &places));
    let mut seen = seen.unwrap_or_default().into_iter();
    let width = 1 + blocks.iter().map(|b| b.0[0].0.ncols()).sum::<usize>();
    let places = motions.into_iter().zip(slopes).enumerate();
    let local = |(sample, (motion, (slope, _))): (usize, (Motion, (DMatrix<f64>, _)))| {
        let mut acceleration = DMatrix::zeros(slope.nrows(), width);
        acceleration.set_column(0, &motion.acceleration);
        let mut next = 1;
        for (block, _) in &blocks {
            let part = &block[sample].0;
            acceleration.columns_mut(next, part.ncols()).copy_from(part);
            next += part.ncols();
        }
        Local {
            acceleration,
            slope,
            motion,
            shown: seen.next(),
        }
    };
    Ok(places.map(local).collect())
}
