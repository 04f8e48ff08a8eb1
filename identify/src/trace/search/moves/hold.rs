//! The other assumption about what inputs do between samples.
//!
//! Applies where the log is to say which: to stay at the last sample and to be later by half a
//! sample is nearly the same, so that delays change with it. [`HoldForTime`] applies to a term
//! that is a time: all sensors early by half a sample are inputs late by as much.

use super::Move;
use crate::regression::Hold as Between;
use crate::trace::search::channel::{is_time, timed_input};
use crate::trace::search::explored::Explored;
use crate::trace::search::fit::Fitted;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::TIE;
use std::sync::Arc;

/// The same terms under the other assumption, and those with another time that are about as good:
/// they may not be so under it.
pub struct Hold;

impl Move for Hold {
    fn propose(&self, at: &Neighbourhood<'_>, explored: &Explored) -> Vec<Proposal> {
        let fitted = at.fitted;
        let as_good = |other: &&Arc<Fitted>| other.score < fitted.score + TIE;
        let with_another_time = |other: &Arc<Fitted>| {
            let swap = fitted.hypothesis.differs_by_one(&other.hypothesis)?;
            is_time(at.dictionary, swap.1).then_some(())?;
            otherwise(at, (&[swap.0], &[swap.1]), &other.explanation.values)
        };
        let kept = explored.kept().iter().filter(as_good);
        let others = kept.filter_map(with_another_time);
        let own = otherwise(at, (&[], &[]), &fitted.explanation.values);
        own.into_iter().chain(others).collect()
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
            .filter_map(|&time| otherwise(at, (&[time], &[]), &at.fitted.explanation.values))
            .collect()
    }
}

/// Terms exchanged, with these values, under the other assumption. An input that is held is half a sample
/// later than it is drawn: so much less is what is left to its delay, and a fit that began with all of it
/// might not find the way.
fn otherwise(
    at: &Neighbourhood<'_>,
    (out, instead): (&[usize], &[usize]),
    values: &[f64],
) -> Option<Proposal> {
    let record = &at.fitted.explanation.observed.record;
    if !at.free_hold || record.u.is_empty() {
        return None;
    }
    let half = 0.5 * record.step();
    let mut proposal = at.exchanged(out, instead, values.to_vec());
    proposal.hypothesis = proposal.hypothesis.held_otherwise();
    let later = match proposal.hypothesis.hold {
        Between::Linear => half,
        Between::Previous => -half,
    };
    let bounds = &at.dictionary.machine.compiled.model.parameters;
    for &term in proposal.hypothesis.candidates() {
        if let Some(parameter) = timed_input(at.dictionary, term) {
            let time = &mut proposal.values[parameter];
            *time = (*time + later).clamp(bounds[parameter].lower, bounds[parameter].upper);
        }
    }
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

    fn motor(t: f64) -> f64 {
        0.04 * (3.0 * t).sin() + 0.06 * (7.0 * t).cos()
    }

    /// What a log says of a wheel whose motor holds each value for a sample and gets it `late`
    /// tenths of a sample later: between jumps the angle is a parabola. Perhaps an accelerometer, with
    /// some noise, is on it.
    fn held(late: i32, noise: f64, accelerometer: Option<f64>) -> Outcome {
        let mut text = String::from("t,q_angle,u_motor");
        text.push_str(accelerometer.map_or("\n", |_| ",ddq_angle\n"));
        let mut random = rectangular(5);
        let (mut q, mut v) = (0.3, 0.0);
        let tick = STEP / f64::from(TICKS);
        for k in 0..2000 {
            let t = STEP * f64::from(k);
            write!(text, "{t},{},{}", q + noise * random(), motor(t)).unwrap();
            let acceleration = |tick: i32| {
                let sent = (tick - late).max(0) / TICKS;
                motor(STEP * f64::from(sent)) / 0.02
            };
            if let Some(noise) = accelerometer {
                write!(text, ",{}", acceleration(k * TICKS) + noise * random()).unwrap();
            }
            text.push('\n');
            for i in 0..TICKS {
                let a = acceleration(k * TICKS + i);
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
        let findings = held(0, 2e-4, None).findings;
        assert!(findings.is_empty(), "{findings:#?}");
    }

    #[test]
    fn a_delay_is_as_uncertain_as_what_inputs_do_between_samples() {
        let outcome = held(24, 1e-3, None);
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

    /// An accelerometer tells apart what the angle does not: at a sample it feels the value that has come
    /// last, not a mean.
    #[test]
    fn an_accelerometer_feels_each_value_that_is_held() {
        let outcome = held(24, 1e-3, Some(0.02));
        let findings = &outcome.findings;
        let found: Vec<&str> = findings.iter().map(|f| &f.effect[..]).collect();
        assert_eq!(found, ["input_delay"]);
        assert_eq!(outcome.input_hold_is, HoldIs::Found);
        assert_eq!(outcome.input_hold, Between::Previous);
        let tau = &findings[0].parameters["tau"];
        assert!((tau.value - 2.4 * STEP).abs() < 3.0 * tau.std, "{tau:?}");
        assert!(tau.std < 0.4 * STEP, "{tau:?}");
    }
}
