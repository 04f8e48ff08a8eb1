//! Another effect that says the same number of a channel in the place of one.
//!
//! Applies to effects on channels with one parameter. A late drive and a slow one differ little at
//! first, and each looks like the other until its time is about right: where one has found its
//! time, the other begins there. So does a late sensor of what the drive moves: where that is the
//! only sensor, it is the same log. And one late sensor is several early ones.

use super::Move;
use crate::trace::dictionary::Dictionary;
use crate::trace::search::channel::{drives, number_of_channel};
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::syntax::PortKind;

/// Another effect that says the same number.
pub struct Timing;

impl Move for Timing {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let of_term = |&term: &usize| {
            let new = equivalents(at.dictionary, term).into_iter();
            let new = new.filter(|(candidate, _)| !at.fitted.hypothesis.contains(*candidate));
            new.filter_map(move |(candidate, sign)| {
                let parameter = |c: usize| at.dictionary.candidates[c].parameters[0];
                let own = &at.dictionary.machine.compiled.model.parameters[parameter(candidate)];
                let number = sign * at.fitted.explanation.values[parameter(term)];
                // A bias to the left is no width of a dead band.
                (own.lower..=own.upper).contains(&number).then(|| {
                    let values = at.with(&vec![(parameter(candidate), number)]);
                    at.exchanged(&[term], &[candidate], values)
                })
            })
        };
        at.terms().iter().flat_map(of_term).collect()
    }
}

/// The candidates that say the same number as `term`, or the opposite: `±1`.
fn equivalents(dictionary: &Dictionary, term: usize) -> Vec<(usize, f64)> {
    let Some((places, unit)) = number_of_channel(dictionary, term) else {
        return Vec::new();
    };
    let is_sensor =
        |place: &(PortKind, String)| matches!(place.0, PortKind::Coordinate | PortKind::Sensor);
    let sign = |candidate: usize| {
        let (others, of_unit) = number_of_channel(dictionary, candidate)?;
        if candidate == term || of_unit != unit {
            return None;
        }
        let ([place], [at], true) = (places, others, unit == Dimension::TIME) else {
            let names = |places: &[(PortKind, String)]| -> Vec<String> {
                places.iter().map(|(_, name)| name.clone()).collect()
            };
            return (names(places) == names(others)).then_some(1.0);
        };
        let across = match (is_sensor(place), is_sensor(at)) {
            (false, true) => drives(dictionary, &place.1, &at.1),
            (true, false) => drives(dictionary, &at.1, &place.1),
            _ => false,
        };
        match at.1 == place.1 || across {
            true => Some(1.0),
            false if is_sensor(place) && is_sensor(at) => Some(-1.0),
            false => None,
        }
    };
    let all = 0..dictionary.candidates.len();
    all.filter_map(|c| Some((c, sign(c)?))).collect()
}

#[cfg(test)]
mod tests {
    use crate::trace::wheel::{WHEEL, rectangular, traced};
    use crate::trace::{Outcome, Verdict};
    use std::fmt::Write;

    /// What a log says of a wheel whose motor is 12 ms late: `u(t − 0.012) = i a(t)`.
    fn late() -> Outcome {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(3);
        let waves = [(0.5, 4.0), (0.1, 11.0)];
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let q: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let late = t + 0.012;
            let a: f64 = waves
                .iter()
                .map(|(a, w)| -a * w * w * (w * late).sin())
                .sum();
            writeln!(text, "{t},{},{}", q + 2e-4 * noise(), 0.02 * a).unwrap();
        }
        traced(WHEEL, &text)
    }

    #[test]
    fn a_late_motor_and_a_late_encoder_are_the_same_log() {
        let Outcome {
            verdict, findings, ..
        } = late();
        assert_eq!(verdict, Verdict::Channel);
        assert_eq!(findings.len(), 1, "{findings:#?}");
        let found = &findings[0];
        assert!(
            (found.parameters["tau"].value - 0.012).abs() < 5e-4,
            "{found:?}"
        );
        let mut names: Vec<&str> = found
            .confounded_with
            .iter()
            .map(|r| r.effect.as_str())
            .collect();
        names.push(&found.effect);
        for known in ["input_delay", "time_shift"] {
            assert!(names.contains(&known), "{names:?}");
        }
    }
}
