//! How believable a hypothesis is: its log evidence and what is believed beforehand.

use super::channel::clock_of_inputs;
use super::hypothesis::Hypothesis;
use crate::machine::States;
use crate::regression::Hold;
use crate::trace::dictionary::Dictionary;
use crate::trace::focus::Focus;
use crate::trace::refine::{Explanation, Refined};
use crate::trace::settings::{BRAKES, GLANCE, MARGIN, STATEMENT, UNUSUAL};
use crate::trace::subject::Subject;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Bounds further apart than this ratio say an order of magnitude, not a value.
const DECADE: f64 = 10.0;

/// The negative log evidence of a fitted hypothesis, nats: how unlikely the log is under it, and the
/// price of its parameters.
pub fn evidence(dictionary: &Dictionary, explanation: &Explanation, refined: &Refined) -> f64 {
    refined.estimate.cost + occam(dictionary, explanation, refined)
}

/// What is believed of a hypothesis before the log is read, nats, the less the better.
pub fn prior(dictionary: &Dictionary, hypothesis: &Hypothesis, explanation: &Explanation) -> f64 {
    let is_expected = |term: usize| is_expected(dictionary, term, explanation);
    price(dictionary, hypothesis, is_expected) + driving(dictionary, hypothesis, explanation)
}

/// Whether a term says that all drives are late by part of a sample, as a controller that is faster than the log
/// makes them: nothing is stated by that, and nothing was chosen.
pub fn is_expected(dictionary: &Dictionary, term: usize, explanation: &Explanation) -> bool {
    let clock = clock_of_inputs(dictionary, term);
    clock.is_some_and(|time| explanation.observed.record.hides(explanation.values[time]))
}

/// What it costs to have chosen a term among all candidates, nats.
pub fn price_of_choice(dictionary: &Dictionary) -> f64 {
    MARGIN + (dictionary.candidates.len() as f64).ln()
}

/// The least that the terms of a hypothesis cost before the log is read, whatever their values.
pub fn structure(dictionary: &Dictionary, hypothesis: &Hypothesis) -> f64 {
    let may_be_expected = |term: usize| clock_of_inputs(dictionary, term).is_some();
    price(dictionary, hypothesis, may_be_expected)
}

/// What terms cost but those that are expected.
fn price(
    dictionary: &Dictionary,
    hypothesis: &Hypothesis,
    is_expected: impl Fn(usize) -> bool,
) -> f64 {
    let terms = hypothesis.candidates().iter().copied();
    let terms = terms.filter(|&term| !is_expected(term)).map(|term| {
        let candidate = &dictionary.candidates[term];
        let stated = match candidate.subject {
            Subject::Parameter(_) => 0,
            Subject::Effect { .. } => candidate.parameters.len() + usize::from(candidate.channel),
        };
        price_of_choice(dictionary) + STATEMENT * stated as f64
    });
    let held = match hypothesis.hold {
        Hold::Linear => 0.0,
        Hold::Previous => UNUSUAL,
    };
    terms.sum::<f64>() + held
}

/// Occam's factor by Laplace's method, `½ ln |I + S H S|`, with the Hessian `H` of the cost and
/// the standard deviations `S` that parameters have beforehand: what the log does not determine
/// costs nothing, what it determines well costs as much as it might have been otherwise.
fn occam(dictionary: &Dictionary, explanation: &Explanation, refined: &Refined) -> f64 {
    let parameters = &refined.estimate.parameters;
    let bounds = &dictionary.machine.compiled.model.parameters;
    let before = DVector::from_fn(parameters.len(), |i, _| {
        let index = parameters[i];
        let parameter = &bounds[index];
        let by_bounds = || {
            spread(
                (parameter.lower, parameter.upper),
                (explanation.values[index], dictionary.defaults[index]),
                refined.reach[i],
            )
        };
        parameter.belief.map_or_else(by_bounds, |belief| belief.sd)
    });
    let size = parameters.len();
    let scaled = DMatrix::from_fn(size, size, |i, j| {
        let unit = if i == j { 1.0 } else { 0.0 };
        unit + before[i] * refined.information[(i, j)] * before[j]
    });
    let log_determinant = match Cholesky::new(scaled.clone()) {
        Some(cholesky) => 2.0 * cholesky.l_dirty().diagonal().map(f64::ln).sum(),
        None => scaled.diagonal().map(|d| d.max(1.0).ln()).sum(),
    };
    0.5 * log_determinant
}

