//! One more term.
//!
//! Applies always. Beside a wheel with dry friction in its bearing: `coulomb(angle)`,
//! `stribeck(angle)` and what else looks like it to first order.

use super::Move;
use crate::trace::screen::Considered;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::{FAR_BEHIND, LEADER_SHARE, MARGIN, MAX_TERMS, PROFILED, SHORTLISTED};
use rayon::prelude::*;

/// One more term.
pub struct Add;

impl Move for Add {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        if at.terms().len() >= MAX_TERMS {
            return Vec::new();
        }
        let mut listed = shortlist(at);
        if !at.fitted.leaves_forces() {
            let known = at.fitted.estimate.cost;
            let price = MARGIN + (at.dictionary.candidates.len() as f64).ln();
            listed.retain(|(cost, _)| cost + price < known);
        }
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
    let earning = || at.considered.iter().filter(|one| may_earn(one));
    let best = earning().map(|c| c.gain).fold(0.0, f64::max);
    let rows = at.fitted.estimate.rows as f64;
    let leading = earning().filter(|c| c.gain > LEADER_SHARE * best);
    let leading: Vec<&Considered> = leading.take(PROFILED).collect();
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
    let Some(&(lowest, first)) = profiled.first() else {
        return Vec::new();
    };
    let mut rank = 0;
    // A relative at the same place may only lack the right shape.
    profiled.retain(|(cost, one)| {
        rank += 1;
        rank <= SHORTLISTED && *cost < lowest + FAR_BEHIND
            || at.is_beside(one.candidate, first.candidate)
    });
    profiled
}

/// Whether a candidate may be worth its price, on samples that were not fitted as well.
pub(super) fn may_earn(one: &Considered) -> bool {
    one.score > MARGIN && one.held_out_gain.is_none_or(|gain| gain > MARGIN)
}
