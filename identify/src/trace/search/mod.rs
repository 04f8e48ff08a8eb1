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
mod inquiry;
mod jumps;
mod lateness;
mod moves;
mod needed;
mod neighbourhood;
mod placement;
mod proposal;
mod score;
mod standing;

use super::dictionary::Dictionary;
use super::progress::Progress;
pub(super) use answer::Answer;
pub(super) use channel::is_time;
pub(super) use fit::{Fitted, as_given};
pub(super) use inquiry::{Given, Inquiry};
pub(super) use moves::merge::is_on_a_body;

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

#[cfg(test)]
mod tests {
    use super::beam::Search;
    use super::*;
    use crate::trace::progress::Silent;
    use crate::trace::wheel::{WHEEL, begun, named, turned};

    /// A wheel that is half as heavy again, and is driven a little where friction would brake it: beside the
    /// inertia friction comes to nothing and a constant force nearly so, and the inertia alone is found although
    /// nothing proposed it.
    #[test]
    fn what_is_worth_nothing_leaves_the_rest() {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[_, v, a]| {
            0.03 * a - 1e-5 * v
        });
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let task = Task {
            dictionary: &dictionary,
            free_hold: false,
            only_with_terms: false,
            progress: &Silent,
        };
        let inertia = named(&dictionary, "parameter(i)");
        for other in ["viscous(angle)", "constant_force(angle)"] {
            let mut search = Search::begin(task, &start.observed, 2).unwrap();
            let both = (
                vec![named(&dictionary, other), inertia],
                dictionary.defaults.clone(),
            );
            let given = search.given.clone();
            search.try_first(&[both], given).unwrap();
            assert_eq!(search.best().hypothesis.candidates(), [inertia], "{other}");
        }
    }
}
