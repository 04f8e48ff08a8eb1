//! What inputs do between samples.

use super::fitting::{first_noise, fit};
use super::search::Search;
use super::{TIE, search_samples};
use crate::machine::SolveError;
use crate::regression::Hold;
use crate::trace::dictionary::Dictionary;
use crate::trace::estimate::Observed;
use crate::trace::refine::Explanation;

/// What inputs most likely do between samples: the assumption under which the log
/// is more likely, with as much force unexplained as each demands.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn likelier_hold(dictionary: &Dictionary, observed: &Observed) -> Result<Hold, SolveError> {
    if observed.record.u.is_empty() {
        return Ok(Hold::Linear);
    }
    let part = observed.excerpt(search_samples(dictionary));
    let observed = part.as_ref().unwrap_or(observed);
    let cost = |hold: Hold| -> Result<f64, SolveError> {
        let observed = Observed {
            hold,
            ..observed.clone()
        };
        let explanation = Explanation {
            noise: first_noise(dictionary, &observed)?,
            values: dictionary.defaults.clone(),
            observed,
        };
        Ok(fit(dictionary, &[], explanation)?.cost)
    };
    let (linear, previous) = (cost(Hold::Linear)?, cost(Hold::Previous)?);
    Ok(if previous < linear - TIE {
        Hold::Previous
    } else {
        Hold::Linear
    })
}

impl Search<'_> {
    /// Takes the other assumption about inputs if the log is more likely under it.
    pub(super) fn ask_about_hold(&mut self) {
        if self.current.explanation.observed.record.u.is_empty() {
            return;
        }
        let mut explanation = self.current.explanation.clone();
        explanation.observed.hold = match explanation.observed.hold {
            Hold::Linear => Hold::Previous,
            Hold::Previous => Hold::Linear,
        };
        // An assumption under which the machine cannot move is none.
        let Ok(other) = fit(self.dictionary, &self.accepted, explanation) else {
            return;
        };
        let other = self.sharpened(other);
        // In doubt inputs are as they are drawn: straight from sample to sample. To stay,
        // and to be later by half a sample, is nearly the same.
        let margin = match other.explanation.observed.hold {
            Hold::Linear => TIE,
            Hold::Previous => -TIE,
        };
        if other.cost < self.current.cost + margin {
            self.current = other;
        }
    }
}
