//! One step after the other: what is tried, what earns its place, what goes again.

use super::TIE;
use super::fitting::{fit, fit_holding, linearised};
use super::leaders::{MAX_LEADERS, followers, leaders};
use crate::machine::SolveError;
use crate::trace::dictionary::{Candidate, Dictionary};
use crate::trace::estimate::Observed;
use crate::trace::progress::{Progress, Stage};
use crate::trace::refine::{Adapt, Estimate, Explanation, SMALLEST_SHARE, settle};
use crate::trace::screen::{Considered, Screen};
use rayon::prelude::*;

/// A term must bring this many nats beyond its price.
pub(in crate::trace) const MARGIN: f64 = 3.0;
/// A term must remove this share of the unexplained variance, where there is any:
/// otherwise one big effect, slightly misfit, breeds small false ones.
pub(super) const LEAST_REMOVED: f64 = 0.3;
/// Unless it makes the log this many nats per reading more likely: a model so far off that
/// even forces do not make up for it says little about their size.
const LEAP: f64 = 0.05;
/// Unexplained variance below this many times the smallest is none.
pub(super) const NO_EXCESS: f64 = 3.0;
/// Attempts that gain this share of what the best one gains come near it.
const NEAR_MISS: f64 = 0.9;
/// Share of the unexplained force, and steps, with which a fit is tried once more.
const SHARPER: f64 = 0.1;
const SHARP_STEPS: usize = 4;
/// How often a fit is continued at most.
const CONTINUATIONS: usize = 4;
/// How many other shapes are tried where the best one leads nowhere.
const OTHER_SHAPES: usize = 4;
/// How often at most.
const SHARPENINGS: usize = 3;

/// Candidates after their fit.
pub(super) struct Attempt {
    /// All of them, the new ones last.
    pub candidates: Vec<usize>,
    /// Negative log likelihood and price, nats.
    pub cost: f64,
    pub estimate: Estimate,
    pub explanation: Explanation,
    /// Whether [`Search::sharpened`] has already led nowhere.
    pub sharp: bool,
}

pub(super) struct Search<'a> {
    pub dictionary: &'a Dictionary,
    pub progress: &'a dyn Progress,
    pub accepted: Vec<usize>,
    pub current: Attempt,
    /// What the model as given costs, nats.
    pub given_cost: f64,
    /// What every candidate was worth beside the model as given.
    pub first_round: Vec<Considered>,
}

