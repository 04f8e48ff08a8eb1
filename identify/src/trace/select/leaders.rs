//! Which candidates are worth a fit: by a linear fit, and then by one that adapts the noise.

use super::search::MARGIN;
use crate::trace::dictionary::Dictionary;
use crate::trace::screen::{Considered, Screen};
use rayon::prelude::*;

/// Candidates with at least this share of the best one's gain are looked at closely.
const LEADER_SHARE: f64 = 0.2;
/// How many of them have their noise adapted, and how many of these are fitted.
pub(super) const MAX_PROFILED: usize = 16;
pub(super) const MAX_LEADERS: usize = 5;
/// Nats behind the best profile beyond which a leader is not fitted.
const FAR_BEHIND: f64 = 200.0;

/// The leading candidates: by a linear fit, and then by one that adapts the noise.
pub(super) fn leaders<'a>(
    screen: &Screen<'_>,
    considered: &'a [Considered],
    dictionary: &Dictionary,
) -> Vec<&'a Considered> {
    let Some(best) = considered
        .iter()
        .filter(earns)
        .map(|c| c.gain)
        .max_by(f64::total_cmp)
    else {
        return Vec::new();
    };
    let rows = screen.dynamics.t.len() as f64;
    let worth_it: Vec<&Considered> = considered
        .iter()
        .filter(earns)
        .filter(|c| c.gain > LEADER_SHARE * best)
        .take(MAX_PROFILED)
        .collect();
    let mut profiled: Vec<(f64, &Considered)> = worth_it
        .into_par_iter()
        .map(|c| {
            let size = dictionary.candidates[c.candidate].parameters.len() as f64;
            let shapes = std::iter::once(c).chain(&c.other_shapes);
            let profiles = shapes.map(|shape| (screen.profile(&[shape]), shape));
            let mut profiles: Vec<(f64, &Considered)> = profiles
                .map(|(cost, shape)| (cost + 0.5 * size * rows.ln(), shape))
                .collect();
            profiles.sort_by(|a, b| a.0.total_cmp(&b.0));
            // Two shapes where shape has more than one dimension: valleys are narrow.
            let shapes = dictionary.candidates[c.candidate].shapes[0].len();
            profiles.truncate(shapes.clamp(1, 2));
            profiles
        })
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect();
    profiled.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(lowest, first)) = profiled.first() else {
        return Vec::new();
    };
    // A relative at the same place may only lack the right shape.
    let on = |c: &Considered| dictionary.candidates[c.candidate].subject.on();
    profiled
        .into_iter()
        .enumerate()
        .filter(|(rank, p)| {
            *rank < MAX_LEADERS && p.0 < lowest + FAR_BEHIND || on(p.1) == on(first)
        })
        .map(|(_, p)| p.1)
        .collect()
}

/// Those that did not lead, where none of the `leaders` came to anything: those first that did
/// best on samples not fitted. A model that is far off says little about how likely the log is
/// beside a candidate before that is fitted.
pub(super) fn followers<'a>(
    considered: &'a [Considered],
    leaders: &[&'a Considered],
) -> Vec<&'a Considered> {
    let leads = |c: &&Considered| leaders.iter().any(|l| l.candidate == c.candidate);
    let others = considered.iter().filter(earns).filter(|c| !leads(c));
    let mut others: Vec<&Considered> = others.collect();
    let held_out = |c: &Considered| c.held_out_gain.unwrap_or(f64::NEG_INFINITY);
    others.sort_by(|a, b| held_out(b).total_cmp(&held_out(a)));
    others.truncate(MAX_LEADERS);
    others
}

/// Whether a candidate may be worth its price, on samples that were not fitted as well.
fn earns(considered: &&Considered) -> bool {
    let held_out = considered.held_out_gain;
    considered.score > MARGIN && held_out.is_none_or(|gain| gain > MARGIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn followers_did_well_on_samples_not_fitted() {
        let one = |candidate: usize, score: f64, held_out_gain: Option<f64>| Considered {
            candidate,
            gain: score,
            score,
            held_out_gain,
            values: Vec::new(),
            columns: Vec::new(),
            other_shapes: Vec::new(),
        };
        let considered = [
            one(0, 100.0, Some(20.0)),
            one(1, 90.0, Some(15.0)),
            one(2, 80.0, None),
            one(3, 70.0, Some(60.0)),
            one(4, 60.0, Some(-5.0)),
            one(5, 1.0, Some(50.0)),
        ];
        let found = followers(&considered, &[&considered[0]]);
        let found: Vec<usize> = found.iter().map(|c| c.candidate).collect();
        assert_eq!(found, [3, 1, 2]);
    }
}
