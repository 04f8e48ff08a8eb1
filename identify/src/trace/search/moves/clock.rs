//! All drives late by one time.
//!
//! Applies to several inputs where forces remain: one loop commands them, and they are built alike. One number says
//! so of all, `effect input_delay(left, right)`. Four rotors that lag by 30 ms are far from what a line says of times
//! that small, and one of them alone explains little: before that, what resembles all of them would be taken, a hull
//! whose height is late.

use super::Move;
use crate::trace::search::channel::timed_input;
use crate::trace::search::explored::Explored;
use crate::trace::search::lateness::Glance;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::MAX_TERMS;

/// All drives late by one time.
pub struct Clock;

impl Move for Clock {
    fn propose(&self, at: &Neighbourhood<'_>, explored: &Explored) -> Vec<Proposal> {
        if !at.fitted.leaves_forces() || at.terms().len() >= MAX_TERMS {
            return Vec::new();
        }
        let dictionary = at.dictionary;
        let is_clock = |&c: &usize| {
            let of_several = dictionary.candidates[c].subject.on().len() > 1;
            of_several && !at.fitted.hypothesis.contains(c) && timed_input(dictionary, c).is_some()
        };
        let clocks: Vec<usize> = (0..dictionary.candidates.len()).filter(is_clock).collect();
        if clocks.is_empty() {
            return Vec::new();
        }
        let glance = Glance::new(at);
        let radian = glance.quickest();
        let times = clocks.into_iter().flat_map(|c| glance.times(c, radian));
        glance.likely(times.collect(), explored)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::Hold;
    use crate::trace::bar::{BAR, log};
    use crate::trace::refine::Effort;
    use crate::trace::search::fit::as_given;
    use crate::trace::wheel::{begun_with, named, traced};

    #[test]
    fn two_rotors_that_lag_alike_are_proposed_at_once_and_found() {
        if left_out::too_slow() {
            return;
        }
        let channels: [&[&str]; 2] = [&["x", "phi"], &["left", "right"]];
        let (dictionary, start) = begun_with(BAR, &log([0.03, 0.03]), channels);
        let given = as_given(&dictionary, &start.observed, Hold::Previous, Effort::FULL).unwrap();
        let at = Neighbourhood::new(&dictionary, &given, &[], false).unwrap();
        let proposed = Clock.propose(&at, &Explored::default());
        let both = named(&dictionary, "input_lag(left, right)");
        let is_of_both = |proposal: &&Proposal| proposal.hypothesis.candidates() == [both];
        let proposal = proposed.iter().find(is_of_both).expect("both rotors lag");
        let lag = proposal.values[dictionary.candidates[both].parameters[0]];
        assert!((lag - 0.03).abs() < 0.01, "{lag}");

        let outcome = traced(BAR, &log([0.03, 0.03]));
        let written = "effect input_lag(left, right) { tau = ";
        assert!(outcome.patched_model.contains(written));
        let findings = outcome.findings;
        let [lag] = &findings[..] else {
            panic!("{findings:#?}");
        };
        assert_eq!(
            (lag.effect.as_str(), &lag.on[..]),
            ("input_lag", &["left".to_string(), "right".to_string()][..])
        );
        assert!(
            (lag.parameters["tau"].value - 0.03).abs() < 3e-4,
            "{lag:#?}"
        );
    }
}
