//! Alternatives that are only nearly as good to first order: a fit says whether they are as good.
//!
//! Gravity that leans, and an encoder of the first joint that is read with an offset, are the
//! same log of a planar arm. To first order the one looked 39 nats worse than the other there;
//! fitted, they are alike.

use super::TIE;
use super::fitting::fit;
use super::search::{Search, leaves_forces, reset};
use crate::trace::rivals::{Alternative, join};
use rayon::prelude::*;

/// How many alternatives of a term are fitted.
const FITTED: usize = 3;
/// One whose fit is this many times as far behind as first order said is another law: none of
/// the patience that a narrow valley needs will make it the same.
const FARTHER: f64 = 2.0;

impl Search<'_> {
    /// Of the `alternatives` of each accepted term, those that are not as good to first order are
    /// fitted, and stay if they are after all. As long as forces remain none does: what is nearly
    /// as good as what is wrong says nothing. Nor does one with more parameters, which may only
    /// have the term as its limit.
    pub(super) fn fit_nearly_alike(&self, alternatives: &mut [Vec<Alternative>]) {
        for (alike, &term) in alternatives.iter_mut().zip(&self.accepted) {
            let size = |candidate: usize| self.dictionary.candidates[candidate].size();
            let nearly = alike.extract_if(.., |one| one.better <= -TIE);
            let mut nearly: Vec<Alternative> = nearly.collect();
            nearly.retain(|one| size(one.candidate) <= size(term));
            nearly.truncate(FITTED);
            if leaves_forces(&self.current) {
                continue;
            }
            let fitted = nearly.into_par_iter().map(|one| self.fitted(term, &one));
            let fitted: Vec<Option<Alternative>> = fitted.collect();
            let as_good = fitted.into_iter().flatten().filter(|one| one.better > -TIE);
            as_good.for_each(|one| join(alike, one));
        }
    }

    /// The alternative of an accepted term after a fit, if it is possible.
    fn fitted(&self, term: usize, alternative: &Alternative) -> Option<Alternative> {
        let mut explanation = self.current.explanation.clone();
        explanation.values.clone_from(&alternative.values);
        reset(self.dictionary, &mut explanation, term);
        let others = self.accepted.iter().copied().filter(|&c| c != term);
        let with: Vec<usize> = others.chain([alternative.candidate]).collect();
        let attempt = fit(self.dictionary, &with, explanation).ok()?;
        if self.current.cost - attempt.cost < FARTHER * alternative.better {
            return None;
        }
        let attempt = self.sharpened(attempt);
        self.is_possible(&attempt).then_some(Alternative {
            candidate: alternative.candidate,
            better: self.current.cost - attempt.cost,
            values: attempt.explanation.values,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{begun, named, rectangular};
    use super::*;
    use crate::trace::Silent;
    use crate::trace::rivals::rivals;
    use std::fmt::Write;

    /// A pendulum that hangs from a joint with a motor.
    const PENDULUM: &str = "\
model pendulum;
coordinate angle: rad;
input angle: N*m;
parameter m: kg = 0.5;
body rod {
    frame: rotate_z(angle);
    mass: m;
    center: (0, -0.4, 0);
    inertia: diag(0, 0, 0.01);
}
gravity (0, -9.81, 0);
force angle = input(angle);
";

    /// `u = (I + m l²) a + m g l sin(q)` of a pendulum whose angle is read 0.3 rad too large.
    fn log() -> String {
        let mut text = String::from("t,q_angle,u_angle\n");
        let mut noise = rectangular(4);
        let waves = [(0.6, 2.0), (0.3, 7.0)];
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let q: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let a: f64 = waves.iter().map(|(a, w)| -a * w * w * (w * t).sin()).sum();
            let u = (0.01 + 0.5 * 0.16) * a + 0.5 * 9.81 * 0.4 * q.sin();
            writeln!(text, "{t},{},{u}", q + 0.3 + 2e-4 * noise()).unwrap();
        }
        text
    }

    /// And a mass or a spring is not.
    #[test]
    fn leaning_gravity_and_an_offset_are_the_same_log() {
        let (dictionary, start) = begun(PENDULUM, &log(), ["angle", "angle"]);
        let names = ["gravity_tilt()", "measurement_offset(angle)"];
        let [tilt, offset] = names.map(|name| named(&dictionary, name));
        let current = fit(&dictionary, &[tilt], start).unwrap();
        let search = Search {
            dictionary: &dictionary,
            progress: &Silent,
            accepted: vec![tilt],
            first_round: Vec::new(),
            given_cost: current.cost,
            current,
        };
        let explanation = &search.current.explanation;
        let mut alternatives = rivals(&dictionary, explanation, &search.accepted).unwrap();
        // As if first order had said so of all of them.
        alternatives[0]
            .iter_mut()
            .for_each(|one| one.better = -5.0 * TIE);
        search.fit_nearly_alike(&mut alternatives);
        let [alike] = &alternatives[0][..] else {
            panic!("{alternatives:?}");
        };
        assert_eq!(alike.candidate, offset);
        assert!(alike.better.abs() < 0.1, "{alike:?}");
    }
}
