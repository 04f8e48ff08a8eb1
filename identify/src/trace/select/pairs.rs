//! Two candidates at once.

use super::TIE;
use super::leaders::{MAX_LEADERS, MAX_PROFILED};
use super::search::{Attempt, LEAST_REMOVED, MARGIN, NO_EXCESS, Search};
use crate::trace::refine::SMALLEST_SHARE;
use crate::trace::screen::{Considered, Pair, Screen};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A pair in the stead of a rich effect must have this share of its gain by a linear fit.
const PAIR_SHARE: f64 = 0.9;
/// How many candidates are looked at two at a time.
const MAX_PAIRED: usize = 64;

impl Search<'_> {
    /// Two simple effects at the place of a rich one that explain the log as well with
    /// fewer parameters: Coulomb and viscous friction, not Stribeck's.
    pub(super) fn in_two_parts(
        &self,
        screen: &Screen<'_>,
        whole: &Attempt,
        considered: &[Considered],
    ) -> Option<Attempt> {
        let &rich = whole.candidates.last()?;
        let rich_gain = considered.iter().find(|c| c.candidate == rich)?.gain;
        let on = self.dictionary.candidates[rich].subject.on();
        let size = |c: &Considered| self.dictionary.candidates[c.candidate].size();
        let rich_size = self.dictionary.candidates[rich].size();
        let simple: Vec<&Considered> = considered
            .iter()
            .filter(|c| c.candidate != rich && c.gain > 0.0)
            .filter(|c| self.dictionary.candidates[c.candidate].subject.on() == on)
            .collect();
        let mut pairs = screen.pairs(&simple, |a, b| size(a) + size(b) < rich_size);
        pairs.retain(|pair| pair.gain > PAIR_SHARE * rich_gain);
        pairs.truncate(MAX_LEADERS);
        let parts = self.attempt_pairs(&pairs);
        parts
            .filter(|parts| parts.cost < whole.cost + TIE)
            .filter(|parts| self.is_possible(parts) && self.earns(parts))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    pub(super) fn attempt_pairs(&self, pairs: &[Pair]) -> impl Iterator<Item = Attempt> + use<> {
        let both = |pair: &Pair| self.attempt(&[&pair.members[0], &pair.members[1]]).ok();
        let attempts: Vec<_> = pairs.par_iter().map(both).collect();
        attempts.into_iter().flatten()
    }

    /// Two candidates that only together explain the log: taken one after the other, the
    /// first might have been something that resembles both. Better than `single`, which has
    /// one of these places filled or none, by what each further term must bring.
    pub(super) fn at_once(
        &self,
        screen: &Screen<'_>,
        single: &Attempt,
        considered: &[Considered],
    ) -> Option<Attempt> {
        if single.estimate.unexplained <= NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE {
            return None;
        }
        let likely = considered.iter().filter(|c| c.score > MARGIN);
        let singles: Vec<&Considered> = likely
            .take(MAX_PAIRED)
            .flat_map(|c| std::iter::once(c).chain(&c.other_shapes))
            .collect();
        let mut pairs = screen.pairs(&singles, |_, _| true);
        // Each pair in its best shapes.
        let mut seen = BTreeSet::new();
        pairs.retain(|pair| seen.insert(pair.members.each_ref().map(|c| c.candidate)));
        pairs.truncate(MAX_PROFILED);
        let rows = screen.dynamics.t.len() as f64;
        let mut profiled: Vec<(f64, Pair)> = pairs
            .into_par_iter()
            .map(|pair| {
                let [a, b] = &pair.members;
                let size = |c: &Considered| self.dictionary.candidates[c.candidate].size();
                let price = 0.5 * (size(a) + size(b)) as f64 * rows.ln();
                (screen.profile(&[a, b]) + price, pair)
            })
            .collect();
        profiled.sort_by(|a, b| a.0.total_cmp(&b.0));
        profiled.truncate(MAX_LEADERS);
        let pairs: Vec<Pair> = profiled.into_iter().map(|(_, pair)| pair).collect();
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let further = self.accepted.len() + 2 - single.candidates.len();
        let limit = single.cost - further as f64 * (search_price + MARGIN);
        let least_removed = 1.0 - (1.0 - LEAST_REMOVED).powi(further as i32);
        self.attempt_pairs(&pairs)
            .filter(|both| both.cost < limit && self.is_possible(both) && self.earns(both))
            .filter(|both| {
                let (before, after) = (single.estimate.unexplained, both.estimate.unexplained);
                after < (1.0 - least_removed) * before
            })
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}
