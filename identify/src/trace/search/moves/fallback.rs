//! One more term that does not lead to first order.
//!
//! Applies where no other did: a model that is far off says little about how likely the log is
//! beside a candidate before that is fitted. A four-bar whose closure is missed by millimetres
//! may rank the right payload tenth.

use super::Move;
use super::add::may_earn;
use crate::trace::screen::Considered;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::{MAX_TERMS, SHORTLISTED};

/// What does best on samples that were not fitted, and the leaders in other shapes.
pub struct Fallback;

impl Move for Fallback {
    fn propose(&self, at: &Neighbourhood<'_>, explored: &Explored) -> Vec<Proposal> {
        let leads_on = explored.kept().first();
        let leads_on = leads_on.is_some_and(|best| best.score < at.fitted.score);
        if leads_on || at.terms().len() >= MAX_TERMS {
            return Vec::new();
        }
        let is_new = |c: &&Considered| {
            let with = at.fitted.hypothesis.exchange(&[], &[c.candidate]);
            explored.of(&with).is_none()
        };
        let held_out = |c: &Considered| c.held_out_gain.unwrap_or(f64::NEG_INFINITY);
        let others = at.considered.iter().filter(|c| may_earn(c)).filter(is_new);
        let mut others: Vec<&Considered> = others.collect();
        others.sort_by(|a, b| held_out(b).total_cmp(&held_out(a)));
        others.truncate(SHORTLISTED);
        let leaders = at.considered.iter().filter(|c| !is_new(c));
        let reshaped = leaders
            .take(SHORTLISTED)
            .filter_map(|c| c.other_shapes.first());
        let all = others.into_iter().chain(reshaped);
        all.map(|one| at.addition(&[one], -one.score)).collect()
    }
}
