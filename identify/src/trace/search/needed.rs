//! Whether a hypothesis needs each of its terms.

use super::beam::Search;
use super::fit::{Fitted, bar, fit_with};
use super::proposal::Proposal;
use super::score::structure;
use crate::trace::finding::{is_without_its_mark, worth};
use crate::trace::refine::Effort;
use crate::trace::settings::{MARGIN, SAME_FIT, SHARP_STEPS};
use std::sync::Arc;

impl Search<'_> {
    /// Leaves each term of the best hypothesis out, until none of them is one too many.
    pub fn question(&mut self) {
        loop {
            let best = Arc::clone(self.best());
            if self.is_over() || best.hypothesis.candidates().is_empty() {
                return;
            }
            let terms = best.hypothesis.candidates().iter();
            let without = terms.map(|&term| self.without(&best, term));
            self.try_all(&best, without.collect());
            if self.best().hypothesis == best.hypothesis {
                return;
            }
        }
    }

    /// Leaves out terms of the best hypothesis that are worth less than they cost, to second order, as long as it is
    /// better without one of them.
    pub fn lighten(&mut self) {
        loop {
            let best = Arc::clone(self.best());
            let (values, known) = (&best.explanation.values, best.estimate.known());
            let price = structure(self.dictionary, &best.hypothesis);
            let is_light = |&&term: &&usize| {
                let others = structure(self.dictionary, &best.hypothesis.exchange(&[term], &[]));
                worth(self.dictionary, term, values, known) < price - others
            };
            let light = best.hypothesis.candidates().iter().filter(is_light);
            let without: Vec<Proposal> = light.map(|&term| self.without(&best, term)).collect();
            if self.is_over() || without.is_empty() {
                return;
            }
            self.try_all(&best, without);
            if self.best().hypothesis == best.hypothesis {
                return;
            }
        }
    }

    /// Leaves a term out, and what the log does not show without. What was not found beside it, and is
    /// now, would only stand for it.
    pub fn leave_out(&mut self, term: usize) {
        let best = Arc::clone(self.best());
        let others = best.hypothesis.exchange(&[term], &[]);
        self.explored.keep_within(&others);
        for given in &self.given {
            self.explored.replace(self.dictionary, Arc::clone(given));
        }
        self.try_all(&best, vec![self.without(&best, term)]);
        self.question();
    }

    /// Fits special cases of the best hypothesis's laws from where these laws have led, unless they came as far by
    /// themselves: fits of one law by two names do not rest at the same distance from where both would end. As little
    /// as the law leaves unexplained they leave at first, too.
    pub fn name_plainly(&mut self) {
        let best = Arc::clone(self.best());
        let dictionary = self.dictionary;
        let terms = best.hypothesis.candidates().iter();
        let special_cases = terms.flat_map(|&term| {
            let special_cases = dictionary.nested.special_cases(term);
            special_cases.map(move |special| (term, special))
        });
        for (term, special) in special_cases {
            let hypothesis = best.hypothesis.exchange(&[term], &[special]);
            let Some(known) = self.explored.of(&hypothesis) else {
                continue;
            };
            let is_as_far = known.cost < best.estimate.cost + SAME_FIT;
            if is_as_far || known.values.is_empty() || self.is_over() {
                continue;
            }
            let mut start = best.explanation.clone();
            start.values = dictionary.without(&[term], &start.values);
            for &parameter in &dictionary.candidates[special].parameters {
                start.values[parameter] = known.values[parameter];
            }
            let effort = Effort {
                held: SHARP_STEPS,
                bar: bar(best.score, structure(dictionary, &hypothesis)),
                ..Effort::FULL
            };
            if let Ok(fitted) = fit_with(dictionary, &hypothesis, start, effort) {
                self.explored.add(dictionary, Arc::new(fitted));
            }
        }
    }

    /// A term of a hypothesis that has lost what gives it its name, beside others.
    pub fn nameless_in(&self, fitted: &Fitted) -> Option<usize> {
        let terms = fitted.hypothesis.candidates();
        let (values, known) = (&fitted.explanation.values, fitted.estimate.known());
        let is_nameless =
            |&&term: &&usize| is_without_its_mark(self.dictionary, term, values, known);
        let nameless = terms.iter().find(is_nameless).copied();
        nameless.filter(|_| terms.len() > 1 && !self.is_over())
    }

    /// A hypothesis without one of its terms, to be fitted in any case.
    fn without(&self, of: &Fitted, term: usize) -> Proposal {
        Proposal {
            hypothesis: of.hypothesis.exchange(&[term], &[]),
            values: self.dictionary.without(&[term], &of.explanation.values),
            promise: 0.0,
            within_reach: f64::NEG_INFINITY,
            ahead: 0.0,
        }
    }

    /// A hypothesis without the term that the log says least of, if that is nothing, where it may be better than the
    /// best one so and was not tried.
    pub fn without_the_worthless(&self, fitted: &Fitted) -> Option<Proposal> {
        let dictionary = self.dictionary;
        let (values, known) = (&fitted.explanation.values, fitted.estimate.known());
        let each = fitted.hypothesis.candidates().iter();
        let each = each.map(|&term| (worth(dictionary, term, values, known), term));
        let (worth, term) = each.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let alone = fitted.hypothesis.exchange(&[term], &[]);
        let price = structure(dictionary, &fitted.hypothesis) - structure(dictionary, &alone);
        let is_promising = fitted.score + worth - price < self.best().score;
        let is_new = self.explored.of(&alone).is_none();
        (worth <= MARGIN && is_promising && is_new).then(|| self.without(fitted, term))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::progress::Silent;
    use crate::trace::search::Task;
    use crate::trace::search::fit::fit;
    use crate::trace::search::hypothesis::Hypothesis;
    use crate::trace::wheel::{WHEEL, begun, named, turned};

    /// Dry friction whose fit was given up early, beside the same by the name of a law with two sides, which went on.
    #[test]
    fn a_law_that_is_a_special_case_is_called_by_that() {
        let waves = [(0.9, 3.0), (0.5, 7.0)];
        let log = turned(waves, (3, 1e-4), |[_, v, a]| {
            0.02 * a + 0.05 * (v / 0.03).tanh()
        });
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let task = Task {
            dictionary: &dictionary,
            free_hold: false,
            only_with_terms: false,
            progress: &Silent,
        };
        let mut search = Search::begin(task, &start.observed, 2).unwrap();
        let fitted = |name: &str, size: f64| {
            let term = named(&dictionary, name);
            let hypothesis = Hypothesis::nothing(start.observed.hold).exchange(&[], &[term]);
            let mut start = start.clone();
            for &strength in &dictionary.candidates[term].strengths {
                start.values[strength] = size;
            }
            fit(&dictionary, &hypothesis, start).unwrap()
        };
        let mut early = fitted("coulomb(angle)", 0.04);
        early.score += 40.0;
        early.estimate.cost += 40.0;
        let plain = early.hypothesis.clone();
        for fitted in [early, fitted("asymmetric_coulomb(angle)", 0.04)] {
            search.explored.add(&dictionary, Arc::new(fitted));
        }
        assert_ne!(search.best().hypothesis, plain);
        search.name_plainly();
        assert_eq!(search.best().hypothesis, plain);
    }
}
