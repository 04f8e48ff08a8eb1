//! Whether terms, and fits, stand on their own.

use super::fit::Fitted;
use super::hypothesis::Hypothesis;
use crate::trace::dictionary::Dictionary;
use crate::trace::settings::SAME_VALUE;

/// Whether what is left of a hypothesis without a term makes up for it: then its values are no longer what
/// they were beside it.
pub fn makes_up(before: &Fitted, left: &Fitted) -> bool {
    let known = |fitted: &Fitted, parameter: usize| {
        let (parameters, covariance) = fitted.estimate.known();
        let place = parameters.iter().position(|&p| p == parameter)?;
        Some((
            fitted.explanation.values[parameter],
            covariance[(place, place)],
        ))
    };
    left.estimate.parameters.iter().any(|&parameter| {
        let pair = known(before, parameter).zip(known(left, parameter));
        pair.is_some_and(|((before, one), (left, other))| {
            // What the log does not determine has no variance.
            one > 0.0 && other > 0.0 && (left - before).powi(2) > SAME_VALUE.powi(2) * (one + other)
        })
    })
}

/// Whether a fit is less likely than one with a special case in place of one of its laws: then it rests in a bad
/// place, whatever it gains. `cost` is the negative log likelihood of what was fitted, nats, and infinite of all else.
pub fn is_outdone(
    dictionary: &Dictionary,
    fitted: &Fitted,
    cost: impl Fn(&Hypothesis) -> f64,
) -> bool {
    let hypothesis = &fitted.hypothesis;
    let mut special = hypothesis.candidates().iter().flat_map(|&term| {
        let cases = dictionary.nested.special_cases(term);
        cases.map(move |case| hypothesis.exchange(&[term], &[case]))
    });
    special.any(|special| cost(&special) < fitted.estimate.cost)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::Hold;
    use crate::trace::search::fit::fit;
    use crate::trace::search::hypothesis::Hypothesis;
    use crate::trace::wheel::{WHEEL, begun, named, turned};

    /// Whether the inertia of a wheel that is half as heavy again makes up for an effect that is left
    /// out.
    fn inertia_makes_up(effect: &str, torque: impl Fn([f64; 3]) -> f64) -> bool {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), torque);
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let nothing = Hypothesis::nothing(Hold::Linear);
        let heavier = nothing.exchange(&[], &[named(&dictionary, "parameter(i)")]);
        let both = heavier.exchange(&[], &[named(&dictionary, effect)]);
        let [both, heavier] =
            [both, heavier].map(|one| fit(&dictionary, &one, start.clone()).unwrap());
        makes_up(&both, &heavier)
    }

    #[test]
    fn an_inertia_makes_up_for_a_spring_and_not_for_a_steady_load() {
        let sprung = |[q, _, a]: [f64; 3]| 0.03 * a + 0.15 * q;
        assert!(inertia_makes_up("spring(angle)", sprung));
        let loaded = |[_, _, a]: [f64; 3]| 0.03 * a + 0.05;
        assert!(!inertia_makes_up("constant_force(angle)", loaded));
    }

    /// Stribeck's friction can do what Coulomb's does: where it explains less, its fit has not arrived.
    #[test]
    fn a_law_behind_a_special_case_of_it_is_outdone() {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[_, v, a]| {
            0.02 * a + 0.05 * (v / 0.1).tanh()
        });
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let nothing = Hypothesis::nothing(Hold::Linear);
        let [plain, rich] = ["coulomb(angle)", "stribeck(angle)"].map(|name| {
            let hypothesis = nothing.exchange(&[], &[named(&dictionary, name)]);
            fit(&dictionary, &hypothesis, start.clone()).unwrap()
        });
        let is_outdone = |fitted: &Fitted, other: &Fitted, by: f64| {
            super::is_outdone(&dictionary, fitted, |of| match *of == other.hypothesis {
                true => fitted.estimate.cost - by,
                false => f64::INFINITY,
            })
        };
        assert!(is_outdone(&rich, &plain, 1.0));
        assert!(!is_outdone(&rich, &plain, -1.0));
        // A special case may explain less.
        assert!(!is_outdone(&plain, &rich, 1.0));
    }
}
