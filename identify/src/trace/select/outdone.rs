//! A term that another outdoes, once all of them are there.
//!
//! Terms are chosen one after the other. What was the best beside less may be too rich beside
//! all the others: a force with a very long wave along the way, where a constant one does.
//! And where a parameter's other value moves the machine exactly as an effect does, the log has
//! no say: the value adds nothing to the model, and is the simpler of the two.

use super::fitting::fit;
use super::search::{Attempt, Search};
use crate::trace::rivals::Alternative;
use rayon::prelude::*;

/// Nats by which another must be better.
const BETTER: f64 = 1.0;
/// Nats within which two are the same law.
const SAME: f64 = 0.1;

impl Search<'_> {
    /// The accepted terms with one replaced by that of its `alternatives` which explains the log
    /// better, after what its parameters cost; or by a parameter that explains it exactly as well.
    pub(super) fn outdone(&self, alternatives: &[Vec<Alternative>]) -> Option<Attempt> {
        let replacement = |(&term, alternatives): (&usize, &Vec<Alternative>)| {
            let better = alternatives.first().filter(|a| a.better > BETTER);
            let same = |a: &&Alternative| a.better > -SAME && self.is_parameter(a.candidate);
            let plain = || match self.is_parameter(term) {
                true => None,
                false => alternatives.iter().find(same),
            };
            let alternative = better.or_else(plain)?;
            let margin = if better.is_some() { BETTER } else { -SAME };
            Some((term, alternative.clone(), margin))
        };
        let pairs = self.accepted.iter().zip(alternatives);
        let replacements: Vec<(usize, Alternative, f64)> = pairs.filter_map(replacement).collect();
        let fitted = replacements
            .into_par_iter()
            .map(|(term, alternative, margin)| {
                let others = self.accepted.iter().copied().filter(|&t| t != term);
                let with: Vec<usize> = others.chain([alternative.candidate]).collect();
                let mut explanation = self.current.explanation.clone();
                explanation.values = alternative.values;
                let attempt = fit(self.dictionary, &with, explanation).ok()?;
                (attempt.cost + margin < self.current.cost).then_some(attempt)
            });
        let fitted: Vec<Option<Attempt>> = fitted.collect();
        let fitted = fitted.into_iter().flatten();
        fitted
            .filter(|attempt| self.is_possible(attempt))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }
}
