//! The departure from a logged curve, to first order, and the curve that suits a model.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::focus::Focus;
use super::refine::{Explanation, refine_curve};
use super::settle::noise;
use crate::machine::SolveError;
use crate::regression::{ErrorDynamics, ProcessNoise};

/// Some unexplained force to begin with.
pub(super) fn first_noise(
    focus: &Focus,
    observed: &Observed,
    values: &[f64],
) -> Result<ProcessNoise, SolveError> {
    let dynamics = linearised(focus, observed, values)?;
    let mut noise = noise(&dynamics, FIRST_SHARE);
    observed.bear_inputs(&mut noise, &focus.machine, &focus.values(values))?;
    Ok(noise)
}

/// Share of the machine's forces that nothing explains, to begin with.
const FIRST_SHARE: f64 = 0.1;

/// The departure's equation, without columns, for `focus` with these of the dictionary's
/// values.
pub(super) fn linearised(
    focus: &Focus,
    observed: &Observed,
    values: &[f64],
) -> Result<ErrorDynamics, SolveError> {
    let parameters = focus.values(values);
    let mover = focus.mover(observed, &parameters);
    let (curve, hold) = (&observed.curve, observed.hold);
    ErrorDynamics::new(mover, &[], curve, hold, &observed.correlation)
}

/// A log under a model: its curve moved to where sensors and model agree, beside forces without a name
/// as large as it says.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub(super) fn smooth(
    dictionary: &Dictionary,
    accepted: &[usize],
    observed: Observed,
    values: &[f64],
) -> Result<Explanation, SolveError> {
    let mut explanation = Explanation {
        noise: first_noise(&dictionary.focus(accepted), &observed, values)?,
        values: values.to_vec(),
        observed,
    };
    refine_curve(dictionary, accepted, &mut explanation)?;
    Ok(explanation)
}
