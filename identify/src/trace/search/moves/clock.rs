//! All drives late by one time.
//!
//! Applies to several inputs where forces remain: one loop commands them, and they are built alike. One number says
//! so of all, `effect input_delay(left, right)`. Four rotors that lag by 30 ms are far from what a line says of times
//! that small, and one of them alone explains little: before that, what resembles all of them would be taken, a hull
//! whose height is late.

use super::Move;
use crate::trace::search::channel::timed_input;
use crate::trace::search::explored::Explored;
use crate::trace::search::lateness::Glance;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::MAX_TERMS;

/// All drives late by one time.
pub struct Clock;

impl Move for Clock {
    fn propose(&self, at: &Neighbourhood<'_>, explored: &Explored) -> Vec<Proposal> {
        if !at.fitted.leaves_forces() || at.terms().len() >= MAX_TERMS {
            return Vec::new();
        }
        let dictionary = at.dictionary;
        let is_clock = |&c: &usize| {
            let of_several = dictionary.candidates[c].subject.on().len() > 1;
            of_several && !at.fitted.hypothesis.contains(c) && timed_input(dictionary, c).is_some()
        };
        let clocks: Vec<usize> = (0..dictionary.candidates.len()).filter(is_clock).collect();
        if clocks.is_empty() {
            return Vec::new();
        }
        let glance = Glance::new(at);
        let radian = glance.quickest();
        let times = clocks
            .into_iter()
            .flat_map(|clock| glance.times(clock, radian));
        glance.likely(times.collect(), explored)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::regression::Hold;
    use crate::trace::search::fit::as_given;
    use crate::trace::wheel::{begun_with, named, rectangular, traced};
    use std::fmt::Write;

    pub const BAR: &str = "\
model bar;
coordinate x: m;
coordinate phi: rad;
input left: N;
input right: N;
parameter m: kg = 1 in 0..;
parameter i: kg*m^2 = 0.02 in 0..;
parameter arm: m = 0.2;
kinetic m/2*dot(x)^2 + i/2*dot(phi)^2;
force x = left + right;
force phi = arm*(right - left);
";

    /// A bar on ice that two rotors push at its ends, each of which lags its command by so many seconds; a controller
    /// at 200 Hz moves it by what noisy sensors say.
    pub fn log(lags: [f64; 2]) -> String {
        let mut text = String::from("t,q_x,q_phi,u_left,u_right\n");
        let mut noise = rectangular(5);
        let (mut q, mut v, mut thrust, mut command) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
        let mut known = [0.0; 2];
        for tick in 0..8000 {
            let t = 1e-3 * f64::from(tick);
            if tick % 5 == 0 {
                let read = q.map(|q| q + 6e-4 * noise());
                let rate = [0, 1].map(|i: usize| (read[i] - known[i]) / 5e-3);
                known = read;
                let wanted = [
                    0.3 * (2.1 * t).sin() + 0.15 * (5.3 * t).sin(),
                    0.3 * (3.1 * t).sin() + 0.2 * (6.7 * t).sin(),
                ];
                let force = 16.0 * (wanted[0] - read[0]) - 6.0 * rate[0];
                let couple = 0.02 * (64.0 * (wanted[1] - read[1]) - 11.0 * rate[1]) / 0.2;
                command = [(force - couple) / 2.0, (force + couple) / 2.0];
                writeln!(
                    text,
                    "{t:.3},{},{},{},{}",
                    read[0], read[1], command[0], command[1]
                )
                .unwrap();
            }
            // Of the thrust its mean over the millisecond, by its law.
            let kept = lags.map(|lag| (-1e-3 / lag).exp());
            let mean = [0, 1].map(|i| (1.0 - kept[i]) * lags[i] / 1e-3);
            let [left, right] = [0, 1].map(|i| command[i] + (thrust[i] - command[i]) * mean[i]);
            thrust = [0, 1].map(|i| command[i] + (thrust[i] - command[i]) * kept[i]);
            let a = [left + right, 0.2 * (right - left) / 0.02];
            for i in 0..2 {
                q[i] += 1e-3 * (v[i] + 0.5e-3 * a[i]);
                v[i] += 1e-3 * a[i];
            }
        }
        text
    }

    #[test]
    fn two_rotors_that_lag_alike_are_proposed_at_once_and_found() {
        if left_out::too_slow() {
            return;
        }
        let channels: [&[&str]; 2] = [&["x", "phi"], &["left", "right"]];
        let (dictionary, start) = begun_with(BAR, &log([0.03, 0.03]), channels);
        let given = as_given(&dictionary, &start.observed, Hold::Previous).unwrap();
        let at = Neighbourhood::new(&dictionary, &given, &[], false).unwrap();
        let proposed = Clock.propose(&at, &Explored::default());
        let both = named(&dictionary, "input_lag(left, right)");
        let is_of_both = |proposal: &&Proposal| proposal.hypothesis.candidates() == [both];
        let proposal = proposed.iter().find(is_of_both).expect("both rotors lag");
        let lag = proposal.values[dictionary.candidates[both].parameters[0]];
        assert!((lag - 0.03).abs() < 0.01, "{lag}");

        let outcome = traced(BAR, &log([0.03, 0.03]));
        let written = "effect input_lag(left, right) { tau = ";
        assert!(outcome.patched_model.contains(written));
        let findings = outcome.findings;
        let [lag] = &findings[..] else {
            panic!("{findings:#?}");
        };
        assert_eq!(
            (lag.effect.as_str(), &lag.on[..]),
            ("input_lag", &["left".to_string(), "right".to_string()][..])
        );
        assert!(
            (lag.parameters["tau"].value - 0.03).abs() < 3e-4,
            "{lag:#?}"
        );
    }
}
