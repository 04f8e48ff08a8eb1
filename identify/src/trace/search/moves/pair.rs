//! Two more terms at once.
//!
//! Applies where forces remain beside any single one: taken one after the other, the first might
//! be something that resembles both. A motor that ignores small torques hides the friction behind
//! it.

use super::Move;
use crate::trace::screen::{Considered, Pair as Both};
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::{MARGIN, MAX_TERMS, PAIRED, PROFILED, SHORTLISTED};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Two more terms at once.
pub struct Pair;

impl Move for Pair {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        if at.terms().len() + 2 > MAX_TERMS {
            return Vec::new();
        }
        let likely = at.considered.iter().filter(|c| c.score > MARGIN);
        let singles: Vec<&Considered> = likely
            .take(PAIRED)
            .flat_map(|c| std::iter::once(c).chain(&c.other_shapes))
            .collect();
        let mut pairs = at.screen.pairs(&singles);
        let candidates = |pair: &Both| pair.members.each_ref().map(|c| c.candidate);
        pairs.retain(|pair| !at.dictionary.nested.doubles(&candidates(pair)));
        // Each pair in its best shapes.
        let mut seen = BTreeSet::new();
        pairs.retain(|pair| seen.insert(candidates(pair)));
        pairs.truncate(PROFILED);
        let rows = at.fitted.estimate.rows as f64;
        let size = |c: &Considered| at.dictionary.candidates[c.candidate].size() as f64;
        let profiled = pairs.into_par_iter().map(|pair| {
            let [a, b] = &pair.members;
            let price = 0.5 * (size(a) + size(b)) * rows.ln();
            (at.screen.profile(&[a, b]) + price, pair)
        });
        let mut profiled: Vec<(f64, Both)> = profiled.collect();
        profiled.sort_by(|a, b| a.0.total_cmp(&b.0));
        profiled.truncate(SHORTLISTED);
        let each = profiled.iter();
        each.map(
            |(
                cost,
                Both {
                    members: [a, b], ..
                },
            )| at.addition(&[a, b], *cost),
        )
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::trace::wheel::{WHEEL, traced, turned};

    /// A motor that ignores 0.1 N·m, and friction of 0.05 N·m in the wheel's bearing.
    fn log() -> String {
        turned([(0.9, 3.0), (0.5, 7.0)], (11, 2e-4), |[_, v, a]| {
            let force = 0.02 * a + 0.05 * (v / 0.02).tanh();
            force + 0.1 * force.signum()
        })
    }

    #[test]
    fn friction_is_found_behind_a_dead_band() {
        let findings = traced(WHEEL, &log()).findings;
        let mut names: Vec<&str> = findings.iter().map(|f| f.effect.as_str()).collect();
        names.sort_unstable();
        assert_eq!(names, ["coulomb", "dead_band"], "{findings:#?}");
        let band = findings.iter().find(|f| f.effect == "dead_band");
        let width = &band.unwrap().parameters["w"];
        assert!((width.value - 0.1).abs() < 2e-3, "{width:?}");
    }
}
