//! Two steps at once.
//!
//! Of two things that are missing the first may leave nearly all forces where they are, and
//! alone earn no place, however much likelier it makes the log: a drive whose dead band hides
//! the friction behind it. The screen about the model as given is then a poor guide to the
//! second; from where the first has been fitted it is a good one.

use super::leaders::leaders;
use super::search::{Attempt, LEAST_REMOVED, MARGIN, Search, leaves_forces};
use crate::trace::screen::{Considered, Screen};
use rayon::prelude::*;

/// How many first steps are gone on from.
const FIRST_STEPS: usize = 3;

impl Search<'_> {
    /// The best second step from one of the first steps that are `likely` but do not earn
    /// their place, if both together do.
    pub(super) fn looking_ahead(
        &self,
        likely: Vec<Attempt>,
        considered: &[Considered],
    ) -> Option<Attempt> {
        if !leaves_forces(&self.current) {
            return None;
        }
        let search_price = (self.dictionary.candidates.len() as f64).ln() + MARGIN;
        let mut likely: Vec<Attempt> = likely
            .into_iter()
            .filter(|first| first.cost + search_price < self.current.cost)
            .collect();
        likely.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut seen = Vec::new();
        likely.retain(|first| {
            let is_new = !seen.contains(&first.candidates);
            seen.push(first.candidates.clone());
            is_new
        });
        likely.truncate(FIRST_STEPS);
        let limit = self.current.cost - 2.0 * search_price;
        let least = (1.0 - LEAST_REMOVED).powi(2) * self.current.estimate.unexplained;
        let second = likely.into_iter().filter_map(|first| {
            let from = Search {
                dictionary: self.dictionary,
                progress: self.progress,
                given_cost: self.given_cost,
                accepted: first.candidates.clone(),
                current: first,
                first_round: considered.to_vec(),
            };
            from.second_step()
        });
        let both = second.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let both = self.sharpened(both);
        (both.cost < limit && both.estimate.unexplained < least).then_some(both)
    }

    /// The best further term, without asking whether it earns its place.
    fn second_step(&self) -> Option<Attempt> {
        let explanation = &self.current.explanation;
        let screen = Screen::new(self.dictionary, explanation, &self.accepted).ok()?;
        let considered = screen.considered(&screen.grams());
        let leaders = leaders(&screen, &considered, self.dictionary).into_par_iter();
        let tried = leaders.map(|leader| self.attempt_in_some_shape(leader).ok());
        let tried: Vec<Option<Attempt>> = tried.collect();
        let possible = tried.into_iter().flatten().filter(|a| self.is_possible(a));
        possible.min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}
