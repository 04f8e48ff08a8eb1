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

/// What is searched in, and how.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// What may be missing.
    pub dictionary: &'a Dictionary,
    /// Whether what inputs do between samples is part of the answer.
    pub free_hold: bool,
    /// What the balance of forces says, which is cheap to ask: it is fitted first.
    pub suggested: Option<&'a Selection>,
    /// Hypotheses of so many terms are not gone on from.
    pub at_most: usize,
    /// Whether an answer without any term says nothing that is not known: such a search ends where the part that it
    /// begins with shows none.
    pub only_with_terms: bool,
    /// Who is told how far the work is.
    pub progress: &'a dyn Progress,
}

/// Searches for the terms that explain `observed` best.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn select(task: Task<'_>, mut observed: Observed) -> Result<Answer, SolveError> {
    let Task { dictionary, .. } = task;
    task.progress.enter(Stage::Fit, &[]);
    let shown = observed.record.sensed.as_ref();
    let shown = shown.map_or(0, |sensed| sensed.readings.len());
    let part = observed.excerpt(SEARCHED.min(SEARCHED_READINGS / shown.max(1)));
    let searched = part.as_ref().unwrap_or(&observed);
    let (closing, measured) = (closing(dictionary, searched), searched.curve.clone());
    let mut search = Search::begin(task, searched)?;
    let lasting = with_memory(dictionary, search.best(), searched)?.map(|seen| {
        let mut whole = observed.clone();
        whole.err_as(&seen);
        whole
    });
    search.try_suggested(task.suggested)?;
    search.try_closing(closing, &measured)?;
    search.run()?;
    if search.best().leaves_forces()
        && task.progress.ended().is_none()
        && let Some(correlation) = discrepancy::correlation(dictionary, search.best())?
    {
        observed.correlation.clone_from(&correlation);
        search = search.again(|observed| observed.correlation = correlation)?;
        search.run()?;
    }
    let is_spent = task.only_with_terms && search.best().hypothesis.candidates().is_empty();
    if part.is_some() && !is_spent {
        search = search.on_the_whole(&observed)?;
        search.run()?;
        search.question();
    }
    loop {
        let best = answer::determined(&search);
        let Some(nameless) = search.nameless_in(&best) else {
            return answer::answer(&search, &best, lasting);
        };
        let with_it = answer::answer(&search, &best, lasting.clone())?;
        // What has no name is a force without one, and takes nothing from what is named.
        search.leave_out(nameless);
        search.left_out_nameless = true;
        let left = search.best();
        if left.hypothesis.candidates().is_empty() || standing::makes_up(&best, left) {
            return Ok(with_it);
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
            suggested: None,
            at_most: 2,
            only_with_terms: false,
            progress: &Silent,
        };
        let mut search = Search::begin(task, &start.observed).unwrap();
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
                suggested: None,
                at_most: 2,
                only_with_terms,
                progress: &Silent,
            };
            let Selection {
                terms, observed, ..
            } = select(task, start.observed.clone()).unwrap().selection;
            assert!(terms.is_empty(), "{terms:#?}");
            observed.record.len()
        };
        let whole = start.observed.record.len();
        assert_eq!([true, false].map(rows), [SEARCHED, whole]);
    }
}
