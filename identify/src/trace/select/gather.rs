//! One effect in the stead of several parameters.
//!
//! A load on a link changes its mass, its centre of mass and its inertia. Each of them alone
//! explains part of it, so that one after the other is taken for wrong. One cause is simpler
//! than two or three values that happen to be off at once.

use super::TIE;
use super::fitting::fit;
use super::search::{Attempt, Search, reset};
use crate::trace::dictionary::Subject;
use crate::trace::rivals::Alternative;
use crate::trace::screen::{Considered, Screen};
use rayon::prelude::*;

/// How many effects are tried for each set of parameters.
const TRIED: usize = 3;

impl Search<'_> {
    /// The accepted terms with some parameters replaced by one effect on a body, if that
    /// explains the log about as well.
    pub(super) fn gathered(&self) -> Option<Attempt> {
        let parameters: Vec<usize> = self
            .accepted
            .iter()
            .copied()
            .filter(|&c| self.is_parameter(c))
            .collect();
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let gathered = sets(&parameters).into_iter().flat_map(|set| {
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

    /// Whether a candidate is an effect that acts on one body.
    fn is_on_a_body(&self, candidate: usize) -> bool {
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

/// All of them, and every two.
fn sets(all: &[usize]) -> Vec<Vec<usize>> {
    if all.len() < 2 {
        return Vec::new();
    }
    let mut sets = vec![all.to_vec()];
    for (i, &a) in all.iter().enumerate().filter(|_| all.len() > 2) {
        sets.extend(all[i + 1..].iter().map(|&b| vec![a, b]));
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::sets;

    #[test]
    fn sets_are_all_and_every_two() {
        assert!(sets(&[1]).is_empty());
        assert_eq!(sets(&[1, 2]), [[1, 2]]);
        let of_three = [vec![1, 2, 3], vec![1, 2], vec![1, 3], vec![2, 3]];
        assert_eq!(sets(&[1, 2, 3]), of_three);
    }
}