/// How far a parameter of which nothing is believed may be expected to go: over its bounds where both
/// are stated, and otherwise to where it moves the machine as much as it moves, its `reach`.
fn spread((lower, upper): (f64, f64), (value, nominal): (f64, f64), reach: f64) -> f64 {
    // Of something even over a width of one.
    let even = 12.0_f64.sqrt().recip();
    if lower > 0.0 && upper.is_finite() && upper / lower > DECADE {
        return value * (upper / lower).ln() * even;
    }
    if lower.is_finite() && upper.is_finite() {
        return (upper - lower) * even;
    }
    match reach {
        reach if reach.is_finite() => reach,
        // Nothing is seen of it but through constraints: lengths.
        _ => nominal.abs(),
    }
}

/// What a hypothesis costs whose forces brake all along the log, and would drive the machine if
/// it turned back.
fn driving(dictionary: &Dictionary, hypothesis: &Hypothesis, explanation: &Explanation) -> f64 {
    let focus = dictionary.focus(hypothesis.candidates());
    // Those of an input, too: a biased drive pushes as a constant force does.
    let is_force = |term: &&usize| {
        let candidate = &dictionary.candidates[**term];
        !matches!(candidate.subject, Subject::Parameter(_))
    };
    if focus.machine.remembers() {
        return 0.0;
    }
    let there = explanation.observed.curve.spread(GLANCE);
    let mut back = there.clone();
    back.v.iter_mut().flatten().for_each(|v| *v = -*v);
    let forces = hypothesis.candidates().iter().filter(is_force);
    let driving = forces.filter(|&&term| {
        let work = |states: &States| {
            let force = force_of(dictionary, &focus, term, &explanation.values, states);
            work(&force, states)
        };
        let (given, size) = work(&there);
        given < -BRAKES * size && work(&back).0 > 0.0
    });
    driving.count() as f64 * UNUSUAL
}

/// The generalised force that `term` adds at each state, coordinate after coordinate.
fn force_of(
    dictionary: &Dictionary,
    focus: &Focus,
    term: usize,
    values: &[f64],
    states: &States,
) -> Vec<f64> {
    let without = dictionary.without(&[term], values);
    let [with, without] =
        [values, &without].map(|values| focus.machine.terms(states, &focus.values(values)));
    let each = with.iter().zip(&without);
    let forces: Vec<_> = each
        .map(|(with, without)| &with.force - &without.force)
        .collect();
    let column = |i: usize| forces.iter().map(move |force| force[i]);
    (0..focus.machine.coordinate_count())
        .flat_map(column)
        .collect()
}

