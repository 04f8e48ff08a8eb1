//! What a machine remembers at samples and along the intervals between them.

use std::array::from_fn;
use std::ops::Range;

/// Delayed inputs and states at some samples, in columns. Empty columns stand for a
/// machine at rest: inputs as they have always been, states as at the beginning.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Memory {
    /// `u(t − τ)`, one column per delay.
    pub delayed: Vec<Vec<f64>>,
    /// `u̇(t − τ)`, one column per delay.
    pub delay_rate: Vec<Vec<f64>>,
    /// `z`, one column per state.
    pub z: Vec<Vec<f64>>,
    /// `∂z/∂p`, one column per slope of the derivatives' tape it was made for.
    pub slopes: Vec<Vec<f64>>,
}

impl Memory {
    /// All there is, in groups of columns.
    pub fn columns(&self) -> [&Vec<Vec<f64>>; 4] {
        [&self.delayed, &self.delay_rate, &self.z, &self.slopes]
    }

    /// From groups of columns, in the order of [`Self::columns`].
    fn of([delayed, delay_rate, z, slopes]: [Vec<Vec<f64>>; 4]) -> Self {
        Self {
            delayed,
            delay_rate,
            z,
            slopes,
        }
    }

    /// The samples in `range`.
    #[must_use]
    pub fn slice(&self, range: Range<usize>) -> Self {
        let cut = |column: &Vec<f64>| column[range.clone()].to_vec();
        Self::of(self.columns().map(|group| group.iter().map(cut).collect()))
    }

    /// Some of the samples.
    fn pick(&self, samples: &[usize]) -> Self {
        let pick = |column: &Vec<f64>| samples.iter().map(|&k| column[k]).collect();
        Self::of(self.columns().map(|group| group.iter().map(pick).collect()))
    }
}

/// Memory at the start, the middle and the end of every interval of a curve, and at its samples.
#[derive(Debug, Clone, Default)]
pub struct Trail {
    /// Per node, in this order.
    pub nodes: [Memory; 3],
    /// Delayed inputs at the samples.
    pub(super) momentary: Memory,
}

impl Trail {
    /// Over the intervals between some samples of the curve. Between two that are not neighbours
    /// nobody asks for the middle.
    pub(super) fn at(&self, samples: &[usize]) -> Self {
        let pairs = || samples.windows(2).map(|pair| (pair[0], pair[1] - 1));
        let starts: Vec<usize> = pairs().map(|(first, _)| first).collect();
        let ends: Vec<usize> = pairs().map(|(_, last)| last).collect();
        let [start, middle, end] = &self.nodes;
        Self {
            nodes: [start.pick(&starts), middle.pick(&starts), end.pick(&ends)],
            momentary: self.momentary.pick(samples),
        }
    }

    /// Memory at the samples: of a late input that stays at its values the mean over the interval behind.
    pub fn samples(&self) -> Memory {
        let [starts, _, ends] = self.nodes.each_ref().map(Memory::columns);
        let with_last = |(column, end): (&Vec<f64>, &Vec<f64>)| {
            column.iter().copied().chain(end.last().copied()).collect()
        };
        Memory::of(from_fn(|group| {
            let pairs = starts[group].iter().zip(ends[group]);
            pairs.map(with_last).collect()
        }))
    }

    /// The same as what is read at the samples feels it: of a late input that stays at its values the
    /// present one.
    pub fn felt(&self) -> Memory {
        Memory {
            delayed: self.momentary.delayed.clone(),
            delay_rate: self.momentary.delay_rate.clone(),
            ..self.samples()
        }
    }

    /// Memory some shares of the way into intervals, straight from node to node.
    pub fn within(&self, intervals: &[usize], shares: &[f64]) -> Memory {
        let [starts, middles, ends] = self.nodes.each_ref().map(Memory::columns);
        let column = |((a, b), c): ((&Vec<f64>, &Vec<f64>), &Vec<f64>)| {
            let at = |(&k, &share): (&usize, &f64)| match 2.0 * share {
                early if early < 1.0 => a[k] + early * (b[k] - a[k]),
                late => b[k] + (late - 1.0) * (c[k] - b[k]),
            };
            intervals.iter().zip(shares).map(at).collect()
        };
        Memory::of(from_fn(|group| {
            let nodes = starts[group].iter().zip(middles[group]).zip(ends[group]);
            nodes.map(column).collect()
        }))
    }
}
