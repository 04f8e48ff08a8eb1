//! A term that another outdoes, once all of them are there.
//!
//! Terms are chosen one after the other. What was the best beside less may be too rich beside
//! all the others: a force with a very long wave along the way, where a constant one does.

use super::fitting::fit;
use super::search::{Attempt, Search};
use crate::trace::rivals::Alternative;
use rayon::prelude::*;

/// Nats by which another must be better.
const BETTER: f64 = 1.0;

impl Search<'_> {
    /// The accepted terms with one replaced by that of its `alternatives` which explains the log
    /// better, after what its parameters cost.
    pub(super) fn outdone(&self, alternatives: &[Vec<Alternative>]) -> Option<Attempt> {
        let best = |(&term, alternatives): (&usize, &Vec<Alternative>)| {
            let alternative = alternatives.first()?;
            (alternative.better > BETTER).then_some((term, alternative.clone()))
        };
        let pairs = self.accepted.iter().zip(alternatives);
        let pairs: Vec<(usize, Alternative)> = pairs.filter_map(best).collect();
        let fitted = pairs.into_par_iter().map(|(term, alternative)| {
            let others = self.accepted.iter().copied().filter(|&t| t != term);
            let with: Vec<usize> = others.chain([alternative.candidate]).collect();
            let mut explanation = self.current.explanation.clone();
            explanation.values = alternative.values;
            fit(self.dictionary, &with, explanation).ok()
        });
        let fitted: Vec<Option<Attempt>> = fitted.collect();
        let better = |attempt: &Attempt| attempt.cost + BETTER < self.current.cost;
        let fitted = fitted.into_iter().flatten();
        fitted
            .filter(|attempt| better(attempt) && self.is_possible(attempt))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}
