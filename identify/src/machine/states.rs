//! States in columns: one entry per sample.

use super::hold::Hold;
use super::trail::Memory;
use crate::log::Record;
use crate::smooth::{SgStates, Smoothed};
use dynamics_codegen::Column;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Where a machine is evaluated. Every column has one entry per sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct States {
    /// Time, s.
    pub t: Vec<f64>,
    /// Positions, one column each ([`Model::positions`](dynamics_codegen::Model::positions)).
    pub q: Vec<Vec<f64>>,
    /// Velocities, one column per coordinate.
    pub v: Vec<Vec<f64>>,
    /// Inputs, one column per input.
    pub u: Vec<Vec<f64>>,
    /// What the machine remembers here; by default nothing has happened yet.
    pub memory: Memory,
    /// What there was before, where these states are part of a longer motion.
    pub history: Option<Arc<History>>,
    /// By how much internal states begin beside what the model states, by name: a machine that
    /// moves already has been there before.
    pub begun: Arc<Begun>,
}

/// By how much internal states begin beside what the model states, by name; those that are not in it
/// begin as stated.
pub type Begun = BTreeMap<String, f64>;

/// A whole motion of which some states are part.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// Sampling instants, s.
    pub t: Vec<f64>,
    /// Inputs, one column per input.
    pub u: Vec<Vec<f64>>,
    /// The curve at the part's samples and at those that lead to them.
    pub led: States,
}

impl States {
    /// The smoothed motion of a record with its inputs, without memory.
    pub fn along(record: &Record, smoothed: &[Smoothed]) -> Self {
        Self {
            t: record.t.clone(),
            q: smoothed.iter().map(|s| s.q.clone()).collect(),
            v: smoothed.iter().map(|s| s.v.clone()).collect(),
            u: record.u.clone(),
            ..Self::default()
        }
    }

    /// The filtered motion of a record with its inputs, without memory.
    pub fn filtered(record: &Record, filtered: &SgStates) -> Self {
        Self {
            t: record.t.clone(),
            q: filtered.q.clone(),
            v: filtered.v.clone(),
            u: record.u.clone(),
            ..Self::default()
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// The tape's inputs, in the order `t, q, v, u, delayed u, z, parameters`.
    pub(super) fn columns<'a>(&'a self, parameters: &'a [f64]) -> Vec<Column<'a>> {
        let mut columns = vec![Column::Each(self.t.as_slice())];
        let memory = &self.memory;
        for group in [&self.q, &self.v, &self.u, &memory.delayed, &memory.z] {
            columns.extend(group.iter().map(|column| Column::Each(column.as_slice())));
        }
        columns.extend(parameters.iter().map(|&value| Column::Same(value)));
        columns
    }

    /// Inputs that jump at each sample, as what they are on average around it: what a filter
    /// that sees both sides makes of them. At the first sample of a segment they are as they go on.
    #[must_use]
    pub fn between_jumps(mut self, segments: &[std::ops::Range<usize>]) -> Self {
        for column in self.u.iter_mut().chain(&mut self.memory.delayed) {
            for range in segments {
                for k in (range.start + 1..range.end).rev() {
                    column[k] = (column[k - 1] + column[k]) / 2.0;
                }
            }
        }
        self
    }

    /// The samples in `range`.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Self {
        let cut =
            |columns: &[Vec<f64>]| columns.iter().map(|c| c[range.clone()].to_vec()).collect();
        Self {
            t: self.t[range.clone()].to_vec(),
            q: cut(&self.q),
            v: cut(&self.v),
            u: cut(&self.u),
            memory: self.memory.slice(range),
            history: self.history.clone(),
            begun: Arc::clone(&self.begun),
        }
    }

    /// Some samples, without memory.
    pub fn pick(&self, samples: &[usize]) -> Self {
        let column = |c: &Vec<f64>| samples.iter().map(|&k| c[k]).collect();
        let columns = |columns: &[Vec<f64>]| columns.iter().map(column).collect();
        Self {
            t: column(&self.t),
            q: columns(&self.q),
            v: columns(&self.v),
            u: columns(&self.u),
            ..Self::default()
        }
    }

    /// This part of a longer motion with the samples that lead to it, and the places of its own
    /// among them; `None` where no others are known.
    pub(super) fn led(&self) -> Option<(Self, Vec<usize>)> {
        let history = self.history.as_ref()?;
        let of = |t: &f64| history.led.t.binary_search_by(|other| other.total_cmp(t));
        let places: Vec<usize> = self.t.iter().map(of).collect::<Result<_, _>>().ok()?;
        if places.len() == history.led.len() {
            return None;
        }
        let mut whole = history.led.clone();
        whole.begun = Arc::clone(&self.begun);
        let columns =
            |states: &Self| [states.q.clone(), states.v.clone(), states.u.clone()].concat();
        let own = columns(self);
        let theirs = [&mut whole.q, &mut whole.v, &mut whole.u]
            .into_iter()
            .flatten();
        for (column, own) in theirs.zip(own) {
            for (&place, value) in places.iter().zip(own) {
                column[place] = value;
            }
        }
        whole.history = Some(Arc::new(History {
            led: Self::default(),
            ..History::clone(history)
        }));
        Some((whole, places))
    }

    /// About `count` samples, evenly spread, without memory.
    pub fn spread(&self, count: usize) -> Self {
        let stride = self.len().div_ceil(count.max(1)).max(1);
        self.pick(&(0..self.len()).step_by(stride).collect::<Vec<usize>>())
    }

    /// The curve a share (none, half, all) of the way from each sample in `range` to the next: cubic in
    /// `q` (Hermite), so that its rate is the velocity at both ends. Without memory. Where
    /// the next sample is more than `longest` seconds away, nobody knows the way there: the
    /// machine stays where it is.
    pub fn between(
        &self,
        range: std::ops::Range<usize>,
        share: f64,
        hold: Hold,
        longest: f64,
    ) -> Self {
        let intervals = range.clone();
        let t = intervals
            .clone()
            .map(|k| straight(self.t[k], self.t[k + 1], share))
            .collect();
        let (mut q, mut v) = (Vec::new(), Vec::new());
        for (positions, rates) in self.q.iter().zip(&self.v) {
            let at = |k: usize| {
                let h = self.t[k + 1] - self.t[k];
                let (q0, q1, v0, v1) = (positions[k], positions[k + 1], rates[k], rates[k + 1]);
                if share == 0.0 || h > longest {
                    return (q0, v0);
                }
                if share == 1.0 {
                    return (q1, v1);
                }
                let middle = (q0 + q1) / 2.0 + h / 8.0 * (v0 - v1);
                (middle, 1.5 * (q1 - q0) / h - (v0 + v1) / 4.0)
            };
            let (qs, vs) = intervals.clone().map(at).unzip();
            q.push(qs);
            v.push(vs);
        }
        let input = |u: &Vec<f64>| {
            intervals
                .clone()
                .map(|k| match hold {
                    Hold::Linear => straight(u[k], u[k + 1], share),
                    Hold::Previous => u[k],
                })
                .collect()
        };
        Self {
            t,
            q,
            v,
            u: self.u.iter().map(input).collect(),
            ..Self::default()
        }
    }
}

/// What goes straight from `a` to `b`, some share of the way: at its ends exactly these.
fn straight(a: f64, b: f64, share: f64) -> f64 {
    match share {
        1.0 => b,
        share => a + share * (b - a),
    }
}
