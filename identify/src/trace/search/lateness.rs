//! Times that something may be late by, tried as they are: far from what a line says of them.

use super::explored::Explored;
use super::neighbourhood::Neighbourhood;
use super::proposal::Proposal;
use crate::log::rms;
use crate::regression::derivative;
use crate::trace::estimate::Observed;
use crate::trace::linearised::linearised;
use crate::trace::settings::{GLANCE, LATE, MARGIN, SHAPE_STEPS, SHORTLISTED, WORTH_A_FIT};
use crate::trace::settle::{Adapt, settle};
use rayon::prelude::*;

/// A candidate that says how late channels are, and a time.
#[derive(Debug, Clone, Copy)]
pub struct Lateness {
    /// Which; it has one parameter.
    pub candidate: usize,
    /// s; negative, if early.
    pub time: f64,
}

/// A part of the log where a first glance is enough, and how the hypothesis in the middle does there.
pub struct Glance<'a> {
    at: &'a Neighbourhood<'a>,
    observed: Observed,
    /// Its share of the log.
    share: f64,
}

impl<'a> Glance<'a> {
    /// At the log of a fitted hypothesis.
    pub fn new(at: &'a Neighbourhood<'a>) -> Self {
        let whole = &at.fitted.explanation.observed;
        let observed = whole.excerpt(GLANCE).unwrap_or_else(|| whole.clone());
        let share = observed.record.len() as f64 / whole.record.len() as f64;
        Self {
            at,
            observed,
            share,
        }
    }

    /// The time that a coordinate takes for a radian of its mean wave, s.
    pub fn radian(&self, coordinate: usize) -> f64 {
        let curve = &self.observed.curve;
        let velocity = &curve.v[coordinate];
        rms(velocity) / rms(&derivative(&curve.t, velocity))
    }

    /// The least such time of all coordinates, s: late drives disturb first what moves quickest.
    pub fn quickest(&self) -> f64 {
        let coordinates = 0..self.at.dictionary.machine.coordinate_count();
        let each = coordinates.map(|i| self.radian(i));
        each.fold(f64::INFINITY, f64::min)
    }

    /// Shares of a `radian` that the channels of a candidate may be late by, and such that they may be early by.
    pub fn times(&self, candidate: usize, radian: f64) -> [Vec<Lateness>; 2] {
        let dictionary = self.at.dictionary;
        let parameter = dictionary.candidates[candidate].parameters[0];
        let bounds = &dictionary.machine.compiled.model.parameters[parameter];
        [radian, -radian].map(|radian| {
            let times = LATE.iter().map(|share| share * radian);
            let possible = times.filter(|time| (bounds.lower..=bounds.upper).contains(time));
            possible.map(|time| Lateness { candidate, time }).collect()
        })
    }

    /// Hypotheses with what is late that gains a share in the part of what the best one that was explored gains in
    /// all, each at the time beside it that costs least. Of `ways` from no time at all on, each with the least first:
    /// where that gains nothing, none of them is gone further.
    pub fn likely(&self, ways: Vec<Vec<Lateness>>, explored: &Explored) -> Vec<Proposal> {
        let Some(now) = ways.first().and_then(|_| self.cost(None)) else {
            return Vec::new();
        };
        let fitted = self.at.fitted;
        let best = explored.kept().first();
        let gained = best.map_or(0.0, |best| fitted.score - best.score);
        let least = MARGIN.max(WORTH_A_FIT * self.share * gained);
        let cost = |late: Lateness| self.cost(Some(late)).unwrap_or(f64::INFINITY);
        let along = ways.par_iter().map(|times| {
            let costs = |times: &[Lateness]| -> Vec<(f64, Lateness)> {
                times.par_iter().map(|&late| (cost(late), late)).collect()
            };
            let (first, others) = times.split_at(times.len().min(1));
            let mut known = costs(first);
            if known.iter().all(|(cost, _)| *cost < now - MARGIN) {
                known.extend(costs(others));
            }
            known
        });
        let mut likely: Vec<(f64, Lateness)> = along.flatten().collect();
        likely.retain(|(cost, _)| *cost < now - least);
        likely.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut seen = Vec::new();
        likely.retain(|(_, late)| {
            let is_new = !seen.contains(&late.candidate);
            seen.push(late.candidate);
            is_new
        });
        likely.truncate(SHORTLISTED);
        let at = self.at;
        let likely = likely
            .into_iter()
            .map(|(known, Lateness { candidate, time })| {
                let at_time = |time| cost(Lateness { candidate, time });
                let (cost, time) = better((known, time), &at_time);
                let parameter = at.dictionary.candidates[candidate].parameters[0];
                Proposal {
                    hypothesis: at.fitted.hypothesis.exchange(&[], &[candidate]),
                    values: at.with(&vec![(parameter, time)]),
                    promise: cost,
                    within_reach: at.fitted.estimate.cost,
                    ahead: 0.0,
                }
            });
        likely.collect()
    }

    /// Negative log likelihood of the part with something late, and with the noise that suits that.
    fn cost(&self, late: Option<Lateness>) -> Option<f64> {
        let at = self.at;
        let (mut observed, explanation) = (self.observed.clone(), &at.fitted.explanation);
        let mut values = explanation.values.clone();
        let mut hypothesis = at.fitted.hypothesis.clone();
        if let Some(Lateness { candidate, time }) = late {
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
}

/// Cost and time beside a known one that costs less.
fn better(known: (f64, f64), cost: &(impl Fn(f64) -> f64 + Sync)) -> (f64, f64) {
    let mut best = known;
    let mut step = 0.25 * known.1.abs();
    for _ in 0..SHAPE_STEPS {
        let ways = [best.1 - step, best.1 + step].into_par_iter();
        let tried: Vec<(f64, f64)> = ways.map(|time| (cost(time), time)).collect();
        let next = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match next.filter(|next| next.0 < best.0) {
            Some(next) => best = next,
            None => step *= 0.5,
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::better;

    #[test]
    fn the_cheapest_time_beside_one_is_found() {
        let cost = |time: f64| (time - 0.03).abs();
        let (left, time) = better((cost(0.02), 0.02), &cost);
        assert!(left < 1e-3 && (time - 0.03).abs() < 1e-3, "{time}");
    }
}
