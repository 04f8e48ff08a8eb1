//! A number for each of several places in the place of one for all.
//!
//! Applies to a term that acts on several: `effect input_lag(left, right)`. Where one drive lags by 20 ms and the other
//! by 40, one lag of both and a further one of the slower are not the same, and gains and scales would make up
//! for the rest.

use super::Move;
use crate::trace::dictionary::Dictionary;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::MAX_TERMS;
use crate::trace::subject::Subject;

/// A number for each of several places.
pub struct Apart;

impl Move for Apart {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let terms = at.terms().iter();
        terms.filter_map(|&term| apart(at, term)).collect()
    }
}

/// The hypothesis with what a term says of several said of each, and what was said of some of them beside it added.
fn apart(at: &Neighbourhood<'_>, term: usize) -> Option<Proposal> {
    let dictionary = at.dictionary;
    let members = members(dictionary, term)?;
    let known = members.iter().copied();
    let mut out: Vec<usize> = known
        .filter(|&c| at.fitted.hypothesis.contains(c))
        .collect();
    out.push(term);
    if at.terms().len() - out.len() + members.len() > MAX_TERMS {
        return None;
    }
    let found = &at.fitted.explanation.values;
    let model = &dictionary.machine.compiled.model;
    let mut proposal = at.exchanged(&out, &members, found.clone());
    for member in members {
        let all = &dictionary.candidates[term].parameters;
        let own = &dictionary.candidates[member].parameters;
        for (&of_all, &own) in all.iter().zip(own) {
            let bounds = &model.parameters[own];
            let both = found[own] + found[of_all] - dictionary.defaults[of_all];
            proposal.values[own] = both.clamp(bounds.lower, bounds.upper);
        }
    }
    Some(proposal)
}

/// The candidates that say of each place what one says of several; `None` if it is about one.
fn members(dictionary: &Dictionary, candidate: usize) -> Option<Vec<usize>> {
    let Subject::Effect { template, on } = &dictionary.candidates[candidate].subject else {
        return None;
    };
    let of_one = |place: &String| {
        let alone = Subject::Effect {
            template: template.clone(),
            on: vec![place.clone()],
        };
        let mut all = dictionary.candidates.iter();
        all.position(|candidate| candidate.subject == alone)
    };
    (on.len() > 1).then(|| on.iter().map(of_one).collect())?
}

#[cfg(test)]
mod tests {
    use crate::trace::bar::{BAR, log};
    use crate::trace::wheel::traced;

    #[test]
    fn two_rotors_that_lag_by_different_times_are_two_lags() {
        if left_out::too_slow() {
            return;
        }
        let outcome = traced(BAR, &log([0.02, 0.04]));
        let lags = outcome.findings.iter().map(|finding| {
            assert_eq!(finding.effect, "input_lag", "{finding:#?}");
            (finding.on.join(", "), finding.parameters["tau"].value)
        });
        let mut lags: Vec<(String, f64)> = lags.collect();
        lags.sort_by(|a, b| a.0.cmp(&b.0));
        let [(left, short), (right, long)] = &lags[..] else {
            panic!("{lags:?}");
        };
        assert_eq!((left.as_str(), right.as_str()), ("left", "right"));
        assert!((short - 0.02).abs() < 3e-4 && (long - 0.04).abs() < 3e-4);
    }
}
