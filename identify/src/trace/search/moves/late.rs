//! A sensor that is late by much.
//!
//! Applies where forces remain. A reading that is late by a good part of the motion's own time is
//! far from what a line says of it, and beside another thing that is missing even the sign of a
//! small step may be wrong. Times are few and bounded: they are tried as they are.

use super::Move;
use crate::log::rms;
use crate::regression::derivative;
use crate::trace::estimate::Observed;
use crate::trace::linearised::linearised;
use crate::trace::search::channel::timed_sensor;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::{
    GLANCE, LATE, MARGIN, MAX_TERMS, SHAPE_STEPS, SHORTLISTED, WORTH_A_FIT,
};
use crate::trace::settle::{Adapt, settle};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A sensor that is late by much.
pub struct Late;

/// A candidate that says how late a sensor is, and its time.
type Time = (usize, f64);

impl Move for Late {
    fn propose(&self, at: &Neighbourhood<'_>, explored: &Explored) -> Vec<Proposal> {
        let whole = &at.fitted.explanation.observed;
        let part = whole.excerpt(GLANCE);
        let observed = part.as_ref().unwrap_or(whole);
        let share = observed.record.len() as f64 / whole.record.len() as f64;
        let best = explored.kept().first();
        let gained = best.map_or(0.0, |best| at.fitted.score - best.score);
        let least = MARGIN.max(WORTH_A_FIT * share * gained);
        let all = 0..at.dictionary.candidates.len();
        let new = all.filter(|&candidate| !at.fitted.hypothesis.contains(candidate));
        let times = new.flat_map(|candidate| {
            let coordinate = timed_sensor(at.dictionary, candidate);
            let times = coordinate.map(|i| times(at, candidate, i, observed));
            let times = times.unwrap_or_default().into_iter();
            times.map(move |time| (candidate, time))
        });
        let times: Vec<Time> = times.collect();
        if times.is_empty() || at.terms().len() >= MAX_TERMS {
            return Vec::new();
        }
        let Some(now) = cost_if_late(at, None, observed) else {
            return Vec::new();
        };
        let cost = |late: Time| cost_if_late(at, Some(late), observed).unwrap_or(f64::INFINITY);
        let costs: Vec<f64> = times.par_iter().map(|&late| cost(late)).collect();
        let mut likely: Vec<(f64, Time)> = costs.into_iter().zip(times).collect();
        likely.retain(|(cost, _)| *cost < now - least);
        likely.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut seen = BTreeSet::new();
        likely.retain(|(_, (candidate, _))| seen.insert(*candidate));
        likely.truncate(SHORTLISTED);
        let likely = likely.into_iter().map(|(known, late)| {
            let (cost, (candidate, time)) = better(known, late, &cost);
            let parameter = at.dictionary.candidates[candidate].parameters[0];
            Proposal {
                hypothesis: at.fitted.hypothesis.exchange(&[], &[candidate]),
                values: at.with(&vec![(parameter, time)]),
                promise: cost,
                within_reach: at.fitted.estimate.cost,
            }
        });
        likely.collect()
    }
}

/// Times to try for a candidate that says how late a coordinate is read.
fn times(at: &Neighbourhood<'_>, candidate: usize, i: usize, observed: &Observed) -> Vec<f64> {
    let parameter = at.dictionary.candidates[candidate].parameters[0];
    let bounds = &at.dictionary.machine.compiled.model.parameters[parameter];
    let velocity = &observed.curve.v[i];
    let own = rms(velocity) / rms(&derivative(&observed.curve.t, velocity));
    let both = LATE.iter().flat_map(|share| [share * own, -share * own]);
    both.filter(|time| (bounds.lower..=bounds.upper).contains(time))
        .collect()
}

/// Negative log likelihood of a part of the log with one sensor late, and with the noise that
/// suits that.
fn cost_if_late(at: &Neighbourhood<'_>, late: Option<Time>, observed: &Observed) -> Option<f64> {
    let (mut observed, explanation) = (observed.clone(), &at.fitted.explanation);
    let mut values = explanation.values.clone();
    let mut hypothesis = at.fitted.hypothesis.clone();
    if let Some((candidate, time)) = late {
        values[at.dictionary.candidates[candidate].parameters[0]] = time;
        hypothesis = hypothesis.exchange(&[], &[candidate]);
    }
    let focus = at.dictionary.focus(hypothesis.candidates());
    observed.reread(&focus, &explanation.values, &values);
    let dynamics = linearised(&focus, &observed, &values).ok()?;
    let readings = observed.readings(&focus, &values, &dynamics.accelerations());
    let mut noise = explanation.noise.clone();
    noise.suit(&dynamics.mobility_scale);
    let settled = settle(&dynamics, &readings, &[], &mut noise, Adapt::ToData);
    Some(settled.cost()).filter(|cost| cost.is_finite())
}

/// A time beside one of a known `cost` that costs less.
fn better(known: f64, late: Time, cost: &(impl Fn(Time) -> f64 + Sync)) -> (f64, Time) {
    let (candidate, time) = late;
    let mut best = (known, time);
    let mut step = 0.25 * time.abs();
    for _ in 0..SHAPE_STEPS {
        let ways = [best.1 - step, best.1 + step].into_par_iter();
        let tried: Vec<(f64, f64)> = ways.map(|time| (cost((candidate, time)), time)).collect();
        let next = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match next.filter(|next| next.0 < best.0) {
            Some(next) => best = next,
            None => step *= 0.5,
        }
    }
    (best.0, (candidate, best.1))
}

#[cfg(test)]
mod tests {
    use super::better;

    #[test]
    fn the_cheapest_time_beside_one_is_found() {
        let cost = |(_, time): (usize, f64)| (time - 0.03).abs();
        let (left, (candidate, time)) = better(cost((7, 0.02)), (7, 0.02), &cost);
        assert_eq!(candidate, 7);
        assert!(left < 1e-3 && (time - 0.03).abs() < 1e-3, "{time}");
    }
}
