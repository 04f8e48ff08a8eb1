//! Kin: effects that say the same number of the same place in another way.
//!
//! A late drive and a slow one differ little at first, and each looks like the other until its
//! time is about right. Where one has found its time, the other begins there.

use super::fitting::fit;
use super::search::{Attempt, Search, reset};
use rayon::prelude::*;

impl Search<'_> {
    /// The attempt with one of `terms` replaced by one of its kin, if that explains the log
    /// better.
    pub(super) fn with_kin(&self, attempt: &Attempt, terms: &[usize]) -> Option<Attempt> {
        let pairs: Vec<(usize, usize)> = terms
            .iter()
            .flat_map(|&term| self.kin(term).map(move |kin| (term, kin)))
            .filter(|(_, kin)| !attempt.candidates.contains(kin))
            .collect();
        let tried = pairs.into_par_iter().map(|(term, kin)| {
            let mut explanation = attempt.explanation.clone();
            let [own, theirs] = [kin, term].map(|c| self.dictionary.candidates[c].parameters[0]);
            explanation.values[own] = attempt.explanation.values[theirs];
            reset(self.dictionary, &mut explanation, term);
            let others = attempt.candidates.iter().copied().filter(|&c| c != term);
            let candidates: Vec<usize> = others.chain([kin]).collect();
            Some(self.sharpened(fit(self.dictionary, &candidates, explanation).ok()?))
        });
        let tried: Vec<Option<Attempt>> = tried.collect();
        tried
            .into_iter()
            .flatten()
            .filter(|kin| kin.cost < attempt.cost && self.is_possible(kin))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// The channel effects at the place of `term` with one parameter of the same unit.
    fn kin(&self, term: usize) -> impl Iterator<Item = usize> {
        let candidates = &self.dictionary.candidates;
        let parameters = &self.dictionary.machine.compiled.model.parameters;
        let own = &candidates[term];
        (0..candidates.len()).filter(move |&other| {
            let theirs = &candidates[other];
            let [ours, theirs_unit] = [own, theirs].map(|c| match c.parameters[..] {
                [only] => parameters[only].dimension,
                _ => None,
            });
            other != term
                && own.channel
                && theirs.channel
                && ours.is_some()
                && ours == theirs_unit
                && own.subject.on() == theirs.subject.on()
        })
    }
}
