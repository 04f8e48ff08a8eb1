//! Other places to begin where an accelerometer feels the jumps of a late input.
//!
//! An input that stays at its value and is late by `τ` jumps at whole samples: what an accelerometer reads
//! at a sample is of one value for all `τ` within a sample, and of the next one beyond. No slope says so,
//! and forces that nothing explains make up for a value that is off by one: a fit may end in the wrong
//! sample, or beside the jump between two. What lags has a state, which makes jumps smooth.

use super::channel::timed_input;
use super::hypothesis::Hypothesis;
use crate::log::median_step;
use crate::regression::Hold;
use crate::trace::dictionary::Dictionary;
use crate::trace::refine::Explanation;
use crate::trace::remembered::remembers;
use crate::trace::settings::LATER;

/// The end of a fit, each time with one of its delays moved by [`LATER`]; none where nothing feels jumps.
pub fn beside_jumps(
    dictionary: &Dictionary,
    hypothesis: &Hypothesis,
    found: &Explanation,
) -> Vec<Explanation> {
    let record = &found.observed.record;
    let feels_jumps = record.ddq.iter().any(Option::is_some) || !record.readings().is_empty();
    if hypothesis.hold != Hold::Previous || !feels_jumps {
        return Vec::new();
    }
    let step = median_step(&record.t);
    let bounds = &dictionary.machine.compiled.model.parameters;
    let moved = |parameter: usize| {
        let times = LATER.map(|samples| found.values[parameter] + samples * step);
        let is_possible =
            move |time: &f64| (bounds[parameter].lower..=bounds[parameter].upper).contains(time);
        times.into_iter().filter(is_possible).map(move |time| {
            let mut there = found.clone();
            there.values[parameter] = time;
            there
        })
    };
    let terms = hypothesis.candidates().iter();
    let jumping = terms.filter(|&&term| !remembers(dictionary, term));
    let delays = jumping.filter_map(|&term| timed_input(dictionary, term));
    delays.flat_map(moved).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::wheel::{WHEEL, begun, named, turned_for};

    /// A wheel with an accelerometer, whose torque stays at its value from sample to sample.
    #[test]
    fn what_lags_does_not_jump() {
        let log = turned_for(400, [(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[_, _, a]| {
            0.02 * a
        });
        let (dictionary, mut start) = begun(WHEEL, &log, ["angle", "motor"]);
        let record = &mut start.observed.record;
        record.ddq[0] = Some(vec![0.0; record.t.len()]);
        let starts = |name: &str, hold: Hold| {
            let term = named(&dictionary, name);
            let mut found = start.clone();
            found.values[dictionary.candidates[term].parameters[0]] = 0.008;
            let hypothesis = Hypothesis::nothing(hold).exchange(&[], &[term]);
            beside_jumps(&dictionary, &hypothesis, &found).len()
        };
        assert_eq!(starts("input_delay(motor)", Hold::Previous), LATER.len());
        assert_eq!(starts("input_delay(motor)", Hold::Linear), 0);
        assert_eq!(starts("input_lag(motor)", Hold::Previous), 0);
    }
}
