//! What machines remember along a curve.

use super::error_dynamics::{Columns, Mover};
use crate::machine::{Hold, Machine, Memory, SolveError, States, Trail};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;

/// What the machine remembers along the curve, and what the machine of each block of
/// columns does. Empty where nothing is remembered.
pub(super) struct Trails {
    own: Trail,
    /// Of the other machine, for blocks that do not care for its states.
    other: Trail,
    blocks: Vec<BlockTrail>,
    /// Whether an input is late and held.
    jumps: bool,
}

enum BlockTrail {
    /// As the curve's.
    Own,
    /// As the other machine's.
    Other,
    /// With slopes.
    Particular(Box<Trail>),
}

impl Trails {
    pub fn new(
        mover: Mover<'_>,
        columns: &[Columns<'_>],
        curve: &States,
        hold: Hold,
    ) -> Result<Self, SolveError> {
        let machine = mover.machine;
        let own = machine.trail(curve, hold, mover.parameters, None)?;
        let is_other = |block: &Columns<'_>| !std::ptr::eq(block.machine, machine);
        let other = columns.iter().find(|block| is_other(block));
        let other = other.map(|block| block.machine.trail(curve, hold, block.parameters, None));
        let blocks = columns
            .par_iter()
            .map(|block| {
                if block.tape.reads_states() {
                    let (parameters, tape) = (block.parameters, Some(block.tape));
                    let trail = block.machine.trail(curve, hold, parameters, tape)?;
                    return Ok(BlockTrail::Particular(Box::new(trail)));
                }
                Ok(if is_other(block) {
                    BlockTrail::Other
                } else {
                    BlockTrail::Own
                })
            })
            .collect::<Result<_, SolveError>>()?;
        let machines = columns
            .iter()
            .map(|block| (block.machine, block.parameters));
        let mut machines = machines.chain([(machine, mover.parameters)]);
        let is_late = |(machine, values): (&Machine, &[f64])| !machine.delays(values).is_empty();
        Ok(Self {
            jumps: hold == Hold::Previous && machines.any(is_late),
            own,
            other: other.transpose()?.unwrap_or_default(),
            blocks,
        })
    }

    /// Puts the curve's memory into `states`; returns that of each block.
    pub fn at(&self, states: &mut States, node: usize, range: Range<usize>) -> Vec<Memory> {
        states.memory = self.own.nodes[node].slice(range.clone());
        let slice = |block: &BlockTrail| {
            let trail = match block {
                BlockTrail::Own => &self.own,
                BlockTrail::Other => &self.other,
                BlockTrail::Particular(trail) => trail,
            };
            trail.nodes[node].slice(range.clone())
        };
        self.blocks.iter().map(slice).collect()
    }

    /// The curve's samples as what is read there feels them, and the memory of each block, where that is
    /// not what moves the machines behind them: a late input that is held jumps.
    pub fn at_jumps(&self, curve: &States) -> Option<(States, Vec<Memory>)> {
        let memory = |block: &BlockTrail| match block {
            BlockTrail::Own => self.own.felt(),
            BlockTrail::Other => self.other.felt(),
            BlockTrail::Particular(trail) => trail.felt(),
        };
        self.jumps.then(|| {
            let states = States {
                memory: self.own.felt(),
                ..curve.clone()
            };
            (states, self.blocks.iter().map(memory).collect())
        })
    }

    /// How fast inputs, then late ones, change in some intervals, one column each.
    pub fn input_rates(&self, curve: &States, intervals: &[usize], hold: Hold) -> DMatrix<f64> {
        let memory = |share| self.own.within(intervals, &vec![share; intervals.len()]);
        let (before, after) = (memory(0.0).delayed, memory(1.0).delayed);
        let (inputs, late) = (curve.u.len(), before.len());
        DMatrix::from_fn(inputs + late, intervals.len(), |input, i| {
            let k = intervals[i];
            let change = match input.checked_sub(inputs) {
                Some(late) => after[late][i] - before[late][i],
                None if hold == Hold::Linear => curve.u[input][k + 1] - curve.u[input][k],
                None => 0.0,
            };
            change / (curve.t[k + 1] - curve.t[k])
        })
    }

    /// As [`at`](Self::at), some shares of the way into some intervals.
    pub fn within(&self, states: &mut States, intervals: &[usize], share: &[f64]) -> Vec<Memory> {
        states.memory = self.own.within(intervals, share);
        let at = |block: &BlockTrail| match block {
            BlockTrail::Own => states.memory.clone(),
            BlockTrail::Other => self.other.within(intervals, share),
            BlockTrail::Particular(trail) => trail.within(intervals, share),
        };
        self.blocks.iter().map(at).collect()
    }
}
