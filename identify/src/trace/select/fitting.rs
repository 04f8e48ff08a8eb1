//! Fits of some candidates, with noise and curve.

use super::search::Attempt;
use crate::machine::SolveError;
use crate::regression::{Columns, ErrorDynamics, ProcessNoise};
use crate::trace::dictionary::Dictionary;
use crate::trace::estimate::Observed;
use crate::trace::focus::Focus;
use crate::trace::refine::{Explanation, noise, refine, refine_curve};

/// Some unexplained force to begin with.
pub(in crate::trace) fn first_noise(
    dictionary: &Dictionary,
    observed: &Observed,
) -> Result<ProcessNoise, SolveError> {
    let dynamics = linearised(&dictionary.focus(&[]), observed, &dictionary.defaults)?;
    Ok(noise(&dynamics, FIRST_SHARE))
}

pub(super) const FIRST_SHARE: f64 = 0.1;

/// The departure's equation, without columns, for `focus` with these of the dictionary's
/// values.
pub(in crate::trace) fn linearised(
    focus: &Focus,
    observed: &Observed,
    values: &[f64],
) -> Result<ErrorDynamics, SolveError> {
    let none: [Columns<'_>; 0] = [];
    ErrorDynamics::new(
        &focus.machine,
        &focus.slopes,
        &none,
        &observed.curve,
        observed.hold,
        &focus.values(values),
    )
}

/// Fits the parameters of some candidates, noise and curve.
pub(super) fn fit(
    dictionary: &Dictionary,
    candidates: &[usize],
    explanation: Explanation,
) -> Result<Attempt, SolveError> {
    fit_holding(dictionary, candidates, explanation, 0)
}

/// The same with the noise held for the first few steps.
pub(super) fn fit_holding(
    dictionary: &Dictionary,
    candidates: &[usize],
    mut explanation: Explanation,
    held: usize,
) -> Result<Attempt, SolveError> {
    let estimate = refine(dictionary, candidates, &mut explanation, held)?;
    Ok(Attempt {
        candidates: candidates.to_vec(),
        cost: estimate.cost + 0.5 * estimate.parameters.len() as f64 * (estimate.rows as f64).ln(),
        estimate,
        explanation,
    })
}

/// Moves the curve of a log to where sensors and a model agree.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub(in crate::trace) fn smooth(
    dictionary: &Dictionary,
    accepted: &[usize],
    observed: Observed,
    values: &[f64],
) -> Result<Observed, SolveError> {
    let dynamics = linearised(&dictionary.focus(accepted), &observed, values)?;
    let mut explanation = Explanation {
        noise: noise(&dynamics, FIRST_SHARE),
        values: values.to_vec(),
        observed,
    };
    refine_curve(dictionary, accepted, &mut explanation)?;
    Ok(explanation.observed)
}
