//! One effect on a body in the stead of several terms.
//!
//! A load on a link changes its mass, its centre of mass and its inertia. Each of them alone
//! explains part of it, so that one after the other is taken for wrong; a load on another link
//! and a spring do as much. One cause is simpler than two or three that happen to be there at
//! once.

use super::TIE;
use super::fitting::fit;
use super::search::{Attempt, MARGIN, Search, reset};
use crate::trace::rivals::{Alternative, join};
use crate::trace::screen::{Considered, Screen};
use crate::trace::subject::Subject;
use rayon::prelude::*;

/// How many effects are tried for each set of terms, and how many sets short of all are
/// looked at.
const TRIED: usize = 3;
const LOOKED_AT: usize = 8;

/// The accepted terms with one effect on a body in the stead of some.
pub(super) struct Instead {
    /// Which are gone.
    set: Vec<usize>,
    /// What there is now.
    attempt: Attempt,
}

impl Search<'_> {
    /// What effects on bodies would make of the log in the stead of some accepted terms, the
    /// best for each set of these.
    pub(super) fn loads_instead(&self) -> Vec<Instead> {
        let is_massive = |&c: &usize| self.is_parameter(c) || self.is_on_a_body(c);
        let accepted = || self.accepted.iter().copied();
        let massive: Vec<usize> = accepted().filter(is_massive).collect();
        let forces = accepted().filter(|c| !is_massive(c) && !self.is_channel(*c));
        let forces: Vec<usize> = forces.collect();
        let attempt = |set: Vec<usize>| {
            let attempt = self.instead_of(&set)?;
            self.is_possible(&attempt)
                .then_some(Instead { set, attempt })
        };
        // Nothing is simpler than one effect in the stead of all.
        let all = (massive.len() > 2).then(|| attempt(massive.clone()));
        let all = all.flatten();
        if all.as_ref().is_some_and(|all| self.is_worth_it(all)) {
            return all.into_iter().collect();
        }
        let parameters = accepted()
            .filter(|&c| self.is_parameter(c))
            .map(|c| vec![c]);
        let sets = parameters.chain(pairs(&massive, &forces)).take(LOOKED_AT);
        all.into_iter().chain(sets.filter_map(attempt)).collect()
    }

    /// Whether a load explains the log about as well with less; or better.
    fn is_worth_it(&self, load: &Instead) -> bool {
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let limit = match load.set.len() {
            1 => self.current.cost - MARGIN,
            more => self.current.cost + TIE + (more - 1) as f64 * search_price,
        };
        load.attempt.cost < limit
    }

    /// One of these that explains the log about as well with less; or better.
    pub(super) fn gathered(&self, loads: Vec<Instead>) -> Result<Attempt, Vec<Instead>> {
        let good = loads.iter().enumerate();
        let good = good.filter(|(_, load)| self.is_worth_it(load));
        let best = good.min_by(|(_, a), (_, b)| {
            let size = |load: &Instead| load.attempt.candidates.len();
            size(a)
                .cmp(&size(b))
                .then(a.attempt.cost.total_cmp(&b.attempt.cost))
        });
        match best.map(|(position, _)| position) {
            Some(position) => {
                let mut loads = loads;
                Ok(loads.swap_remove(position).attempt)
            }
            None => Err(loads),
        }
    }

    /// Adds to the `alternatives` of each accepted parameter a load that explains the log no
    /// worse, where that has more parameters: it costs more, but nothing speaks against it.
    pub(super) fn add_loads(&self, loads: Vec<Instead>, alternatives: &mut [Vec<Alternative>]) {
        for Instead { set, attempt: load } in loads {
            let place = self.accepted.iter().position(|term| set == [*term]);
            let as_good = load.estimate.cost < self.current.estimate.cost;
            let (Some(place), Some(&candidate), true) = (place, load.candidates.last(), as_good)
            else {
                continue;
            };
            let alternative = Alternative {
                candidate,
                better: self.current.cost - load.cost,
                values: load.explanation.values,
            };
            join(&mut alternatives[place], alternative);
        }
    }

    /// Whether a candidate is another value of one of the model's parameters.
    pub(super) fn is_parameter(&self, candidate: usize) -> bool {
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

    /// The best attempt without `set` and with one effect on a body.
    fn instead_of(&self, set: &[usize]) -> Option<Attempt> {
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
            given_cost: self.given_cost,
            progress: self.progress,
            accepted: others.clone(),
            current: fit(self.dictionary, &others, explanation).ok()?,
            first_round: Vec::new(),
        };
        let screen = Screen::new(self.dictionary, &without.current.explanation, &others).ok()?;
        let considered = screen.considered(&screen.grams());
        let whole = |c: &&Considered| self.is_on_a_body(c.candidate);
        let wholes: Vec<&Considered> = considered.iter().filter(whole).take(TRIED).collect();
        let tried = wholes.into_par_iter();
        let tried = tried.map(|c| without.attempt_in_some_shape(c).ok());
        let tried: Vec<Option<Attempt>> = tried.collect();
        let best = tried.into_iter().flatten();
        let best = best.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        Some(without.converged(without.sharpened(best)))
    }
}

/// What may be one cause: every two of what is `massive`, and one of it with one of the `forces`.
fn pairs(massive: &[usize], forces: &[usize]) -> Vec<Vec<usize>> {
    let mut pairs = Vec::new();
    for (i, &a) in massive.iter().enumerate() {
        let others = massive[i + 1..].iter().chain(forces);
        pairs.extend(others.map(|&b| vec![a, b]));
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::pairs;

    #[test]
    fn pairs_have_a_massive_member() {
        assert!(pairs(&[1], &[]).is_empty());
        assert!(pairs(&[], &[7, 8]).is_empty());
        assert_eq!(pairs(&[1, 2], &[]), [[1, 2]]);
        assert_eq!(pairs(&[1], &[7, 8]), [[1, 7], [1, 8]]);
        assert_eq!(pairs(&[1, 2, 3], &[]), [[1, 2], [1, 3], [2, 3]]);
    }
}
