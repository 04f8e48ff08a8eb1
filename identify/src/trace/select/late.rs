//! Sensors that are late by much.
//!
//! A reading that is late by a good part of the motion's own time is far from what a line says
//! of it, and beside another thing that is missing even the sign of a small step may be wrong.
//! Times are few and bounded: they are tried as they are.

use super::fitting::linearised;
use super::search::{MARGIN, Search};
use crate::log::rms;
use crate::regression::derivative;
use crate::trace::estimate::Observed;
use crate::trace::refine::{Adapt, settle};
use crate::trace::screen::Considered;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Times to try, as shares of the time that the motion of the coordinate takes for a radian of
/// its mean wave.
const SHARES: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];
/// Samples that are looked at.
const SAMPLES: usize = 1500;
/// Share of what the best fit gains that a time from the grid must bring to be fitted itself.
const WORTH_A_FIT: f64 = 0.5;
/// How many late sensors are fitted.
const FITTED: usize = 2;
/// Steps of the search for a time; each goes one way or halves its length.
const STEPS: usize = 9;

/// A candidate that says how late a sensor is, and its time.
type Late = (usize, f64);

impl Search<'_> {
    /// The sensors that are likely to be late, by the time that explains most, the likeliest
    /// first. A time by itself must bring a good part of what the best fit so far has `gained`.
    pub(super) fn late_sensors(&self, gained: f64) -> Vec<Considered> {
        let whole = &self.current.explanation.observed;
        let part = whole.excerpt(SAMPLES);
        let observed = part.as_ref().unwrap_or(whole);
        let share = observed.record.len() as f64 / whole.record.len() as f64;
        let least = MARGIN.max(WORTH_A_FIT * share * gained);
        let all = 0..self.dictionary.candidates.len();
        let new = all.filter(|candidate| !self.accepted.contains(candidate));
        let times = new.flat_map(|candidate| {
            let coordinate = self.late_sensor(candidate);
            let times = coordinate.map(|i| self.times(candidate, i, observed));
            let times = times.unwrap_or_default().into_iter();
            times.map(move |time| (candidate, time))
        });
        let times: Vec<Late> = times.collect();
        let Some(now) = self.cost_if_late(None, observed) else {
            return Vec::new();
        };
        let cost = |late: Late| {
            self.cost_if_late(Some(late), observed)
                .unwrap_or(f64::INFINITY)
        };
        let costs: Vec<f64> = times.par_iter().map(|&late| cost(late)).collect();
        let mut likely: Vec<(f64, Late)> = costs.into_iter().zip(times).collect();
        likely.retain(|(cost, _)| *cost < now - least);
        likely.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut seen = BTreeSet::new();
        likely.retain(|(_, (candidate, _))| seen.insert(*candidate));
        likely.truncate(FITTED);
        let likely = likely.into_iter().map(|(known, late)| {
            let (cost, (candidate, time)) = better(known, late, &cost);
            let parameter = self.dictionary.candidates[candidate].parameters[0];
            Considered {
                candidate,
                gain: now - cost,
                score: now - cost,
                held_out_gain: None,
                values: vec![(parameter, time)],
                columns: Vec::new(),
                other_shapes: Vec::new(),
            }
        });
        likely.collect()
    }

    /// Times to try for a candidate that says how late a coordinate is read.
    fn times(&self, candidate: usize, coordinate: usize, observed: &Observed) -> Vec<f64> {
        let parameter = self.dictionary.candidates[candidate].parameters[0];
        let bounds = &self.dictionary.machine.compiled.model.parameters[parameter];
        let velocity = &observed.curve.v[coordinate];
        let own = rms(velocity) / rms(&derivative(&observed.curve.t, velocity));
        let both = SHARES.iter().flat_map(|share| [share * own, -share * own]);
        both.filter(|time| (bounds.lower..=bounds.upper).contains(time))
            .collect()
    }

    /// Negative log likelihood of a part of the log with one sensor late, and with the noise that
    /// suits that.
    fn cost_if_late(&self, late: Option<Late>, observed: &Observed) -> Option<f64> {
        let (mut observed, explanation) = (observed.clone(), &self.current.explanation);
        let mut values = explanation.values.clone();
        let mut candidates = self.accepted.clone();
        if let Some((candidate, time)) = late {
            values[self.dictionary.candidates[candidate].parameters[0]] = time;
            candidates.push(candidate);
        }
        let focus = self.dictionary.focus(&candidates);
        observed.reread(&focus, &explanation.values, &values);
        let dynamics = linearised(&focus, &observed, &values).ok()?;
        let readings = observed.readings(&focus, &values, &dynamics.accelerations());
        let mut noise = explanation.noise.clone();
        noise.suit(&dynamics.mobility_scale);
        let settled = settle(&dynamics, &readings, &[], &mut noise, Adapt::ToData);
        Some(settled.cost()).filter(|cost| cost.is_finite())
    }
}

/// A time beside one of a known `cost` that costs less.
fn better(known: f64, late: Late, cost: &(impl Fn(Late) -> f64 + Sync)) -> (f64, Late) {
    let (candidate, time) = late;
    let mut best = (known, time);
    let mut step = 0.25 * time.abs();
    for _ in 0..STEPS {
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
