//! How long the forces last that nothing explains: as long as the log says.

use super::fit::Fitted;
use crate::log::median_step;
use crate::machine::SolveError;
use crate::trace::dictionary::Dictionary;
use crate::trace::refine::{Explanation, refine_curve};
use crate::trace::settings::{MARGIN, SAME_FIT};
use nalgebra::DVector;

/// Times are tried in steps of this factor,
const FACTOR: f64 = 3.0;
/// from so many samples on,
const SHORTEST: f64 = 2.0;
/// up to this share of the log.
const LONGEST: f64 = 0.1;

/// How long unexplained forces last beside a hypothesis, per coordinate, if the log tells it from
/// what is assumed.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn correlation(
    dictionary: &Dictionary,
    fitted: &Fitted,
) -> Result<Option<DVector<f64>>, SolveError> {
    let terms = fitted.hypothesis.candidates();
    let cost = |explanation: &mut Explanation| {
        refine_curve(dictionary, terms, explanation).map(|refined| refined.estimate.cost)
    };
    let mut best = fitted.explanation.clone();
    let begin = cost(&mut best)?;
    let mut lowest = begin;
    let t = &best.observed.curve.t;
    let (shortest, longest) = (SHORTEST * median_step(t), LONGEST * (t[t.len() - 1] - t[0]));
    for i in 0..best.observed.correlation.len() {
        if best.noise.force_sd[i] <= best.noise.smallest[i] {
            continue;
        }
        for factor in [1.0 / FACTOR, FACTOR] {
            loop {
                let mut other = best.clone();
                let time = factor * best.observed.correlation[i];
                if !(shortest..=longest).contains(&time) {
                    break;
                }
                other.observed.correlation[i] = time;
                // What shakes the machine from sample to sample stays as strong.
                other.noise.force_sd[i] *= factor.sqrt();
                match cost(&mut other) {
                    Ok(cost) if cost < lowest - SAME_FIT => (lowest, best) = (cost, other),
                    _ => break,
                }
            }
        }
    }
    Ok((lowest < begin - MARGIN).then_some(best.observed.correlation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{CORRELATION, Hold};
    use crate::trace::finding::Verdict;
    use crate::trace::search::fit::fit;
    use crate::trace::search::hypothesis::Hypothesis;
    use crate::trace::wheel::{WHEEL, begun, rectangular, traced};
    use std::fmt::Write;

    /// A wheel with viscous friction, `d` in N·m·s, in the gear of which a force wanders that no
    /// model holds: against which the motor turns it, so that it stands in the torque that was measured.
    /// After `lasts` seconds it is forgotten.
    fn log(d: f64, lasts: f64, size: f64) -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let (mut noise, mut push) = (rectangular(3), rectangular(4));
        let h = 0.005_f64;
        let kept = (-h / lasts).exp();
        let mut force = 0.0;
        for k in 0..6000 {
            let t = h * f64::from(k);
            let waves = [(0.9, 1.0), (0.5, 4.3)];
            let q: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let v: f64 = waves.iter().map(|(a, w)| a * w * (w * t).cos()).sum();
            let a: f64 = waves.iter().map(|(a, w)| -a * w * w * (w * t).sin()).sum();
            force = kept * force + size * (12.0 * (1.0 - kept * kept)).sqrt() * push();
            writeln!(
                text,
                "{t},{},{}",
                q + 1e-4 * noise(),
                0.02 * a + d * v + force
            )
            .unwrap();
        }
        text
    }

    #[test]
    fn forces_last_as_long_as_they_do() {
        for lasts in [0.02, 2.0] {
            let (dictionary, start) = begun(WHEEL, &log(0.0, lasts, 0.03), ["angle", "motor"]);
            let given = fit(&dictionary, &Hypothesis::nothing(Hold::Linear), start).unwrap();
            let found = correlation(&dictionary, &given).unwrap().unwrap()[0];
            let nearer = (found / lasts).ln().abs() < (CORRELATION / lasts).ln().abs();
            assert!(nearer, "{found} for {lasts}");
        }
    }

    /// What is named does not hang on what is not.
    #[test]
    fn friction_is_named_beside_a_force_that_nothing_explains() {
        if left_out::too_slow() {
            return;
        }
        let outcome = traced(WHEEL, &log(0.02, 1.0, 0.01));
        assert_eq!(outcome.verdict, Verdict::Effect, "{:#?}", outcome.findings);
        let [friction] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        assert_eq!(friction.effect, "viscous");
        let d = &friction.parameters["d"];
        assert!(
            (d.value - 0.02).abs() < 2.0 * d.std && d.std < 0.003,
            "{d:?}"
        );
        let left = outcome.unnamed.expect("a description of what remains");
        assert!(left.forces[0].lasts > 0.2, "{left:#?}");
        let share = outcome.remaining.share_after;
        assert!((share - 0.1).abs() < 0.03, "0.01 of about 0.1 N·m: {share}");
        let [left] = &outcome.remaining.forces[..] else {
            panic!("{:#?}", outcome.remaining);
        };
        assert!((left.size - 0.01).abs() < 0.01 / 3.0, "{left:?}");
        assert!(left.lasts > 1.0 / 3.0 && left.lasts < 3.0, "{left:?}");
    }
}
