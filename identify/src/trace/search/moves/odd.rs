//! The one channel that is late, or all drives, in the place of all others that seem to be early.
//!
//! Applies to times of all channels but what one candidate is about. A log tells times beside each other only: where
//! an encoder is late, all other sensors fit as well if they are early by its time and the drives if they are late by
//! it, and that is where a search may end that takes one after the other. Of that time of the drives a part may be their
//! own, as where a controller is faster than the log: what is left of it stays theirs.

use super::Move;
use crate::trace::dictionary::Dictionary;
use crate::trace::search::channel::number_of_channel;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::syntax::PortKind;

/// The one channel that is late.
pub struct Odd;

impl Move for Odd {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let all = 0..at.dictionary.candidates.len();
        let all = all.filter_map(|candidate| Timed::of(at.dictionary, candidate));
        let (known, new): (Vec<Timed<'_>>, Vec<Timed<'_>>) =
            all.partition(|one| at.fitted.hypothesis.contains(one.candidate));
        let is_known = |place| known.iter().any(|known| known.places.contains(place));
        let mut odd = new;
        odd.retain(|one| !one.places.iter().any(is_known));
        let all = odd.iter().map(|one| one.places);
        let Some(whole) = all.max_by_key(|places| places.len()) else {
            return Vec::new();
        };
        let is_in = |one: &Timed<'_>| one.places.iter().all(|place| whole.contains(place));
        let timed: usize = known.iter().map(|one| one.places.len()).sum();
        if timed < 2 || !odd.iter().all(is_in) {
            return Vec::new();
        }
        odd.retain(|one| one.places == whole);
        let values = &at.fitted.explanation.values;
        let all: Vec<&Timed<'_>> = known.iter().collect();
        let (drives, sensors): (Vec<&Timed<'_>>, Vec<&Timed<'_>>) =
            known.iter().partition(|one| one.sign < 0.0);
        // What is early, and drives that keep what is left of their time.
        let mut early = vec![(&all, None)];
        if let ([drives], [_, ..]) = (&drives[..], &sensors[..]) {
            early.push((&sensors, Some(*drives)));
        }
        let proposals = early.into_iter().flat_map(|(early, kept)| {
            let times = early.iter().map(|one| one.sign * values[one.parameter]);
            let late = -times.sum::<f64>() / early.len() as f64;
            let out: Vec<usize> = early.iter().map(|one| one.candidate).collect();
            let left = kept.map(|drives| (drives.parameter, values[drives.parameter] - late));
            let is_new = move |one: &&Timed<'_>| kept.is_none() || one.sign > 0.0;
            odd.iter().filter(is_new).filter_map(move |one| {
                let own = (one.parameter, one.sign * late);
                let times: Vec<(usize, f64)> = [own].into_iter().chain(left).collect();
                is_possible(at.dictionary, &times).then(|| Proposal {
                    ahead: late,
                    ..at.exchanged(&out, &[one.candidate], at.with(&times))
                })
            })
        });
        proposals.collect()
    }
}

/// Whether all of some parameters are within their bounds.
fn is_possible(dictionary: &Dictionary, values: &[(usize, f64)]) -> bool {
    let bounds = &dictionary.machine.compiled.model.parameters;
    let mut values = values.iter();
    values.all(|&(p, value)| (bounds[p].lower..=bounds[p].upper).contains(&value))
}

/// A candidate that says how late a channel is.
struct Timed<'a> {
    candidate: usize,
    places: &'a [(PortKind, String)],
    parameter: usize,
    /// −1 of an input: what the machine feels later shows in it as if all else were early.
    sign: f64,
}

