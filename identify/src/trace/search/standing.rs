//! Whether terms stand on their own.

use super::fit::Fitted;
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
}
