//! Fits of some candidates, with noise and curve.

use super::search::Attempt;
use crate::machine::SolveError;
use crate::regression::{Columns, ErrorDynamics, ProcessNoise};
use crate::trace::dictionary::Dictionary;
use crate::trace::estimate::Observed;
use crate::trace::focus::Focus;
use crate::trace::refine::{Effort, Explanation, noise, refine, refine_curve};

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
    let effort = Effort {
        held,
        ..Effort::FULL
    };
    let estimate = refine(dictionary, candidates, &mut explanation, effort)?.estimate;
    Ok(Attempt {
        candidates: candidates.to_vec(),
        cost: estimate.cost + 0.5 * estimate.parameters.len() as f64 * (estimate.rows as f64).ln(),
        estimate,
        explanation,
        sharp: false,
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

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, begun, named, rectangular};
    use super::*;
    use std::fmt::Write;

    /// A drive that gives less, and a wheel that weighs more, are one law: `g u = i a`. Neither
    /// may count as better known than the other.
    #[test]
    fn a_weak_drive_is_as_likely_as_a_heavy_wheel() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(2);
        let waves = [(0.9, 3.0), (0.5, 7.0)];
        for k in 0..2000 {
            let t = 0.004 * f64::from(k);
            let q: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let a: f64 = waves.iter().map(|(a, w)| -a * w * w * (w * t).sin()).sum();
            writeln!(text, "{t},{},{}", q + 2e-5 * noise(), 0.02 / 0.7 * a).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let [drive, wheel] = ["input_gain(motor)", "parameter(i)"].map(|name| {
            let candidates = [named(&dictionary, name)];
            let attempt = fit(&dictionary, &candidates, start.clone()).unwrap();
            fit(&dictionary, &candidates, attempt.explanation).unwrap()
        });
        let values = |attempt: &Attempt| {
            let parameters = attempt.estimate.parameters.iter();
            parameters.map(|&p| attempt.explanation.values[p]).next()
        };
        let found = [&drive, &wheel].map(|attempt| values(attempt).unwrap());
        assert!((found[0] - 0.7).abs() < 1e-3, "{found:?}");
        assert!((found[1] - 0.02 / 0.7).abs() < 1e-4, "{found:?}");
        let apart = drive.cost - wheel.cost;
        assert!(apart.abs() < 0.01, "{apart}");
    }
}