impl<'a> Timed<'a> {
    fn of(dictionary: &'a Dictionary, candidate: usize) -> Option<Self> {
        let (places, unit) = number_of_channel(dictionary, candidate)?;
        (unit == Dimension::TIME).then(|| Self {
            candidate,
            places,
            parameter: dictionary.candidates[candidate].parameters[0],
            sign: if places[0].0 == PortKind::Input {
                -1.0
            } else {
                1.0
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::Hold;
    use crate::trace::search::fit::fit;
    use crate::trace::search::hypothesis::Hypothesis;
    use crate::trace::wheel::{begun_with, named, rectangular};
    use std::fmt::Write;

    /// Two masses on ice with a spring between them; the first is pushed.
    const MASSES: &str = "\
model masses;
coordinate a: m;
coordinate b: m;
input a: N;
parameter m: kg = 1;
parameter k: N/m = 50;
kinetic m/2*(dot(a)^2 + dot(b)^2);
potential k/2*(b - a)^2;
force a = input(a);
";

    /// `b` goes along two waves: `a = b + b″ m/k`, `u = m (a″ + b″)`. It is read so many seconds late.
    fn log(late: f64) -> String {
        let mut text = String::from("t,q_a,q_b,u_a\n");
        let mut noise = rectangular(3);
        let motion = |t: f64| {
            let waves = [(0.3_f64, 2.0_f64), (0.1, 5.0)];
            waves.iter().fold([0.0; 3], |[a, b, u], (size, w)| {
                let (b_own, share) = (size * (w * t).sin(), 1.0 - w * w / 50.0);
                let push = -w * w * b_own * (share + 1.0);
                [a + share * b_own, b + b_own, u + push]
            })
        };
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let ([a, _, u], [_, b, _]) = (motion(t), motion(t - late));
            let read = [a, b].map(|x| x + 2e-4 * noise());
            writeln!(text, "{t},{},{},{u}", read[0], read[1]).unwrap();
        }
        text
    }

    #[test]
    fn one_late_sensor_is_proposed_for_all_else_that_is_early() {
        let (dictionary, start) = begun_with(MASSES, &log(0.015), [&["a", "b"], &["a"]]);
        let [early, fed, odd] = ["time_shift(a)", "input_delay(a)", "time_shift(b)"]
            .map(|name| named(&dictionary, name));
        let nothing = Hypothesis::nothing(Hold::Linear);
        let fitted = fit(&dictionary, &nothing.exchange(&[], &[early, fed]), start).unwrap();
        let at = Neighbourhood::new(&dictionary, &fitted, &[], false).unwrap();
        let proposed = Odd.propose(&at, &Explored::default());
        let proposal = &proposed[0];
        assert_eq!(proposal.hypothesis.candidates(), [odd]);
        let time = proposal.values[dictionary.candidates[odd].parameters[0]];
        assert!((time - 0.015).abs() < 1e-3, "{time}");
        let simpler = fit(
            &dictionary,
            &proposal.hypothesis,
            proposal.start(&dictionary, &fitted),
        );
        assert!(simpler.unwrap().score < fitted.score);
    }

    /// The same masses, both pushed, by drives that are 15 ms late: `u(t) = m a″ + k (a − b)` of 15 ms later.
    #[test]
    fn all_drives_are_proposed_for_all_sensors_that_are_early() {
        let both = MASSES.replace(
            "force a = input(a);",
            "input b: N;\nforce a = input(a);\nforce b = input(b);",
        );
        let mut text = String::from("t,q_a,q_b,u_a,u_b\n");
        let mut noise = rectangular(3);
        let motion = |t: f64| {
            [
                0.3 * (2.0 * t).sin() + 0.1 * (5.0 * t).sin(),
                0.2 * (3.0 * t).sin(),
            ]
        };
        let push = |t: f64| {
            let [a, b] = motion(t);
            let pull = 50.0 * (a - b);
            let [a, b] = [
                -1.2 * (2.0 * t).sin() - 2.5 * (5.0 * t).sin(),
                -1.8 * (3.0 * t).sin(),
            ];
            [a + pull, b - pull]
        };
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let ([a, b], [u_a, u_b]) = (motion(t).map(|x| x + 2e-4 * noise()), push(t + 0.015));
            writeln!(text, "{t},{a},{b},{u_a},{u_b}").unwrap();
        }
        let (dictionary, start) = begun_with(&both, &text, [&["a", "b"], &["a", "b"]]);
        let early = ["time_shift(a)", "time_shift(b)"].map(|name| named(&dictionary, name));
        let nothing = Hypothesis::nothing(Hold::Linear);
        let fitted = fit(&dictionary, &nothing.exchange(&[], &early), start).unwrap();
        let at = Neighbourhood::new(&dictionary, &fitted, &[], false).unwrap();
        let late = named(&dictionary, "input_delay(a, b)");
        let proposed = Odd.propose(&at, &Explored::default());
        let of_drives = proposed
            .iter()
            .find(|one| one.hypothesis.candidates() == [late]);
        let time = of_drives.unwrap().values[dictionary.candidates[late].parameters[0]];
        assert!((time - 0.015).abs() < 1e-3, "{time}");
        let of_all = |one: &Proposal| {
            dictionary.candidates[one.hypothesis.candidates()[0]]
                .subject
                .on()
                .len()
                == 2
        };
        assert!(proposed.iter().all(of_all));
    }

    /// An encoder that is 15 ms late, and a drive 3 ms.
    #[test]
    fn what_is_left_of_a_time_stays_that_of_the_drives() {
        let (dictionary, start) = begun_with(MASSES, &log(0.015), [&["a", "b"], &["a"]]);
        let [early, fed, odd] = ["time_shift(a)", "input_delay(a)", "time_shift(b)"]
            .map(|name| named(&dictionary, name));
        let nothing = Hypothesis::nothing(Hold::Linear);
        let mut fitted = fit(&dictionary, &nothing.exchange(&[], &[early, fed]), start).unwrap();
        let time = |candidate: usize| dictionary.candidates[candidate].parameters[0];
        fitted.explanation.values[time(early)] = -0.015;
        fitted.explanation.values[time(fed)] = 0.018;
        let at = Neighbourhood::new(&dictionary, &fitted, &[], false).unwrap();
        let proposed = Odd.propose(&at, &Explored::default());
        let [_, both] = &proposed[..] else {
            panic!("{proposed:?}");
        };
        assert_eq!(
            both.hypothesis,
            nothing.exchange(&[], &[fed, odd]),
            "{proposed:?}"
        );
        assert!((both.values[time(odd)] - 0.015).abs() < 1e-12);
        assert!((both.values[time(fed)] - 0.003).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_proposed_where_two_channels_are_not_thought_late() {
        let (dictionary, start) = begun_with(MASSES, &log(0.0), [&["a", "b"], &["a"]]);
        let early = named(&dictionary, "time_shift(a)");
        let nothing = Hypothesis::nothing(Hold::Linear);
        let fitted = fit(&dictionary, &nothing.exchange(&[], &[early]), start).unwrap();
        let at = Neighbourhood::new(&dictionary, &fitted, &[], false).unwrap();
        assert!(Odd.propose(&at, &Explored::default()).is_empty());
    }
}
