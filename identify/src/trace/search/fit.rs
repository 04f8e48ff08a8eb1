//! Fits of hypotheses: parameters, noise and motion together, from more than one start where the
//! first may rest too early.

use super::hypothesis::Hypothesis;
use super::jumps::beside_jumps;
use super::score::{evidence, prior};
use crate::machine::SolveError;
use crate::regression::{Hold, ProcessNoise};
use crate::trace::dictionary::Dictionary;
use crate::trace::estimate::Observed;
use crate::trace::linearised::first_noise;
use crate::trace::refine::{Effort, Estimate, Explanation, refine};
use crate::trace::settings::{SAME_FIT, SHARP_STEPS, SHARPER, TIE};
use rayon::prelude::*;

/// A hypothesis after its fit.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Which one.
    pub hypothesis: Hypothesis,
    /// How believable it is, nats, the less the better.
    pub score: f64,
    /// What of that is believed before the log is read, nats.
    pub prior: f64,
    /// Its parameters' estimates.
    pub estimate: Estimate,
    /// Whether the fit ended where no step makes the log likelier.
    pub has_arrived: bool,
    /// Its values, the motion that goes with them, and what they leave unexplained.
    pub explanation: Explanation,
}

impl Fitted {
    /// Whether more than sensor noise remains.
    pub fn leaves_forces(&self) -> bool {
        self.estimate.leaves_forces()
    }

    /// This fit of the model as given for another search in the same log, whose `dictionary` has other parameters, which
    /// stay at their defaults.
    pub fn shared_with(&self, dictionary: &Dictionary) -> Self {
        let mut shared = self.clone();
        shared.explanation.values.clone_from(&dictionary.defaults);
        shared
    }

    /// Whether each of its terms does something, within what is possible.
    pub fn is_possible(&self, dictionary: &Dictionary) -> bool {
        let model = &dictionary.machine.compiled.model;
        let values = &self.explanation.values;
        self.hypothesis.candidates().iter().all(|&term| {
            let inside = |&p: &usize| {
                let (value, parameter) = (values[p], &model.parameters[p]);
                value != dictionary.defaults[p]
                    && value > parameter.lower
                    && value < parameter.upper
            };
            dictionary.candidates[term].strengths.iter().any(inside)
        })
    }
}

/// The model as given, fitted to a log with some effort.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn as_given(
    dictionary: &Dictionary,
    observed: &Observed,
    hold: Hold,
    effort: Effort,
) -> Result<Fitted, SolveError> {
    let noise = first_noise(&dictionary.focus(&[]), observed, &dictionary.defaults)?;
    given_with(dictionary, observed, (hold, effort), &noise)
}

/// The same begun with some noise, which says the least that there is.
///
/// # Errors
/// As of [`as_given`].
pub fn given_with(
    dictionary: &Dictionary,
    observed: &Observed,
    (hold, effort): (Hold, Effort),
    noise: &ProcessNoise,
) -> Result<Fitted, SolveError> {
    let starts = [noise.at_smallest_jitter(), noise.at_smallest()];
    let fitted = starts.into_par_iter().map(|noise| {
        let start = Explanation {
            noise,
            values: dictionary.defaults.clone(),
            observed: observed.clone(),
        };
        fit_with(dictionary, &Hypothesis::nothing(hold), start, effort)
    });
    let [lasting, white]: [_; 2] = fitted.collect::<Vec<_>>().try_into().expect("two");
    let lasting = lasting?;
    Ok(match white {
        Ok(white) if white.score < lasting.score => white,
        _ => lasting,
    })
}

/// Fits a hypothesis from some start.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn fit(
    dictionary: &Dictionary,
    hypothesis: &Hypothesis,
    start: Explanation,
) -> Result<Fitted, SolveError> {
    fit_with(dictionary, hypothesis, start, Effort::FULL)
}

/// The same with less than all effort.
///
/// # Errors
/// As of [`fit`].
pub fn fit_with(
    dictionary: &Dictionary,
    hypothesis: &Hypothesis,
    start: Explanation,
    effort: Effort,
) -> Result<Fitted, SolveError> {
    let fitted = fit_from(dictionary, hypothesis, start, effort)?;
    Ok(match fitted.estimate.cost < effort.enough {
        true => fitted,
        false => or_beside_jumps(dictionary, fitted, effort),
    })
}

/// Fits a hypothesis from one start alone.
fn fit_from(
    dictionary: &Dictionary,
    hypothesis: &Hypothesis,
    mut explanation: Explanation,
    effort: Effort,
) -> Result<Fitted, SolveError> {
    explanation.observed.hold = hypothesis.hold;
    let candidates = hypothesis.candidates();
    let refined = refine(dictionary, candidates, &mut explanation, effort)?;
    let prior = prior(dictionary, hypothesis, &explanation);
    Ok(Fitted {
        score: prior + evidence(dictionary, &explanation, &refined),
        prior,
        hypothesis: hypothesis.clone(),
        has_arrived: refined.has_arrived,
        estimate: refined.estimate,
        explanation,
    })
}

