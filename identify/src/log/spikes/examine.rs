//! Which samples of one channel are wild.

use super::stretch::Stretch;
use crate::log::quantum::quantisation_step;
use crate::log::statistics::{mad_sd, quantile};
use std::ops::Range;

/// A wild sample is this many times as far from what its neighbours say as samples ordinarily
/// are.
const FAR: f64 = 8.0;
/// It is also this many times as far as its neighbours are from what theirs say without it, less
/// what is ordinary: beside a corner or a step of the signal that is less than four times.
const ALONE: f64 = 6.0;
/// Times its ordinary distance by which a neighbour may be off.
pub(crate) const ORDINARY: f64 = 2.0;
/// Longest group of wild samples, and how many in it are wild at most.
const LONGEST: usize = 12;
const MOST: usize = 4;
/// Neighbours on each side of a group that must be ordinary.
pub(crate) const BESIDE: usize = 2;
/// Samples on each side over which the ordinary distance is taken.
const NEAR: usize = 30;
/// The share of samples there that are ordinary beyond doubt, and the standard deviations of
/// white noise within which as many are.
const QUIET: (f64, f64) = (0.75, 1.15);
/// A wild sample is this many times as far as nearly all others are, and how many are nearly all:
/// where a channel's errors are of all sizes none is wild.
const APART: (f64, f64) = (3.0, 0.99);
/// Fewest samples between two gaps that are looked at.
const FEWEST: usize = 12;
/// Wild samples hide others: how often the rest is looked at again.
const PASSES: usize = 4;
/// Above this share wild samples are what the channel is like.
pub(crate) const RARE: f64 = 0.05;

/// The wild samples of a channel: `is_real` says which groups are none although they stand out, and
/// less than a `share` of the channel's spread is too little to be looked at.
pub(super) fn wild(
    t: &[f64],
    values: &[f64],
    segments: &[Range<usize>],
    share: f64,
    is_real: &dyn Fn(&Range<usize>) -> bool,
) -> Vec<bool> {
    let mut aside = vec![false; values.len()];
    let least = (share * spread(values)).max(quantisation_step(values).unwrap_or(0.0));
    for range in segments.iter().filter(|range| range.len() >= FEWEST) {
        for _ in 0..PASSES {
            let stretch = Stretch {
                t: &t[range.clone()],
                values: &values[range.clone()],
                aside: &aside[range.clone()],
            };
            let real = |group: &Range<usize>| {
                is_real(&(range.start + group.start..range.start + group.end))
            };
            let found = found(&stretch, least, &real);
            if found.is_empty() {
                break;
            }
            for k in found {
                aside[range.start + k] = true;
            }
        }
    }
    keep_apart(t, values, segments, least, &mut aside);
    let count = aside.iter().filter(|&&a| a).count();
    if count as f64 > RARE * values.len() as f64 {
        aside.fill(false);
    }
    aside
}

/// The range of a channel's values but for the outermost, and for a constant what rounding may
/// make of it.
fn spread(values: &[f64]) -> f64 {
    let at = |share| quantile(values, share).unwrap_or(0.0);
    (at(0.95) - at(0.05)).max(1e-6 * at(0.5).abs())
}

/// Keeps those aside that are far from all others.
fn keep_apart(
    t: &[f64],
    values: &[f64],
    segments: &[Range<usize>],
    least: f64,
    aside: &mut [bool],
) {
    let mut departures = vec![0.0; values.len()];
    for range in segments {
        let stretch = Stretch {
            t: &t[range.clone()],
            values: &values[range.clone()],
            aside: &aside[range.clone()],
        };
        for k in 0..range.len() {
            departures[range.start + k] = stretch.departure(k, &(k..k)).unwrap_or(0.0).abs();
        }
    }
    let all = departures.iter().zip(aside.iter());
    let tame: Vec<f64> = all.filter(|&(_, a)| !a).map(|(d, _)| *d).collect();
    let most = quantile(&tame, APART.1).unwrap_or(0.0).max(least);
    for (aside, departure) in aside.iter_mut().zip(departures) {
        *aside &= departure > APART.0 * most;
    }
}

