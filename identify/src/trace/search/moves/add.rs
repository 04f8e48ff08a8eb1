//! One more term.
//!
//! Applies always. Beside a wheel with dry friction in its bearing: `coulomb(angle)`,
//! `stribeck(angle)` and what else looks like it to first order.

use super::Move;
use crate::trace::screen::Considered;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::search::score::price_of_choice;
use crate::trace::settings::{MARGIN, MAX_TERMS, PROFILED, SHORTLISTED};
use rayon::prelude::*;

/// One more term.
pub struct Add;

impl Move for Add {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        if at.terms().len() >= MAX_TERMS {
            return Vec::new();
        }
        let known = at.fitted.estimate.cost;
        let price = price_of_choice(at.dictionary);
        let leaves_forces = at.fitted.leaves_forces();
        let mut listed = shortlist(at);
        listed.retain(|(cost, one)| leaves_forces && may_earn(one) || cost + price < known);
        let listed = listed.into_iter();
        listed
            .map(|(cost, one)| at.addition(&[one], cost))
            .collect()
    }
}

/// The leading candidates, by a linear fit and then by one with noise that suits them, each with
/// that fit's cost.
fn shortlist<'a>(at: &'a Neighbourhood<'_>) -> Vec<(f64, &'a Considered)> {
    let (screen, candidates) = (&at.screen, &at.dictionary.candidates);
    // Beside the model as given and forces as large as all that it lacks, no law is worth much, though
    // it may explain them all: noise that suits it says so.
    let is_first = at.terms().is_empty() && at.fitted.leaves_forces();
    let may_lead = |one: &&Considered| is_first && one.gain > 0.0 || may_earn(one);
    let rows = at.fitted.estimate.rows as f64;
    let leading = at.considered.iter().filter(may_lead).take(PROFILED);
    let leading: Vec<&Considered> = leading.collect();
    let profiled = leading.into_par_iter().map(|c| {
        let size = candidates[c.candidate].size() as f64;
        let shapes = std::iter::once(c).chain(c.other_shapes.first());
        let cost = |shape: &'a Considered| screen.profile(&[shape]) + 0.5 * size * rows.ln();
        let mut profiles: Vec<(f64, &Considered)> = shapes.map(|s| (cost(s), s)).collect();
        profiles.sort_by(|a, b| a.0.total_cmp(&b.0));
        profiles.truncate(1);
        profiles
    });
    let profiled: Vec<Vec<(f64, &Considered)>> = profiled.collect();
    let mut profiled: Vec<(f64, &Considered)> = profiled.into_iter().flatten().collect();
    profiled.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(_, first)) = profiled.first() else {
        return Vec::new();
    };
    let mut rank = 0;
    // A relative at the same place may only lack the right shape.
    profiled.retain(|(_, one)| {
        rank += 1;
        rank <= SHORTLISTED || at.is_beside(one.candidate, first.candidate)
    });
    profiled
}

/// Whether a candidate may be worth its price, on samples that were not fitted as well.
pub(super) fn may_earn(one: &Considered) -> bool {
    one.score > MARGIN && one.held_out_gain.is_none_or(|gain| gain > MARGIN)
}

#[cfg(test)]
mod tests {
    use crate::trace::Verdict;
    use crate::trace::wheel::{rectangular, traced};
    use std::fmt::Write;

    const PENDULUM: &str = "\
model pendulum;
coordinate angle: rad;
parameter i: kg*m^2 = 1 in 0.01..;
parameter c: N*m = 2;
kinetic i/2*dot(angle)^2;
potential c*(1 - cos(angle));
";

    /// In two swings some force that lasts for half of one does all that friction does, and to first order
    /// friction is worth nothing beside it.
    #[test]
    fn friction_is_named_after_two_swings() {
        let mut text = String::from("t,q_angle\n");
        let mut noise = rectangular(4);
        let (mut q, mut v, step) = (0.5_f64, 0.0, 1e-3);
        for tick in 0..8000 {
            if tick % 10 == 0 {
                let t = step * f64::from(tick);
                writeln!(text, "{t:.3},{}", q + 1e-3 * noise()).unwrap();
            }
            // Leapfrog, with the friction of the middle of the step.
            let half = v + 0.5 * step * (-2.0 * q.sin() - 0.1 * v);
            q += step * half;
            v = (half - step * q.sin()) / (1.0 + 0.05 * step);
        }
        let outcome = traced(PENDULUM, &text);
        assert_eq!(outcome.verdict, Verdict::Effect, "{:#?}", outcome.unnamed);
        let [friction] = &outcome.findings[..] else {
            panic!("{:#?}", outcome.findings);
        };
        assert_eq!(friction.effect, "viscous");
        let d = &friction.parameters["d"];
        assert!((d.value - 0.1).abs() < 3.0 * d.std, "{d:?}");
    }
}
