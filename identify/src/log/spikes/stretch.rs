//! What the neighbours of a sample say of it.

use std::ops::Range;

/// Neighbours that a sample is compared with.
const NODES: usize = 4;

/// A channel between two gaps, less what has been set aside of it already.
#[derive(Clone, Copy)]
pub(super) struct Stretch<'a> {
    pub t: &'a [f64],
    pub values: &'a [f64],
    pub aside: &'a [bool],
}

/// What neighbours say of a sample.
#[derive(Clone, Copy)]
pub(super) struct Said {
    /// The value on the cubic through them.
    pub value: f64,
    /// Standard deviation of the sample's distance to it where all have independent errors of
    /// one.
    pub gain: f64,
}

impl Stretch<'_> {
    /// What the four nearest samples say of sample `k`, two on each side where there are, without
    /// those set aside and those in `without`; nothing where there are not four.
    pub fn said(&self, k: usize, without: &Range<usize>) -> Option<Said> {
        let is_free = |j: &usize| !self.aside[*j] && !without.contains(j);
        let mut before = (0..k).rev().filter(is_free);
        let mut after = (k + 1..self.t.len()).filter(is_free);
        let mut nodes = [0; NODES];
        let mut count = 0;
        while count < NODES {
            let pair = [before.next(), after.next()];
            if pair == [None, None] {
                return None;
            }
            for node in pair.into_iter().flatten() {
                if count < NODES {
                    nodes[count] = node;
                    count += 1;
                }
            }
        }
        let (mut value, mut squares) = (0.0, 1.0);
        for &i in &nodes {
            let others = nodes.iter().filter(|&&j| j != i);
            let weight: f64 = others
                .map(|&j| (self.t[k] - self.t[j]) / (self.t[i] - self.t[j]))
                .product();
            // As a distance from one of them, which keeps equal values equal.
            value += weight * (self.values[i] - self.values[nodes[0]]);
            squares += weight * weight;
        }
        Some(Said {
            value: self.values[nodes[0]] + value,
            gain: squares.sqrt(),
        })
    }

    /// How far sample `k` is from what its neighbours say, as a multiple of [`Said::gain`].
    pub fn departure(&self, k: usize, without: &Range<usize>) -> Option<f64> {
        let said = self.said(k, without)?;
        Some((self.values[k] - said.value) / said.gain)
    }
}
