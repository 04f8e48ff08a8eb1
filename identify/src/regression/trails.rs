//! What machines remember along a curve.

use super::mover::{Columns, Mover};
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

/// Places along the curve.
pub(super) struct Visited {
    /// The curve there, with its memory.
    pub states: States,
    /// The memory of each block of columns.
    pub memories: Vec<Memory>,
}

impl Visited {
    /// Whether these are ends of intervals, each of them where the next of these `beginnings` is.
    pub fn goes_on_in(&self, beginnings: &Self) -> bool {
        let [ends, starts] = [self, beginnings].map(|places| {
            let States {
                q, v, u, memory, ..
            } = &places.states;
            let known = [q, v, u].into_iter();
            let memories = std::iter::once(memory).chain(&places.memories);
            known.chain(memories.flat_map(Memory::columns)).flatten()
        });
        let mut pairs = ends.zip(starts);
        !self.states.t.is_empty() && pairs.all(|(end, start)| end[..end.len() - 1] == start[1..])
    }

    /// One of them.
    pub fn only(&self, place: usize) -> Self {
        let slice = |memory: &Memory| memory.slice(place..place + 1);
        Self {
            states: self.states.slice(place..place + 1),
            memories: self.memories.iter().map(slice).collect(),
        }
    }
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

    /// These states of the intervals in `range`, at their beginnings, middles or ends, with what is remembered there.
    pub fn visit(&self, mut states: States, node: usize, range: Range<usize>) -> Visited {
        states.memory = self.own.nodes[node].slice(range.clone());
        let slice = |block: &BlockTrail| {
            let trail = match block {
                BlockTrail::Own => &self.own,
                BlockTrail::Other => &self.other,
                BlockTrail::Particular(trail) => trail,
            };
            trail.nodes[node].slice(range.clone())
        };
        let memories = self.blocks.iter().map(slice).collect();
        Visited { states, memories }
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

    /// Puts the curve's memory into `states` and returns that of each block, some shares of the way into some intervals.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_go_on_where_the_next_begin_unless_inputs_jump_or_samples_lack() {
        let curve = States {
            t: vec![0.0, 0.1, 0.2, 0.4],
            q: vec![vec![0.3, 0.1, 0.4, 0.7]],
            v: vec![vec![-1.0, 0.7, 2.0, 0.1]],
            u: vec![vec![0.1, 0.3, 0.2, 0.6]],
            ..States::default()
        };
        let goes_on = |hold: Hold, longest: f64, remembered: [f64; 2]| {
            let [ends, starts] = [(1.0, remembered[1]), (0.0, remembered[0])].map(|(share, z)| {
                let memory = Memory {
                    z: vec![vec![z; 3]],
                    ..Memory::default()
                };
                Visited {
                    states: curve.between(0..3, share, hold, longest),
                    memories: vec![memory],
                }
            });
            ends.goes_on_in(&starts)
        };
        assert!(goes_on(Hold::Linear, 1.0, [0.5, 0.5]));
        assert!(!goes_on(Hold::Previous, 1.0, [0.5, 0.5]));
        assert!(!goes_on(Hold::Linear, 1.0, [0.5, 0.6]));
        // Across a gap the machine stays where it is; behind the last interval nothing begins.
        assert!(goes_on(Hold::Linear, 0.15, [0.5, 0.5]));
        assert!(!goes_on(Hold::Linear, 0.05, [0.5, 0.5]));
    }
}