/// Wild samples that can be seen beside those known already.
fn found(stretch: &Stretch<'_>, least: f64, is_real: &dyn Fn(&Range<usize>) -> bool) -> Vec<usize> {
    let departures: Vec<f64> = (0..stretch.values.len())
        .map(|k| stretch.departure(k, &(k..k)).unwrap_or(0.0).abs())
        .collect();
    let scales = ordinary_sizes(&departures, stretch.aside, least);
    let mut found = Vec::new();
    let mut k = 0;
    while k < departures.len() {
        let group = match !stretch.aside[k] && departures[k] > FAR * scales[k] {
            true => group(stretch, &scales, k),
            false => None,
        };
        match group {
            Some((group, wild)) if !is_real(&group) => {
                k = group.end;
                found.extend(wild);
            }
            _ => k += 1,
        }
    }
    found
}

/// Whether a sample is wild that is so far from what is expected, where so far is ordinary, and its neighbours
/// are farther than is ordinary by so much.
pub(crate) fn stands_out(departure: f64, ordinary: f64, beside: f64) -> bool {
    departure > FAR * ordinary + ALONE * beside
}

/// How far samples ordinarily are from what is expected, nearby and over all, and at `least`.
pub(crate) fn ordinary_sizes(departures: &[f64], aside: &[bool], least: f64) -> Vec<f64> {
    let among = |range: Range<usize>, kept: &dyn Fn(usize) -> bool| -> Vec<f64> {
        let free = range.filter(|&k| !aside[k] && kept(k));
        free.map(|k| departures[k]).collect()
    };
    let n = departures.len();
    let overall = mad_sd(&among(0..n, &|_| true)).unwrap_or(0.0).max(least);
    let shaded = shaded(departures, aside, FAR * overall);
    let nearby = (0..n).map(|k| {
        // As many at the ends of the log as in its middle.
        let first = k.saturating_sub(NEAR).min(n.saturating_sub(2 * NEAR + 1));
        let range = first..(first + 2 * NEAR + 1).min(n);
        let all = among(range.clone(), &|_| true);
        let plain = among(range, &|k| !shaded[k]);
        let near = if 2 * plain.len() > all.len() {
            plain
        } else {
            all
        };
        let quiet = quantile(&near, QUIET.0).unwrap_or(0.0) / QUIET.1;
        quiet.max(overall)
    });
    nearby.collect()
}

/// Samples about those that stand out: their neighbours are off because of them. Four wild samples in a
/// short time would make all of it seem wild.
fn shaded(departures: &[f64], aside: &[bool], far: f64) -> Vec<bool> {
    let mut shaded = vec![false; departures.len()];
    for k in (0..departures.len()).filter(|&k| !aside[k] && departures[k] > far) {
        let near = k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(departures.len());
        let mut others = departures[near.clone()].iter();
        if others.all(|other| *other <= departures[k]) {
            shaded[near].fill(true);
        }
    }
    shaded
}

/// The shortest group of samples that begins with `first` and without which all is ordinary; with
/// those of it that are wild.
fn group(
    stretch: &Stretch<'_>,
    scales: &[f64],
    first: usize,
) -> Option<(Range<usize>, Vec<usize>)> {
    let n = stretch.values.len();
    (first + 1..=(first + LONGEST).min(n)).find_map(|end| {
        let group = first..end;
        let departure = |k: usize| Some(stretch.departure(k, &group)?.abs());
        let mut beside = 0.0_f64;
        for k in first.saturating_sub(BESIDE)..(end + BESIDE).min(n) {
            if !group.contains(&k) && !stretch.aside[k] {
                beside = beside.max(departure(k)? - ORDINARY * scales[k]);
            }
        }
        let mut wild = Vec::new();
        for k in group.clone().filter(|&k| !stretch.aside[k]) {
            if stands_out(departure(k)?, scales[k], beside) {
                wild.push(k);
            }
        }
        let at_both_ends = wild.first() == Some(&first) && wild.last() == Some(&(end - 1));
        let is_believed =
            || first >= BESIDE && end + BESIDE <= n || is_calm(stretch, scales, &group);
        (at_both_ends && wild.len() <= MOST && is_believed()).then_some((group, wild))
    })
}

/// Whether the samples on the only side of a group at an end of the log are as they are everywhere else.
/// Where a controller was switched on far from its goal all rings, and what two of its samples say of the
/// others is nothing.
fn is_calm(stretch: &Stretch<'_>, scales: &[f64], group: &Range<usize>) -> bool {
    let everywhere = scales.iter().copied().fold(f64::INFINITY, f64::min);
    let (first, end) = (group.start.saturating_sub(LONGEST), group.end + LONGEST);
    let mut near =
        (first..end.min(scales.len())).filter(|k| !group.contains(k) && !stretch.aside[*k]);
    near.all(|k| {
        let departure = stretch.departure(k, group).unwrap_or(0.0).abs();
        departure <= FAR * everywhere
    })
}
