//! Another term in the place of one.
//!
//! [`SwapHere`] applies where forces remain and something that acts at the place of a term looks
//! likely beside it: a rich effect may be what a simple one was taken for. [`Swap`] applies to
//! every term: leaning gravity and an encoder's offset are the same log of a planar arm.

use super::Move;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::{Exchange, Neighbourhood};
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::{EXCHANGED, MARGIN, SHORTLISTED, TIE};

/// What looks likely beside a term of its own place, in its stead.
pub struct SwapHere;

impl Move for SwapHere {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        if !at.fitted.leaves_forces() {
            return Vec::new();
        }
        let likely = at.considered.iter().filter(|c| c.score > MARGIN);
        let swaps = likely.take(SHORTLISTED).filter_map(|leader| {
            let candidate = leader.candidate;
            let fresh = at.fresh.iter().find(|c| c.candidate == candidate)?;
            let mut terms = at.terms().iter();
            let &term = terms.find(|&&term| at.is_beside(term, candidate))?;
            let mut proposal = at.exchanged(&[term], &[candidate], at.with(&fresh.values));
            proposal.promise = -leader.score;
            Some(proposal)
        });
        swaps.collect()
    }
}

/// What is as good in the place of a term to first order, or nearly.
pub struct Swap;

impl Move for Swap {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let size = |c: usize| at.dictionary.candidates[c].size();
        let of_term = |&term: &usize| {
            // What is only nearly as good says nothing beside forces, and what is richer may have
            // the term as its limit.
            let is_worth_it = move |one: &Exchange| {
                one.better > -TIE
                    || !at.fitted.leaves_forces() && size(one.instead[0]) <= size(term)
            };
            let exchanges = at
                .exchanges(&[term], |_| true)
                .into_iter()
                .filter(is_worth_it);
            of_laws(exchanges, EXCHANGED)
        };
        let all = at.terms().iter().flat_map(of_term);
        all.map(|one| at.proposal(one)).collect()
    }
}

/// The exchanges of so many laws that come first. What makes the log as likely is the same law by another name, as an
/// effect and as a parameter of the model: were each name counted, those of two laws would leave no room for a third.
fn of_laws(
    exchanges: impl Iterator<Item = Exchange>,
    most: usize,
) -> impl Iterator<Item = Exchange> {
    let mut lost: Vec<f64> = Vec::new();
    exchanges.take_while(move |one| {
        if lost.iter().all(|loss| (loss - one.loss).abs() > SAME_LOSS) {
            lost.push(one.loss);
        }
        lost.len() <= most
    })
}

/// Nats, to first order, within which two laws are one by two names: far below what tells any two apart.
const SAME_LOSS: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::wheel::{WHEEL, rectangular, traced, turned};
    use std::fmt::Write;

    #[test]
    fn names_of_one_law_take_the_room_of_one() {
        let exchange = |(candidate, loss): (usize, f64)| Exchange {
            out: vec![9],
            instead: vec![candidate],
            better: -loss,
            loss,
            worth: 100.0,
            values: Vec::new(),
        };
        let losses = [0.0, 1e-5, 0.5, 0.5, 1e-5, 0.9, 1.4, 0.0];
        let taken = |most: usize| -> Vec<usize> {
            let all = losses.into_iter().enumerate().map(exchange);
            of_laws(all, most).map(|one| one.instead[0]).collect()
        };
        assert_eq!(taken(1), [0, 1]);
        assert_eq!(taken(2), [0, 1, 2, 3, 4]);
        assert_eq!(taken(3), [0, 1, 2, 3, 4, 5]);
    }

    /// A wheel on a hardening spring, `hard q³`, with another of 0.3 N·m that rests at 0.25:
    /// the other alone is `0.3 (q³ − 0.75 q² + …)`, of which the first part is more of `hard`.
    #[test]
    fn a_term_that_came_first_goes_where_the_second_does_alone() {
        let text = turned([(0.7, 2.0), (0.4, 5.3)], (7, 2e-4), |[q, _, a]| {
            0.02 * a + 0.2 * q.powi(3) + 0.3 * (q - 0.25).powi(3)
        });
        let spring = "parameter hard: N*m = 0.2 in 0..; potential hard/4*angle^4;";
        let findings = traced(&format!("{WHEEL}{spring}"), &text).findings;
        let names: Vec<&str> = findings.iter().map(|f| f.effect.as_str()).collect();
        assert_eq!(names, ["cubic_spring"], "{findings:#?}");
        let spring = &findings[0].parameters;
        assert!((spring["k_3"].value - 0.3).abs() < 0.01, "{spring:?}");
        assert!((spring["q_0"].value - 0.25).abs() < 0.01, "{spring:?}");
    }

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
    fn leaning() -> String {
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

    #[test]
    fn leaning_gravity_and_an_offset_are_the_same_log() {
        let findings = traced(PENDULUM, &leaning()).findings;
        let [found] = &findings[..] else {
            panic!("{findings:#?}");
        };
        let rivals = found.confounded_with.iter().map(|r| r.effect.as_str());
        let names: Vec<&str> = rivals.chain([found.effect.as_str()]).collect();
        for known in ["gravity_tilt", "measurement_offset"] {
            assert!(names.contains(&known), "{names:?}");
        }
        // And a mass or a spring is not.
        assert!(names.len() == 2, "{names:?}");
    }
}
