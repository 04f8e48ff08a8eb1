//! The search for what a model lacks.
//!
//! A [hypothesis](hypothesis::Hypothesis) is a set of terms. Every one carries forces that nothing
//! explains, as large as the log demands under it, and has one score: its log evidence by
//! Laplace's method, less what its structure costs. [Moves](moves) lead from one hypothesis to
//! others; what first order promises most is fitted first, a hypothesis again only from a start that
//! should lead further, and the best is never lost. Rivals of the answer are the other hypotheses that were fitted and are as good.

mod answer;
mod beam;
mod channel;
mod discrepancy;
mod explored;
mod fit;
mod hypothesis;
mod jumps;
mod lateness;
mod moves;
mod neighbourhood;
mod placement;
mod proposal;
mod score;
mod standing;

use super::constraints::closing;
use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::progress::{Progress, Stage};
use super::selection::Selection;
use super::sensor_memory::with_memory;
use crate::machine::SolveError;
use crate::trace::settings::{SEARCHED, SEARCHED_READINGS};
pub(super) use answer::Answer;
use beam::Search;
pub(super) use channel::is_time;
pub(super) use fit::{Fitted, as_given};
pub(super) use moves::merge::is_on_a_body;
use std::sync::Arc;

/// What is searched in, and how.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// What may be missing.
    pub dictionary: &'a Dictionary,
    /// Whether what inputs do between samples is part of the answer.
    pub free_hold: bool,
    /// Whether an answer without any term says nothing that is not known: such a search ends where the part that it
    /// begins with shows none.
    pub only_with_terms: bool,
    /// Who is told how far the work is.
    pub progress: &'a dyn Progress,
}

/// A search for the terms that explain a log best. It can be asked more than once: where more terms are allowed, or
/// others were suggested, it goes on from what it has.
pub struct Inquiry<'a> {
    task: Task<'a>,
    observed: Observed,
    begun: Option<Begun<'a>>,
}

/// How far a search has come.
struct Begun<'a> {
    /// In the part of the log that it begins with, or the whole of a short one.
    search: Search<'a>,
    /// The log seen through sensors whose errors last, if they seem to under the model as given.
    lasting: Option<Observed>,
    answered: Option<Answered>,
}

/// What was answered, and when.
struct Answered {
    answer: Answer,
    /// The best hypothesis that the search had then.
    best: Arc<Fitted>,
    /// Hypotheses of so many terms were not gone on from.
    at_most: usize,
}

impl<'a> Inquiry<'a> {
    /// Into a log, of which nothing was asked yet.
    pub fn new(task: Task<'a>, observed: Observed) -> Self {
        Self {
            task,
            observed,
            begun: None,
        }
    }

    /// The log seen through sensors whose errors last, if they seem to under the model as given; known once
    /// something was asked.
    pub fn lasting(&self) -> Option<&Observed> {
        self.begun.as_ref()?.lasting.as_ref()
    }

    /// The terms that explain the log best, going on from hypotheses of fewer than `at_most` terms. What the balance
    /// of forces has `suggested`, which is cheap to ask, is fitted first.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn ask(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Answer, SolveError> {
        self.task.progress.enter(Stage::Fit, &[]);
        let part = self.part();
        let begun = match &mut self.begun {
            Some(begun) => {
                begun.search.at_most = at_most;
                begun.search.try_suggested(suggested)?;
                begun
            }
            none => {
                let searched = part.as_ref().unwrap_or(&self.observed);
                let begun = Begun::new(self.task, (&self.observed, searched), at_most, suggested)?;
                none.insert(begun)
            }
        };
        begun.search.run()?;
        let best = Arc::clone(begun.search.best());
        if let Some(known) = &begun.answered
            && Arc::ptr_eq(&known.best, &best)
            && known.answer.selection.terms.len() < known.at_most
        {
            return Ok(known.answer.clone());
        }
        let whole = part.is_some().then_some(&self.observed);
        let answer = begun.settled(self.task, whole)?;
        begun.answered = Some(Answered {
            answer: answer.clone(),
            best,
            at_most,
        });
        Ok(answer)
    }

    /// The part of the log that is searched first, if that is not the whole.
    fn part(&self) -> Option<Observed> {
        let shown = self.observed.record.sensed.as_ref();
        let shown = shown.map_or(0, |sensed| sensed.readings.len());
        (self.observed).excerpt(SEARCHED.min(SEARCHED_READINGS / shown.max(1)))
    }
}

