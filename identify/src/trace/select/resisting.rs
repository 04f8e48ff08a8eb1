//! Friction before a force that pushes, where the log cannot tell them apart.
//!
//! Where a coordinate never turns back, a constant force against its motion and dry friction
//! are the same force. If it turned back, the one would drive the machine and the other would
//! not: what needs no source of energy is the simpler explanation.

use super::TIE;
use super::fitting::fit;
use super::search::{Attempt, Search};
use crate::log::rms;
use crate::machine::States;
use crate::trace::rivals::Alternative;

/// Forces whose difference is below this share of them are the same along a log.
const SAME: f64 = 0.05;
/// Samples that are looked at.
const LOOKED_AT: usize = 500;

impl Search<'_> {
    /// The accepted terms with one that would drive the machine, if it turned back, replaced
    /// by one of its `alike` that is the same force along the log and never would.
    pub(super) fn resisting(&self, alike: &[Vec<Alternative>]) -> Option<Attempt> {
        let pairs = self.accepted.iter().zip(alike);
        let mut pairs = pairs.flat_map(|(&term, alike)| alike.iter().map(move |a| (term, a)));
        pairs.find_map(|(term, alternative)| self.instead_of_driving(term, alternative))
    }

    fn instead_of_driving(&self, term: usize, alternative: &Alternative) -> Option<Attempt> {
        let candidates = &self.dictionary.candidates;
        let [driving, resisting] = [term, alternative.candidate].map(|c| &candidates[c]);
        if driving.channel || resisting.channel || driving.subject.on() != resisting.subject.on() {
            return None;
        }
        let there = self.current.explanation.observed.curve.spread(LOOKED_AT);
        let mut back = there.clone();
        back.v.iter_mut().flatten().for_each(|v| *v = -*v);
        let of_term = |states: &States| {
            let values = &self.current.explanation.values;
            self.force_of(term, term, values, states)
        };
        let of_other = |states: &States| {
            self.force_of(term, alternative.candidate, &alternative.values, states)
        };
        let (own, other) = (of_term(&there), of_other(&there));
        let apart: Vec<f64> = own.iter().zip(&other).map(|(a, b)| a - b).collect();
        let is_same = rms(&apart) < SAME * rms(&own);
        let drives = power(&own, &there) < 0.0 && power(&of_term(&back), &back) > 0.0;
        if !is_same || !drives || power(&of_other(&back), &back) >= 0.0 {
            return None;
        }
        let others = self.accepted.iter().copied().filter(|&t| t != term);
        let with: Vec<usize> = others.chain([alternative.candidate]).collect();
        let mut explanation = self.current.explanation.clone();
        explanation.values.clone_from(&alternative.values);
        let attempt = fit(self.dictionary, &with, explanation).ok()?;
        (attempt.cost < self.current.cost + TIE && self.is_possible(&attempt)).then_some(attempt)
    }

    /// The generalised force that `candidate` adds at each state, coordinate after coordinate,
    /// in the model that also has `term`.
    fn force_of(&self, term: usize, candidate: usize, values: &[f64], states: &States) -> Vec<f64> {
        let mut all = self.accepted.clone();
        if candidate != term {
            all.push(candidate);
        }
        let focus = self.dictionary.focus(&all);
        let mut without = values.to_vec();
        for &parameter in &self.dictionary.candidates[candidate].parameters {
            without[parameter] = self.dictionary.defaults[parameter];
        }
        let [with, without] =
            [values, &without].map(|values| focus.machine.terms(states, &focus.values(values)));
        let each = with.iter().zip(&without);
        let forces = each.map(|(with, without)| &with.force - &without.force);
        let forces: Vec<_> = forces.collect();
        let n = focus.machine.coordinate_count();
        let column = |i: usize| forces.iter().map(move |force| force[i]);
        (0..n).flat_map(column).collect()
    }
}

/// What a force, coordinate after coordinate, gives a machine along states, up to a factor.
fn power(force: &[f64], states: &States) -> f64 {
    let velocities = states.v.iter().flatten();
    force.iter().zip(velocities).map(|(f, v)| f * v).sum()
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{rectangular, traced};
    use std::fmt::Write;

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
}
