//! One effect on a body in the stead of several terms.
//!
//! A load on a link changes its mass, its centre of mass and its inertia. Each of them alone
//! explains part of it, so that one after the other is taken for wrong; a load on another link
//! and a spring do as much. One cause is simpler than two or three that happen to be there at
//! once.

use super::TIE;
use super::fitting::fit;
use super::search::{Attempt, Search, reset};
use crate::trace::dictionary::Subject;
use crate::trace::rivals::Alternative;
use crate::trace::screen::{Considered, Screen};
use rayon::prelude::*;

/// How many effects are tried for each set of terms.
const TRIED: usize = 3;

impl Search<'_> {
    /// The accepted terms with some replaced by one effect on a body, if that explains the
    /// log about as well.
    pub(super) fn gathered(&self) -> Option<Attempt> {
        let is_massive = |&c: &usize| self.is_parameter(c) || self.is_on_a_body(c);
        let accepted = || self.accepted.iter().copied();
        let massive: Vec<usize> = accepted().filter(is_massive).collect();
        let forces = accepted().filter(|c| !is_massive(c) && !self.is_channel(*c));
        let forces: Vec<usize> = forces.collect();
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let gathered = sets(&massive, &forces).into_iter().flat_map(|set| {
            let limit = self.current.cost + TIE + (set.len() - 1) as f64 * search_price;
            let instead = self.instead_of(&set, TRIED).unwrap_or_default();
            instead
                .into_iter()
                .filter(move |attempt| attempt.cost < limit)
        });
        let possible = gathered.filter(|attempt| self.is_possible(attempt));
        possible.min_by(|a, b| {
            a.candidates
                .len()
                .cmp(&b.candidates.len())
                .then(a.cost.total_cmp(&b.cost))
        })
    }

    /// Adds to the `alternatives` of each accepted parameter a load that explains the log no
    /// worse, where that has more parameters: it costs more, but nothing speaks against it.
    pub(super) fn add_loads(&self, alternatives: &mut [Vec<Alternative>]) {
        for (i, &term) in self.accepted.iter().enumerate() {
            if !self.is_parameter(term) {
                continue;
            }
            let loads = self.instead_of(&[term], TRIED).unwrap_or_default();
            let as_good = |load: &Attempt| load.estimate.cost < self.current.estimate.cost;
            for load in loads.into_iter().filter(as_good) {
                let Some(&candidate) = load.candidates.last() else {
                    continue;
                };
                alternatives[i].retain(|known| known.candidate != candidate);
                alternatives[i].push(Alternative {
                    candidate,
                    better: self.current.cost - load.cost,
                    values: load.explanation.values,
                });
            }
            alternatives[i].sort_by(|a, b| b.better.total_cmp(&a.better));
        }
    }

    fn is_parameter(&self, candidate: usize) -> bool {
        let subject = &self.dictionary.candidates[candidate].subject;
        matches!(subject, Subject::Parameter(_))
    }

    fn is_channel(&self, candidate: usize) -> bool {
        self.dictionary.candidates[candidate].channel
    }

    /// Whether a candidate is an effect that acts on one body.
    pub(super) fn is_on_a_body(&self, candidate: usize) -> bool {
        let on = self.dictionary.candidates[candidate].subject.on();
        let mut bodies = self.dictionary.machine.compiled.model.moving_bodies();
        !self.is_parameter(candidate) && on.len() == 1 && bodies.any(|body| body.name == on[0])
    }

    /// Attempts without `set` and with one effect on a body, so many of them at most.
    fn instead_of(&self, set: &[usize], most: usize) -> Option<Vec<Attempt>> {
        let mut explanation = self.current.explanation.clone();
        set.iter()
            .for_each(|&c| reset(self.dictionary, &mut explanation, c));
        let others: Vec<usize> = self
            .accepted
            .iter()
            .copied()
            .filter(|c| !set.contains(c))
            .collect();
        let without = Search {
            dictionary: self.dictionary,
            progress: self.progress,
            accepted: others.clone(),
            current: fit(self.dictionary, &others, explanation).ok()?,
            first_round: Vec::new(),
        };
        let screen = Screen::new(self.dictionary, &without.current.explanation, &others).ok()?;
        let considered = screen.considered(&screen.grams());
        let whole = |c: &&Considered| self.is_on_a_body(c.candidate);
        let wholes: Vec<&Considered> = considered.iter().filter(whole).take(most).collect();
        let tried = wholes.into_par_iter().map(|c| {
            let attempt = without.attempt_in_some_shape(c).ok()?;
            Some(without.sharpened(attempt))
        });
        Some(tried.collect::<Vec<_>>().into_iter().flatten().collect())
    }
}

/// What may be one cause: all that is `massive`, every two of it, and one of it with one of
/// the `forces`.
fn sets(massive: &[usize], forces: &[usize]) -> Vec<Vec<usize>> {
    let mut sets = Vec::new();
    if massive.len() > 2 {
        sets.push(massive.to_vec());
    }
    for (i, &a) in massive.iter().enumerate() {
        let others = massive[i + 1..].iter().chain(forces);
        sets.extend(others.map(|&b| vec![a, b]));
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::sets;

    #[test]
    fn sets_have_two_members_or_all() {
        assert!(sets(&[1], &[]).is_empty());
        assert!(sets(&[], &[7, 8]).is_empty());
        assert_eq!(sets(&[1, 2], &[]), [[1, 2]]);
        assert_eq!(sets(&[1], &[7, 8]), [[1, 7], [1, 8]]);
        let of_three = [vec![1, 2, 3], vec![1, 2], vec![1, 3], vec![2, 3]];
        assert_eq!(sets(&[1, 2, 3], &[]), of_three);
    }
}