impl<'a> Begun<'a> {
    /// Begins with the model as given in the part of a log that is searched first, and with what was suggested.
    fn new(
        task: Task<'a>,
        (whole, searched): (&Observed, &Observed),
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Self, SolveError> {
        let dictionary = task.dictionary;
        let (closing, measured) = (closing(dictionary, searched), searched.curve.clone());
        let mut search = Search::begin(task, searched, at_most)?;
        let lasting = with_memory(dictionary, search.best(), searched)?.map(|seen| {
            let mut whole = whole.clone();
            whole.err_as(&seen);
            whole
        });
        search.try_suggested(suggested)?;
        search.try_closing(closing, &measured)?;
        Ok(Self {
            search,
            lasting,
            answered: None,
        })
    }

    /// What the search says when it has settled, on the `whole` log where it began with a part.
    fn settled(&self, task: Task<'_>, whole: Option<&Observed>) -> Result<Answer, SolveError> {
        let mut search = self.search.clone();
        let mut correlation = None;
        if search.best().leaves_forces() && task.progress.ended().is_none() {
            correlation = discrepancy::correlation(task.dictionary, search.best())?;
        }
        if let Some(correlation) = &correlation {
            search = search.again(|observed| observed.correlation.clone_from(correlation))?;
            search.run()?;
        }
        let is_spent = task.only_with_terms && search.best().hypothesis.candidates().is_empty();
        if let Some(whole) = whole.filter(|_| !is_spent) {
            let mut whole = whole.clone();
            if let Some(correlation) = correlation {
                whole.correlation = correlation;
            }
            search = search.on_the_whole(&whole)?;
            search.run()?;
            search.question();
        }
        loop {
            let best = answer::determined(&search);
            let answer = answer::answer(&search, &best)?;
            let Some(nameless) = search.nameless_in(&best) else {
                return Ok(answer);
            };
            // What has no name is a force without one, and takes nothing from what is named.
            search.leave_out(nameless);
            search.left_out_nameless = true;
            let left = search.best();
            if left.hypothesis.candidates().is_empty() || standing::makes_up(&best, left) {
                return Ok(answer);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::progress::Silent;
    use crate::trace::wheel::{WHEEL, begun, named, turned, turned_for};

    /// A wheel that is half as heavy again, and is driven a little where friction would brake it: beside the
    /// inertia friction comes to nothing, and the inertia alone is found although nothing proposed it.
    #[test]
    fn what_comes_to_nothing_leaves_the_rest() {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[_, v, a]| {
            0.03 * a - 1e-5 * v
        });
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let [friction, inertia] =
            ["viscous(angle)", "parameter(i)"].map(|name| named(&dictionary, name));
        let task = Task {
            dictionary: &dictionary,
            free_hold: false,
            only_with_terms: false,
            progress: &Silent,
        };
        let mut search = Search::begin(task, &start.observed, 2).unwrap();
        let both = (vec![friction, inertia], dictionary.defaults.clone());
        let given = search.given.clone();
        search.try_first(&[both], given).unwrap();
        assert_eq!(search.best().hypothesis.candidates(), [inertia]);
    }

    /// That a wheel lacks nothing its part says already: who only wants what is found there need not look at the
    /// whole.
    #[test]
    fn a_search_for_terms_alone_ends_where_its_part_shows_none() {
        let waves = [(0.9, 3.0), (0.5, 7.0)];
        let log = turned_for(4000, waves, (5, 1e-4), |[_, _, a]| 0.02 * a);
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let rows = |only_with_terms: bool| {
            let task = Task {
                dictionary: &dictionary,
                free_hold: false,
                only_with_terms,
                progress: &Silent,
            };
            let Selection {
                terms, observed, ..
            } = {
                let mut inquiry = Inquiry::new(task, start.observed.clone());
                inquiry.ask(2, None).unwrap().selection
            };
            assert!(terms.is_empty(), "{terms:#?}");
            observed.record.len()
        };
        let whole = start.observed.record.len();
        assert_eq!([true, false].map(rows), [SEARCHED, whole]);
    }
}