impl Search<'_> {
    pub(super) fn enter(&self, stage: Stage) {
        let subject = |&c: &usize| self.dictionary.candidates[c].subject.to_string();
        let found: Vec<String> = self.accepted.iter().map(subject).collect();
        self.progress.enter(stage, &found);
    }

    /// Accepts the terms of an attempt.
    pub(super) fn take(&mut self, attempt: Attempt) {
        self.accepted.clone_from(&attempt.candidates);
        self.current = attempt;
    }

    /// Fits the accepted terms to another part of the log.
    pub(super) fn look_at(&mut self, observed: Observed) -> Result<(), SolveError> {
        let mut explanation = self.current.explanation.clone();
        let hold = explanation.observed.hold;
        explanation.observed = Observed { hold, ..observed };
        self.current = self.sharpened(fit(self.dictionary, &self.accepted, explanation)?);
        Ok(())
    }

    /// Mean squared innovation, and negative log likelihood, if sensor noise alone is to
    /// blame for what remains.
    pub(super) fn at_floor(&self) -> Result<(f64, f64), SolveError> {
        let Explanation {
            observed, values, ..
        } = &self.current.explanation;
        let focus = self.dictionary.focus(&self.accepted);
        let dynamics = linearised(&focus, observed, values)?;
        let readings = observed.readings(&focus, values, &dynamics.accelerations());
        let mut noise = self.current.explanation.noise.at_smallest();
        let settled = settle(&dynamics, &readings, &[], &mut noise, Adapt::Not);
        let rows = settled.gram.readings().max(1) as f64;
        Ok((settled.gram.data_misfit() / rows, settled.cost()))
    }

    /// All candidates' worth now, and the explanation with the best of them if it earns
    /// its place.
    pub(super) fn step(&self) -> Result<(Vec<Considered>, Option<Attempt>), SolveError> {
        self.enter(Stage::Screen);
        let screen = Screen::new(self.dictionary, &self.current.explanation, &self.accepted)?;
        let considered = screen.considered(&screen.grams());
        let leaders = leaders(&screen, &considered, self.dictionary);
        self.enter(Stage::Fit);
        let mut tried = self.attempts(&leaders);
        tried.extend(self.swaps(&considered));
        let parted = |mut tried: Vec<Attempt>| -> (Vec<Attempt>, Vec<Attempt>) {
            tried.retain(|attempt| self.is_possible(attempt));
            tried.into_iter().partition(|attempt| self.earns(attempt))
        };
        let (mut tried, mut likely) = parted(tried);
        if tried.is_empty() {
            let (more, as_likely) = parted(self.attempts(&followers(&considered, &leaders)));
            tried = more;
            likely.extend(as_likely);
        }
        let best = tried.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        if best.is_none_or(leaves_forces) {
            let gained = best.map_or(0.0, |best| self.current.cost - best.cost);
            let late = self.late_sensors(gained);
            let (more, as_likely) = parted(self.attempts(&late.iter().collect::<Vec<_>>()));
            tried.extend(more);
            likely.extend(as_likely);
        }
        let mut tried = self.sharpened_near_misses(tried);
        let lowest = tried.iter().map(|a| a.cost).min_by(f64::total_cmp);
        let Some(lowest) = lowest else {
            if !self.accepted.is_empty() {
                return Ok((considered, None));
            }
            // Beside the other of two that are missing neither may be likely.
            let both = self.at_once(&screen, &self.current, &considered);
            let both = both.map(|both| self.sharpened(both));
            let both = both.or_else(|| self.looking_ahead(likely, &considered));
            return Ok((considered, both));
        };
        // The simplest of those that explain the log equally well.
        let position = tried
            .iter()
            .enumerate()
            .filter(|(_, a)| a.cost < lowest + TIE)
            .min_by(|(_, a), (_, b)| {
                let size = |a: &Attempt| a.estimate.parameters.len();
                size(a).cmp(&size(b)).then(a.cost.total_cmp(&b.cost))
            })
            .map(|(position, _)| position);
        let Some(whole) = position.map(|position| tried.swap_remove(position)) else {
            return Ok((considered, None));
        };
        let chosen = match self.in_two_parts(&screen, &whole, &considered) {
            Some(parts) => parts,
            None => whole,
        };
        let chosen = self.sharpened(chosen);
        let is_new = |c: &usize| !self.accepted.contains(c);
        let new: Vec<usize> = chosen.candidates.iter().copied().filter(is_new).collect();
        let chosen = self.with_kin(&chosen, &new).unwrap_or(chosen);
        let new: Vec<usize> = chosen.candidates.iter().copied().filter(is_new).collect();
        let chosen = self.simplified(&chosen, &new).unwrap_or(chosen);
        let both = self.at_once(&screen, &chosen, &considered);
        let both = both.map(|both| self.sharpened(both));
        Ok((considered, Some(both.unwrap_or(chosen))))
    }

    /// The accepted terms with one more, for each of these under which the machine can move.
    fn attempts(&self, more: &[&Considered]) -> Vec<Attempt> {
        let tried = more.par_iter();
        let tried = tried.map(|one| self.attempt_in_some_shape(one).ok());
        tried.collect::<Vec<_>>().into_iter().flatten().collect()
    }

    /// Where none of the attempts leaves sensor noise alone, those that come near the best one
    /// get the same chance to go on.
    fn sharpened_near_misses(&self, tried: Vec<Attempt>) -> Vec<Attempt> {
        let best = tried.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        let Some(best) = best.filter(|best| leaves_forces(best)) else {
            return tried;
        };
        let limit = self.current.cost - NEAR_MISS * (self.current.cost - best.cost);
        let tried = tried
            .into_par_iter()
            .map(|attempt| match attempt.cost < limit {
                true => self.sharpened(attempt),
                false => attempt,
            });
        tried.collect()
    }

    /// What a term must bring beyond its price: also as much as forces leave that are too small
    /// to be worth a name, beside all that the terms explain.
    fn margin(&self) -> f64 {
        let explained = (self.given_cost - self.current.cost).max(0.0);
        MARGIN + SMALLEST_SHARE * SMALLEST_SHARE * explained
    }

    /// Whether an attempt is worth its price.
    pub(super) fn earns(&self, attempt: &Attempt) -> bool {
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let (before, after) = (
            self.current.estimate.unexplained,
            attempt.estimate.unexplained,
        );
        let something = before > NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE;
        let leap = LEAP * attempt.estimate.rows as f64;
        attempt.cost + search_price + self.margin() < self.current.cost
            && (!something
                || after < (1.0 - LEAST_REMOVED) * before
                || attempt.cost + leap < self.current.cost)
    }

    /// Whether every new strength has left its default, and no bound of nature was hit.
    pub(super) fn is_possible(&self, attempt: &Attempt) -> bool {
        let model = &self.dictionary.machine.compiled.model;
        let new = |c: &&usize| !self.accepted.contains(c);
        if attempt.candidates == self.accepted {
            return false;
        }
        attempt.candidates.iter().filter(new).all(|&candidate| {
            let candidate = &self.dictionary.candidates[candidate];
            let inside = |&p: &usize| {
                let (value, parameter) = (attempt.explanation.values[p], &model.parameters[p]);
                value != self.dictionary.defaults[p]
                    && value > parameter.lower
                    && value < parameter.upper
            };
            candidate.strengths.iter().any(inside)
        })
    }

    /// The same with one more; where its best shape leads nowhere, in its other ones.
    pub(super) fn attempt_in_some_shape(&self, leader: &Considered) -> Result<Attempt, SolveError> {
        let best = self.attempt(&[leader]);
        let leads = |a: &Attempt| a.cost < self.current.cost;
        if let Ok(attempt) = &best
            && leads(attempt)
        {
            let is_placed = leaves_forces(attempt) && self.is_on_a_body(leader.candidate);
            let placed = is_placed.then(|| self.placed_better(leader, attempt));
            return placed.flatten().map_or(best, Ok);
        }
        let others = leader.other_shapes.par_iter().take(OTHER_SHAPES);
        let others = others.map(|shape| self.attempt(&[shape]).ok());
        let others: Vec<Option<Attempt>> = others.collect();
        let others = others.into_iter().flatten().filter(leads);
        others
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
            .map_or(best, Ok)
    }

    /// The accepted terms and some more, fitted together.
    pub(super) fn attempt(&self, more: &[&Considered]) -> Result<Attempt, SolveError> {
        let mut explanation = self.current.explanation.clone();
        let mut candidates = self.accepted.clone();
        for leader in more {
            for &(parameter, value) in &leader.values {
                explanation.values[parameter] = value;
            }
            candidates.push(leader.candidate);
        }
        let focus = self.dictionary.focus(&candidates);
        let Explanation {
            observed, values, ..
        } = &mut explanation;
        observed.reread(&focus, &self.current.explanation.values, values);
        fit(self.dictionary, &candidates, explanation)
    }

    /// Leading candidates in the stead of a term at the same place: a rich effect may be
    /// what a simple one was taken for.
    pub(super) fn swaps(&self, considered: &[Considered]) -> Vec<Attempt> {
        let on = |candidate: usize| self.dictionary.candidates[candidate].subject.on();
        let earns = |c: &&Considered| c.score > MARGIN;
        let mut pairs = Vec::new();
        for leader in considered.iter().filter(earns).take(MAX_LEADERS) {
            let afresh = self
                .first_round
                .iter()
                .find(|c| c.candidate == leader.candidate);
            let term = self
                .accepted
                .iter()
                .find(|&&term| on(term) == on(leader.candidate));
            if let (Some(afresh), Some(&term)) = (afresh, term) {
                pairs.push((afresh, term));
            }
        }
        let swapped = pairs.into_par_iter().map(|(leader, term)| {
            let mut explanation = self.current.explanation.clone();
            reset(self.dictionary, &mut explanation, term);
            for &(parameter, value) in &leader.values {
                explanation.values[parameter] = value;
            }
            let others = self.accepted.iter().copied().filter(|&t| t != term);
            let candidates: Vec<usize> = others.chain([leader.candidate]).collect();
            fit(self.dictionary, &candidates, explanation).ok()
        });
        swapped.collect::<Vec<_>>().into_iter().flatten().collect()
    }

    /// The attempt fitted once more, also under less noise: as long as much counts as
    /// unexplained, the fit may rest too early.
    pub(super) fn sharpened(&self, attempt: Attempt) -> Attempt {
        if attempt.sharp || !leaves_forces(&attempt) {
            return attempt;
        }
        let mut attempt = attempt;
        for _ in 0..SHARPENINGS {
            let mut sharper = attempt.explanation.clone();
            sharper.noise = sharper.noise.times(SHARPER);
            let starts = [(attempt.explanation.clone(), 0), (sharper, SHARP_STEPS)];
            let again = starts.into_par_iter().map(|(explanation, held)| {
                fit_holding(self.dictionary, &attempt.candidates, explanation, held).ok()
            });
            let again = again.collect::<Vec<_>>().into_iter().flatten();
            match again.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
                Some(again) if again.cost < attempt.cost - 1.0 => attempt = again,
                _ => {
                    attempt.sharp = true;
                    break;
                }
            }
        }
        attempt
    }

    /// The attempt fitted on until nothing is gained: a long valley takes more steps than one
    /// fit has.
    pub(super) fn converged(&self, attempt: Attempt) -> Attempt {
        let mut attempt = attempt;
        for _ in 0..CONTINUATIONS {
            let again = fit(
                self.dictionary,
                &attempt.candidates,
                attempt.explanation.clone(),
            );
            match again {
                Ok(again) if again.cost < attempt.cost - 1.0 => attempt = again,
                _ => break,
            }
        }
        attempt
    }

    /// Evidence of each accepted term given the others; those that no longer earn their
    /// place go, the weakest first.
    pub(super) fn prune(&mut self) -> Vec<f64> {
        loop {
            let without = |&term: &usize| {
                let mut explanation = self.current.explanation.clone();
                reset(self.dictionary, &mut explanation, term);
                let rest: Vec<usize> = self
                    .accepted
                    .iter()
                    .copied()
                    .filter(|&t| t != term)
                    .collect();
                // Where the machine cannot move without a term, it is needed.
                fit(self.dictionary, &rest, explanation).ok()
            };
            let mut without_each: Vec<Option<Attempt>> =
                self.accepted.par_iter().map(without).collect();
            let evidence: Vec<f64> = without_each
                .iter()
                .map(|w| w.as_ref().map_or(f64::INFINITY, |w| w.cost) - self.current.cost)
                .collect();
            let weakest = (0..evidence.len()).min_by(|&a, &b| evidence[a].total_cmp(&evidence[b]));
            match weakest {
                Some(weakest) if evidence[weakest] < self.margin() => {
                    let Some(without) = without_each.swap_remove(weakest) else {
                        return evidence;
                    };
                    self.accepted.remove(weakest);
                    self.current = without;
                }
                _ => return evidence,
            }
        }
    }
}

/// Whether more than sensor noise remains.
pub(super) fn leaves_forces(attempt: &Attempt) -> bool {
    attempt.estimate.unexplained > NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE
}

pub(super) fn reset(dictionary: &Dictionary, explanation: &mut Explanation, candidate: usize) {
    let Candidate { parameters, .. } = &dictionary.candidates[candidate];
    for &parameter in parameters {
        explanation.values[parameter] = dictionary.defaults[parameter];
    }
}
