//! The other assumption about what inputs do between samples.
//!
//! Applies where the log is to say which: to stay at the last sample and to be later by half a
//! sample is nearly the same, so that delays change with it. [`HoldForTime`] applies to a term
//! that is a time: all sensors early by half a sample are inputs late by as much.

use super::Move;
use crate::log::median_step;
use crate::regression::Hold as Between;
use crate::trace::search::channel::{is_time, timed_input};
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;

/// The same terms under the other assumption.
pub struct Hold;

impl Move for Hold {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        otherwise(at, None).into_iter().collect()
    }
}

/// One time less under the other assumption.
pub struct HoldForTime;

impl Move for HoldForTime {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let times = at
            .terms()
            .iter()
            .filter(|&&term| is_time(at.dictionary, term));
        times
            .filter_map(|&time| otherwise(at, Some(time)))
            .collect()
    }
}

/// An input that is held is half a sample later than it is drawn: so much less is what is left to
/// its delay, and a fit that began with all of it might not find the way.
fn otherwise(at: &Neighbourhood<'_>, without: Option<usize>) -> Option<Proposal> {
    let explanation = &at.fitted.explanation;
    if !at.free_hold || explanation.observed.record.u.is_empty() {
        return None;
    }
    let half = 0.5 * median_step(&explanation.observed.record.t);
    let hypothesis = at.fitted.hypothesis.held_otherwise();
    let later = match hypothesis.hold {
        Between::Linear => half,
        Between::Previous => -half,
    };
    let bounds = &at.dictionary.machine.compiled.model.parameters;
    let mut values = explanation.values.clone();
    for &term in at.terms() {
        if let Some(parameter) = timed_input(at.dictionary, term) {
            let time = &mut values[parameter];
            *time = (*time + later).clamp(bounds[parameter].lower, bounds[parameter].upper);
        }
    }
    let out: Vec<usize> = without.into_iter().collect();
    let mut proposal = at.exchanged(&out, &[], values);
    proposal.hypothesis.hold = hypothesis.hold;
    Some(proposal)
}

#[cfg(test)]
mod tests {
    use super::Between;
    use crate::trace::wheel::{WHEEL, rectangular, traced};
    use crate::trace::{HoldIs, Outcome};
    use std::fmt::Write;

    const STEP: f64 = 0.005;
    const TICKS: i32 = 10;

    /// What a log says of a wheel whose motor holds each value for a sample and gets it `late`
    /// tenths of a sample later: between jumps the angle is a parabola.
    fn held(late: i32, noise: f64) -> Outcome {
        let motor = |t: f64| 0.04 * (3.0 * t).sin() + 0.06 * (7.0 * t).cos();
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut random = rectangular(5);
        let (mut q, mut v) = (0.3, 0.0);
        let tick = STEP / f64::from(TICKS);
        for k in 0..2000 {
            let t = STEP * f64::from(k);
            writeln!(text, "{t},{},{}", q + noise * random(), motor(t)).unwrap();
            for i in 0..TICKS {
                let sent = (k * TICKS + i - late).max(0) / TICKS;
                let a = motor(STEP * f64::from(sent)) / 0.02;
                q += v * tick + 0.5 * a * tick * tick;
                v += a * tick;
            }
        }
        traced(WHEEL, &text)
    }

    /// Of two motors on one shaft, both held, the left one gets its values 2.4 samples late.
    #[test]
    fn one_of_two_held_inputs_is_late() {
        const SHAFT: &str = "\
model shaft;
coordinate angle: rad;
input left: N*m;
input right: N*m;
parameter i: kg*m^2 = 0.02;
kinetic i/2*dot(angle)^2;
force angle = input(left) + input(right);
";
        let late = 24;
        let left = |t: f64| 0.04 * (3.0 * t).sin() + 0.06 * (7.0 * t).cos();
        let right = |t: f64| 0.05 * (4.0 * t).cos() - 0.03 * (11.0 * t).sin();
        let mut text = String::from("t,q_angle,u_left,u_right\n");
        let mut random = rectangular(6);
        let (mut q, mut v) = (0.3, 0.0);
        let tick = STEP / f64::from(TICKS);
        for k in 0..2000 {
            let t = STEP * f64::from(k);
            let read = q + 2e-4 * random();
            writeln!(text, "{t},{read},{},{}", left(t), right(t)).unwrap();
            for i in 0..TICKS {
                let sent = (k * TICKS + i - late).max(0) / TICKS;
                let a = (left(STEP * f64::from(sent)) + right(t)) / 0.02;
                q += v * tick + 0.5 * a * tick * tick;
                v += a * tick;
            }
        }
        let findings = traced(SHAFT, &text).findings;
        let found: Vec<_> = findings.iter().map(|f| (&f.effect[..], &f.on)).collect();
        assert_eq!(found, [("input_delay", &vec!["left".to_string()])]);
        let tau = &findings[0].parameters["tau"];
        assert!((tau.value - 2.4 * STEP).abs() < 3.0 * tau.std, "{tau:?}");
    }

    #[test]
    fn an_input_that_is_held_is_not_late() {
        let findings = held(0, 2e-4).findings;
        assert!(findings.is_empty(), "{findings:#?}");
    }

    #[test]
    fn a_delay_is_as_uncertain_as_what_inputs_do_between_samples() {
        let outcome = held(24, 1e-3);
        let findings = &outcome.findings;
        assert_eq!(findings.len(), 1, "{findings:#?}");
        let tau = &findings[0].parameters["tau"];
        let late = 2.4 * STEP;
        // Were the input drawn straight it would be half a sample later.
        let [held, straight] = [late, late + 0.5 * STEP].map(|t| (tau.value - t).abs());
        assert!(held < 2.0 * tau.std && straight < 2.0 * tau.std, "{tau:?}");
        assert!(tau.std < STEP, "{tau:?}");
        // And the summary says both.
        assert_eq!(outcome.input_hold_is, HoldIs::Undecided);
        let times: Vec<f64> = outcome.if_held_otherwise.into_values().collect();
        let [otherwise] = times[..] else {
            panic!("{times:?}");
        };
        let expected = match outcome.input_hold {
            Between::Linear => late,
            Between::Previous => late + 0.5 * STEP,
        };
        assert!((otherwise - expected).abs() < 0.1 * STEP, "{otherwise}");
    }
}
