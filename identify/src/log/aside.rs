//! Which samples of a record are set aside.

use super::record::stretches;
use std::ops::Range;

/// Samples in whose place stands what their neighbours say: no measurements, and without weight.
/// A flag per sample and coordinate; none at all where nothing of a channel is set aside.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Aside {
    /// Of the positions.
    pub q: Vec<Vec<bool>>,
    /// Of the velocities.
    pub dq: Vec<Vec<bool>>,
    /// Of the accelerations.
    pub ddq: Vec<Vec<bool>>,
}

impl Aside {
    /// Nothing, of so many coordinates.
    pub(super) fn nothing(coordinates: usize) -> Self {
        let nothing = || vec![Vec::new(); coordinates];
        Self {
            q: nothing(),
            dq: nothing(),
            ddq: nothing(),
        }
    }

    /// Of the position, velocity and acceleration of coordinate `i`.
    pub fn of(&self, i: usize) -> [&[bool]; 3] {
        [&self.q, &self.dq, &self.ddq].map(|flags| flags.get(i).map_or(&[][..], Vec::as_slice))
    }

    /// Every `stride`-th sample, from the first on.
    pub(super) fn thinned(&self, stride: usize) -> Self {
        self.each(|flags| flags.iter().step_by(stride).copied().collect())
    }

    /// The samples of some ranges, one after the other.
    pub(super) fn stretches(&self, ranges: &[Range<usize>]) -> Self {
        self.each(|flags| stretches(flags, ranges))
    }

    fn each(&self, change: impl Fn(&[bool]) -> Vec<bool>) -> Self {
        let all = |channels: &[Vec<bool>]| channels.iter().map(|flags| change(flags)).collect();
        Self {
            q: all(&self.q),
            dq: all(&self.dq),
            ddq: all(&self.ddq),
        }
    }
}

/// Whether sample `k` is set aside by the flags of a channel.
pub(crate) fn is_aside(flags: &[bool], k: usize) -> bool {
    flags.get(k) == Some(&true)
}