/// A fit, or one that begins beside a jump and makes the log likelier.
fn or_beside_jumps(dictionary: &Dictionary, fitted: Fitted, effort: Effort) -> Fitted {
    let others = beside_jumps(dictionary, &fitted.hypothesis, &fitted.explanation);
    let effort = Effort {
        bar: effort.bar.min(fitted.estimate.cost),
        ..effort
    };
    let others = others.into_par_iter().filter_map(|start| {
        let other = fit_from(dictionary, &fitted.hypothesis, start, effort);
        other.ok()
    });
    let others: Vec<Fitted> = others.collect();
    others.into_iter().fold(fitted, |best, other| {
        match other.estimate.cost < best.estimate.cost {
            true => other,
            false => best,
        }
    })
}

/// The hypothesis fitted on where it had not arrived, and from less unexplained force: as long as much counts as
/// unexplained, a fit may rest too early, and hides what lies beside a jump. What cannot come below a cost is given up.
pub fn sharpened(dictionary: &Dictionary, fitted: Fitted, bar: f64) -> Fitted {
    let effort = Effort {
        bar,
        ..Effort::FULL
    };
    let begun = fitted.score;
    let mut fitted = fitted;
    while fitted.leaves_forces() {
        let mut sharper = fitted.explanation.clone();
        sharper.noise = sharper.noise.times(SHARPER);
        let mut starts = vec![(sharper, SHARP_STEPS)];
        if !fitted.has_arrived {
            starts.insert(0, (fitted.explanation.clone(), 0));
        }
        let again = starts.into_par_iter().map(|(start, held)| {
            let effort = Effort { held, ..effort };
            fit_from(dictionary, &fitted.hypothesis, start, effort).ok()
        });
        let again: Vec<Option<Fitted>> = again.collect();
        let best = again.into_iter().flatten().min_by(by_score);
        let Some(best) = best.filter(|best| best.score < fitted.score - SAME_FIT) else {
            break;
        };
        let gained = fitted.score - best.score;
        fitted = best;
        if effort.is_hopeless(fitted.estimate.cost, gained) {
            return fitted;
        }
    }
    match fitted.score < begun {
        true => or_beside_jumps(dictionary, fitted, effort),
        false => fitted,
    }
}

/// The cost that a hypothesis must come below to matter beside one of a known score.
pub fn bar(best: f64, structure: f64) -> f64 {
    best + TIE - structure
}

/// The best first.
pub fn by_score(a: &Fitted, b: &Fitted) -> std::cmp::Ordering {
    a.score.total_cmp(&b.score)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::wheel::{WHEEL, begun, named, rectangular};
    use std::fmt::Write;

    /// A wheel whose drive gives 0.7 of what it is told.
    fn weakly_driven() -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(2);
        let waves = [(0.9, 3.0), (0.5, 7.0)];
        for k in 0..2000 {
            let t = 0.004 * f64::from(k);
            let q: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let a: f64 = waves.iter().map(|(a, w)| -a * w * w * (w * t).sin()).sum();
            writeln!(text, "{t},{},{}", q + 2e-5 * noise(), 0.02 / 0.7 * a).unwrap();
        }
        text
    }

    /// From the place where it begins, if that will do.
    #[test]
    fn a_fit_that_is_good_enough_goes_no_further() {
        let (dictionary, start) = begun(WHEEL, &weakly_driven(), ["angle", "motor"]);
        let drive = Hypothesis::nothing(Hold::Linear);
        let drive = drive.exchange(&[], &[named(&dictionary, "input_gain(motor)")]);
        let gain = |enough: f64| {
            let effort = Effort {
                enough,
                ..Effort::FULL
            };
            let fitted = fit_with(&dictionary, &drive, start.clone(), effort).unwrap();
            let gain = fitted.explanation.values[fitted.estimate.parameters[0]];
            (gain, fitted.has_arrived)
        };
        assert_eq!(gain(f64::INFINITY), (1.0, false));
        let (gain, has_arrived) = gain(Effort::FULL.enough);
        assert!((gain - 0.7).abs() < 1e-3 && has_arrived);
    }

    /// A drive that gives less, and a wheel that weighs more, are one law: `g u = i a`. Neither
    /// may count as better known than the other.
    #[test]
    fn a_weak_drive_is_as_likely_as_a_heavy_wheel() {
        let (dictionary, start) = begun(WHEEL, &weakly_driven(), ["angle", "motor"]);
        let nothing = Hypothesis::nothing(Hold::Linear);
        let [drive, wheel] = ["input_gain(motor)", "parameter(i)"].map(|name| {
            let hypothesis = nothing.exchange(&[], &[named(&dictionary, name)]);
            let fitted = fit(&dictionary, &hypothesis, start.clone()).unwrap();
            fit(&dictionary, &hypothesis, fitted.explanation).unwrap()
        });
        let value = |fitted: &Fitted| fitted.explanation.values[fitted.estimate.parameters[0]];
        assert!((value(&drive) - 0.7).abs() < 1e-3, "{}", value(&drive));
        assert!(
            (value(&wheel) - 0.02 / 0.7).abs() < 1e-4,
            "{}",
            value(&wheel)
        );
        let apart = drive.estimate.cost - wheel.estimate.cost;
        assert!(apart.abs() < 0.01, "{apart}");
        // The value adds nothing to the model.
        assert!(wheel.score < drive.score);
    }
}
