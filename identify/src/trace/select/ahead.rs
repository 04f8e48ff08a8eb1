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

#[cfg(test)]
mod tests {
    use super::super::fitting::fit;
    use super::super::wheel::{WHEEL, begun, named, rectangular};
    use super::*;
    use crate::trace::Silent;
    use std::fmt::Write;

    /// A motor that ignores 0.1 N·m, and friction of 0.05 N·m in the wheel's bearing.
    fn log() -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(11);
        let waves = [(0.9, 3.0), (0.5, 7.0)];
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let sum = |f: fn(f64, f64, f64) -> f64| -> f64 {
                waves.iter().map(|&(a, w)| f(a, w, t)).sum()
            };
            let q = sum(|a, w, t| a * (w * t).sin());
            let v = sum(|a, w, t| a * w * (w * t).cos());
            let a = sum(|a, w, t| -a * w * w * (w * t).sin());
            let force = 0.02 * a + 0.05 * (v / 0.02).tanh();
            let u = force + 0.1 * force.signum();
            writeln!(text, "{t},{},{u}", q + 2e-4 * noise()).unwrap();
        }
        text
    }

    #[test]
    fn friction_is_found_behind_a_dead_band() {
        let (dictionary, start) = begun(WHEEL, &log(), ["angle", "motor"]);
        let [band, friction] =
            ["dead_band(motor)", "coulomb(angle)"].map(|name| named(&dictionary, name));
        let current = fit(&dictionary, &[], start).unwrap();
        let search = Search {
            dictionary: &dictionary,
            progress: &Silent,
            accepted: Vec::new(),
            first_round: Vec::new(),
            given_cost: current.cost,
            current,
        };
        let screen = Screen::new(&dictionary, &search.current.explanation, &[]).unwrap();
        let considered = screen.considered(&screen.grams());
        assert!(search.looking_ahead(Vec::new(), &considered).is_none());
        let first = considered.iter().find(|c| c.candidate == band).unwrap();
        let likely = vec![search.attempt(&[first]).unwrap()];
        let both = search.looking_ahead(likely, &considered).unwrap();
        assert_eq!(both.candidates, [band, friction]);
        let widths = &dictionary.candidates[band].parameters;
        let width = both.explanation.values[widths[0]];
        assert!((width - 0.1).abs() < 2e-3, "{width}");
    }
}
