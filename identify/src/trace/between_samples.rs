//! Times that are shorter than a log can tell from what drives do between its samples.
//!
//! A controller that is faster than the log holds each of its own samples, which the log does not
//! have: on average its inputs are late by half such a step, any time up to half a step of the log. That
//! is no fault of a drive, and no reason to change a model. It is the same for all drives of the controller, though:
//! what only some of them, or one sensor, are late by is theirs.

use super::dictionary::Dictionary;
use super::search::is_time;
use super::selection::{Selection, Term};
use crate::log::Record;
use std::collections::BTreeMap;

/// Whether a term of a selection, with `values` of all parameters, is such a time.
pub(super) fn is_hidden(
    dictionary: &Dictionary,
    term: &Term,
    (record, values): (&Record, &[f64]),
) -> bool {
    let candidate = &dictionary.candidates[term.candidate];
    let time = candidate.parameters.first();
    candidate.channel
        && is_time(dictionary, term.candidate)
        && !term.is_its_own
        && time.is_some_and(|&time| record.hides(values[time]))
}

/// Takes terms that are such times out of a selection, and says which they were: the column, or
/// the effect's ports, and the time in s.
pub(super) fn set_apart(
    dictionary: &Dictionary,
    selection: &mut Selection,
) -> BTreeMap<String, f64> {
    let mut apart = BTreeMap::new();
    let Selection {
        terms,
        values,
        observed,
        ..
    } = selection;
    terms.retain(|term| {
        let is_short = is_hidden(dictionary, term, (&observed.record, values));
        if is_short {
            let candidate = &dictionary.candidates[term.candidate];
            let time = candidate.parameters[0];
            apart.insert(candidate.subject.on().join(", "), values[time]);
            values[time] = dictionary.defaults[time];
        }
        !is_short
    });
    apart
}

#[cfg(test)]
mod tests {
    use crate::trace::Verdict;
    use crate::trace::wheel::{WHEEL, rectangular, traced};
    use std::fmt::Write;

    /// A log at 200 Hz of a wheel whose motor's controller has a step of 1 ms, and comes `late` ms later.
    fn log(late: i32) -> String {
        let torque = |tick: i32| {
            let t = 1e-3 * f64::from(tick - late);
            0.06 * (3.0 * t).cos() + 0.15 * (9.0 * t).cos()
        };
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(8);
        let (mut q, mut v, step) = (0.0, 0.0, 1e-3);
        for tick in 0..10_000 {
            if tick % 5 == 0 {
                let (t, u) = (step * f64::from(tick), torque(tick + late));
                writeln!(text, "{t:.3},{},{u}", q + 2e-6 * noise()).unwrap();
            }
            let a = torque(tick) / 0.02;
            q += v * step + 0.5 * a * step * step;
            v += a * step;
        }
        text
    }

    #[test]
    fn half_a_step_of_the_controller_is_no_fault_of_its_drive() {
        let outcome = traced(WHEEL, &log(0));
        assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
        // As a late motor, or as an early sensor.
        let late: Vec<f64> = outcome
            .between_samples
            .into_values()
            .map(f64::abs)
            .collect();
        let [late] = late[..] else {
            panic!("{late:?}");
        };
        assert!((late - 5e-4).abs() < 1e-4, "{late}");
    }

    const WHEELS: &str = "\
model wheels;
coordinate front: rad;
coordinate rear: rad;
input motor: N*m;
input other: N*m;
parameter i: kg*m^2 = 0.02;
kinetic i/2*(dot(front)^2 + dot(rear)^2);
force front = motor;
force rear = other;
";

    /// A log at 200 Hz of two wheels whose controller has a step of 1 ms; each motor comes `late` ms later.
    fn log_of_two(late: [i32; 2]) -> String {
        let torque = |wheel: usize, tick: i32| {
            let t = 1e-3 * f64::from(tick);
            let waves = [[(0.06, 3.0), (0.15, 9.0)], [(0.08, 4.0), (0.12, 11.0)]];
            let waves = waves[wheel].into_iter();
            waves
                .map(|(size, rate)| size * f64::cos(rate * t))
                .sum::<f64>()
        };
        let mut text = String::from("t,q_front,q_rear,u_motor,u_other\n");
        let mut noise = rectangular(8);
        let (mut q, mut v, step) = ([0.0; 2], [0.0; 2], 1e-3);
        for tick in 0..10_000 {
            if tick % 5 == 0 {
                let [u, w] = [0, 1].map(|wheel| torque(wheel, tick));
                let read = q.map(|q| q + 2e-6 * noise());
                let t = step * f64::from(tick);
                writeln!(text, "{t:.3},{},{},{u},{w}", read[0], read[1]).unwrap();
            }
            for wheel in 0..2 {
                let a = torque(wheel, tick - late[wheel]) / 0.02;
                q[wheel] += v[wheel] * step + 0.5 * a * step * step;
                v[wheel] += a * step;
            }
        }
        text
    }

    #[test]
    fn what_all_drives_are_late_by_is_the_controllers_and_what_one_is_its_own() {
        let outcome = traced(WHEELS, &log_of_two([1, 1]));
        assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
        let outcome = traced(WHEELS, &log_of_two([0, 2]));
        let [other] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        // As an early sensor beside inputs that are all held, or as a late drive beside none that is.
        assert!(
            ["front", "other"].contains(&other.on[0].as_str()),
            "{other:#?}"
        );
        let late = other.parameters.values().next().unwrap();
        assert!((late.value.abs() - 2e-3).abs() < 1e-4, "{other:#?}");
    }

    /// A wheel with friction that its controller, at 1 kHz and a tick late, takes to its way from half a radian off
    /// it; logged at 200 Hz.
    fn switched_on() -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(8);
        let (mut q, mut v, step) = (0.5, 0.0, 1e-3);
        let mut sent = 0.0;
        for tick in 0..10_000 {
            let t = step * f64::from(tick);
            let way = 0.5 * (3.0 * t).sin() + 0.2 * (9.0 * t + 1.0).sin();
            let rate = 1.5 * (3.0 * t).cos() + 1.8 * (9.0 * t + 1.0).cos();
            let read = q + 2e-5 * noise();
            let felt = std::mem::replace(&mut sent, 100.0 * (way - read) + 10.0 * (rate - v));
            if tick % 5 == 0 {
                writeln!(text, "{t:.3},{read},{felt}").unwrap();
            }
            let a = (felt - 0.02 * v) / 0.02;
            q += v * step + 0.5 * a * step * step;
            v += a * step;
        }
        text
    }

    /// For its first 20 ms the controller rings, and four of five of its torques are not in the log.
    #[test]
    fn what_a_log_hides_where_it_begins_hides_nothing_else() {
        let outcome = traced(WHEEL, &switched_on());
        let [friction] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        assert_eq!(friction.effect, "viscous");
        let d = &friction.parameters["d"];
        assert!((d.value - 0.02).abs() < 3.0 * d.std, "{d:?}");
        assert!(d.std < 1e-4, "{d:?}");
        let said = outcome.warnings.join("\n");
        assert!(!said.contains("u_motor"), "{said}");
    }

    #[test]
    fn what_is_later_than_half_a_sample_is() {
        let outcome = traced(WHEEL, &log(6));
        assert_eq!(outcome.verdict, Verdict::Channel, "{:#?}", outcome.findings);
        assert!(outcome.between_samples.is_empty());
    }
}