/// What a force, coordinate after coordinate, gives a machine along states, and how much it gives
/// and takes, both up to one factor.
fn work(force: &[f64], states: &States) -> (f64, f64) {
    let velocities = states.v.iter().flatten();
    let power = force.iter().zip(velocities).map(|(f, v)| f * v);
    power.fold((0.0, 0.0), |(sum, size), p| (sum + p, size + p.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::search::fit::fit;
    use crate::trace::wheel::{begun, named, rectangular, traced};
    use std::fmt::Write;

    #[test]
    fn bounds_say_how_far_a_parameter_may_go() {
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(spread(free, (3.0, 1.0), 0.5), 0.5);
        assert_eq!(spread((0.0, f64::INFINITY), (3.0, 0.0), 0.5), 0.5);
        assert_eq!(spread(free, (3.0, -2.0), f64::INFINITY), 2.0);
        let even = spread((-0.6, 0.6), (0.1, 0.0), 9.0);
        assert!((even - 1.2 / 12.0_f64.sqrt()).abs() < 1e-12);
        // Over decades a value says as much as ten times that value.
        let [small, large] = [0.01, 0.1].map(|value| spread((0.001, 2.0), (value, 0.02), 9.0));
        assert!((large / small - 10.0).abs() < 1e-9, "{small} {large}");
    }

    const WHEEL: &str = "\
model wheel;
coordinate j: rad;
input j: N*m;
parameter i: kg*m^2 = 0.02;
kinetic i/2*dot(j)^2;
force j = input(j);
";

    /// A wheel that never turns back, with dry friction of 0.1 N·m: `u = i a + 0.1`, through an
    /// encoder with rectangular noise.
    fn log() -> String {
        let mut text = String::from("t,q_j,u_j\n");
        let mut noise = rectangular(1);
        for k in 0..1500 {
            let t = 0.004 * f64::from(k);
            let q = 5.0 * t + 0.5 * (4.0 * t).sin() + 1e-4 * noise();
            let a = -8.0 * (4.0 * t).sin();
            writeln!(text, "{t},{q},{}", 0.02 * a + 0.1).unwrap();
        }
        text
    }

    #[test]
    fn friction_goes_before_a_push_and_says_what_would_tell() {
        let findings = traced(WHEEL, &log()).findings;
        assert_eq!(findings.len(), 1, "{findings:?}");
        let friction = &findings[0];
        assert_eq!(
            (friction.effect.as_str(), &friction.on[0][..]),
            ("coulomb", "j")
        );
        assert!((friction.parameters["f_c"].value - 0.1).abs() < 1e-3);
        let mut rivals = friction.confounded_with.iter();
        let push = rivals
            .find(|rival| rival.effect == "constant_force")
            .unwrap();
        assert!(push.evidence_difference > -1.0);
        let motion = push.separating_motion.as_ref().unwrap();
        assert_eq!(motion.motion, "in the opposite direction");
        // Turned back, one force pushes where the other brakes: 0.2 N·m on 0.02 kg·m².
        assert!(
            (motion.apart - 10.0).abs() < 0.1 && motion.apart_in_log < 1e-3,
            "{motion:?}"
        );
    }

    /// Half a sample, 2 ms, is what any controller may be late by that is faster than the log.
    #[test]
    fn what_is_later_than_half_a_sample_is_a_choice() {
        let (dictionary, mut start) = begun(WHEEL, &log(), ["j", "j"]);
        let late = named(&dictionary, "input_delay(j)");
        let hypothesis = Hypothesis::nothing(Hold::Linear).exchange(&[], &[late]);
        let mut price = |time: f64| {
            start.values[dictionary.candidates[late].parameters[0]] = time;
            prior(&dictionary, &hypothesis, &start)
        };
        assert_eq!(price(1.9e-3), 0.0);
        let chosen = price_of_choice(&dictionary) + 2.0 * STATEMENT;
        assert_eq!(price(2.1e-3), chosen);
        // Nothing is given up that may still be either.
        assert_eq!(structure(&dictionary, &hypothesis), 0.0);
    }

    /// A log of one swing of a wheel of 0.03 kg·m² says that to within some per cent. What is believed of
    /// it stands beside that with the weight of its standard deviation: the estimate and its error
    /// are those of the two together.
    #[test]
    fn what_is_believed_of_a_parameter_weighs_as_much_as_it_is_sure() {
        let mut text = String::from("t,q_j,u_j\n");
        let mut noise = rectangular(4);
        for k in 0..60 {
            let t = 0.01 * f64::from(k);
            let q = 0.1 * (5.0 * t).sin() + 2e-3 * noise();
            let a = -2.5 * (5.0 * t).sin();
            writeln!(text, "{t},{q},{}", 0.03 * a).unwrap();
        }
        let estimate = |prior: &str| {
            let model = WHEEL.replace("0.02;", &format!("0.02 {prior};"));
            let (dictionary, start) = begun(&model, &text, ["j", "j"]);
            let inertia = named(&dictionary, "parameter(i)");
            let hypothesis = Hypothesis::nothing(Hold::Linear).exchange(&[], &[inertia]);
            let fitted = fit(&dictionary, &hypothesis, start).unwrap();
            let fitted = fit(&dictionary, &hypothesis, fitted.explanation).unwrap();
            let place = fitted.estimate.parameters[0];
            let variance = fitted.estimate.covariance[(0, 0)];
            (fitted.explanation.values[place], variance.sqrt())
        };
        let (free, free_sd) = estimate("");
        assert!((free - 0.03).abs() < 3.0 * free_sd, "{free} {free_sd}");
        let mean = free - free_sd;
        let (both, both_sd) = estimate(&format!("prior normal({mean}, {free_sd})"));
        // As sure as the log, it pulls half of the way, and leaves half of the variance.
        let expected = free - 0.5 * free_sd;
        assert!((both - expected).abs() < 0.2 * free_sd, "{both} {expected}");
        assert!((both_sd / (free_sd * 0.5_f64.sqrt()) - 1.0).abs() < 0.2);
    }
}
