//! Forward selection with re-judgement: which candidates earn their place?
//!
//! Every hypothesis carries forces that nothing explains, as large as the log demands
//! under it. A term is worth what it adds to the likelihood when that size is chosen
//! anew: the right name leaves sensor noise alone, a wrong one leaves forces.

use super::dictionary::{Candidate, Dictionary, Subject};
use super::estimate::Observed;
use super::focus::Focus;
use super::progress::{Progress, Stage};
use super::refine::{
    Adapt, Estimate, Explanation, SMALLEST_SHARE, floor, refine, refine_curve, settle,
};
use super::rivals::rivals;
use super::screen::{Considered, Pair, Screen};
use crate::machine::SolveError;
use crate::regression::{Columns, ErrorDynamics, Hold, ProcessNoise};
use nalgebra::DVector;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A term that was accepted.
#[derive(Debug, Clone)]
pub struct Term {
    /// Which candidate.
    pub candidate: usize,
    /// Evidence in nats: how much worse the log would be explained without it,
    /// less what its parameters cost.
    pub evidence: f64,
    /// Subjects that explain what it explains about as well, with the evidence
    /// each would have had in its stead.
    pub rivals: Vec<(Subject, f64)>,
}

/// What the accepted terms leave.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Remaining {
    /// Root mean square of the accelerations that unexplained forces make, as a share of
    /// the machine's own, under the model as given.
    pub share_before: f64,
    /// The same with all terms.
    pub share_after: f64,
    /// Nats by which the log is more likely with unexplained forces beside the terms
    /// than with sensor noise alone.
    pub evidence: f64,
}

/// The outcome.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Accepted terms, strongest first.
    pub terms: Vec<Term>,
    /// Values of all parameters of the extended model.
    pub values: Vec<f64>,
    /// What is known of the accepted terms' parameters.
    pub estimate: Estimate,
    /// Mean squared whitened innovation with the accepted terms; one if sensor noise
    /// explains what remains.
    pub reduced_misfit: f64,
    /// The same with no term at all.
    pub nominal_misfit: f64,
    /// The forces that nothing explains.
    pub noise: ProcessNoise,
    /// How much that is.
    pub remaining: Remaining,
    /// The first round's candidates, best first.
    pub considered: Vec<Considered>,
    /// The log with the curve through it.
    pub observed: Observed,
}

/// Nats within which two explanations count as equal.
pub(super) const TIE: f64 = 6.0;
/// A term must bring this many nats beyond its price.
const MARGIN: f64 = 3.0;
/// Candidates with at least this share of the best one's gain are looked at closely.
const LEADER_SHARE: f64 = 0.2;
/// How many of them have their noise adapted, and how many of these are fitted.
const MAX_PROFILED: usize = 16;
const MAX_LEADERS: usize = 5;
/// A pair in the stead of a rich effect must have this share of its gain by a linear fit.
const PAIR_SHARE: f64 = 0.9;
/// How many candidates are looked at two at a time.
const MAX_PAIRED: usize = 64;
/// Nats behind the best profile beyond which a leader is not fitted.
const FAR_BEHIND: f64 = 200.0;
/// Terms at most.
const MAX_TERMS: usize = 12;
/// A term must remove this share of the unexplained variance, where there is any:
/// otherwise one big effect, slightly misfit, breeds small false ones.
const LEAST_REMOVED: f64 = 0.3;
/// Unexplained variance below this many times the smallest is none.
const NO_EXCESS: f64 = 3.0;

/// Share of the unexplained force, and steps, with which a fit is tried once more.
const SHARPER: f64 = 0.1;
const SHARP_STEPS: usize = 4;
/// How often at most.
const SHARPENINGS: usize = 3;

/// Candidates after their fit.
struct Attempt {
    /// All of them, the new ones last.
    candidates: Vec<usize>,
    /// Negative log likelihood and price, nats.
    cost: f64,
    estimate: Estimate,
    explanation: Explanation,
}

struct Search<'a> {
    dictionary: &'a Dictionary,
    progress: &'a dyn Progress,
    accepted: Vec<usize>,
    current: Attempt,
    /// What every candidate was worth beside the model as given.
    first_round: Vec<Considered>,
}

/// Selects terms for `observed`. What inputs do between samples is asked again with
/// every term if `free_hold`: while much is unexplained the log cannot tell.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn select(
    dictionary: &Dictionary,
    observed: Observed,
    free_hold: bool,
    progress: &dyn Progress,
) -> Result<Selection, SolveError> {
    progress.enter(Stage::Fit, &[]);
    let part = observed.excerpt(search_samples(dictionary));
    let is_part = part.is_some();
    let begin = |observed: Observed| -> Result<Search<'_>, SolveError> {
        let start = Explanation {
            noise: first_noise(dictionary, &observed)?,
            values: dictionary.defaults.clone(),
            observed,
        };
        Ok(Search {
            dictionary,
            progress,
            accepted: Vec::new(),
            first_round: Vec::new(),
            current: fit(dictionary, &[], start)?,
        })
    };
    let mut search = begin(part.unwrap_or_else(|| observed.clone()))?;
    let mut given = Given::of(&search)?;
    loop {
        let (considered, better) = search.step()?;
        if search.first_round.is_empty() {
            search.first_round = considered;
        }
        let Some(better) = better else { break };
        search.accepted.clone_from(&better.candidates);
        search.current = better;
        if free_hold {
            search.ask_about_hold();
        }
        if search.accepted.len() >= MAX_TERMS {
            break;
        }
    }
    search.enter(Stage::Question);
    let evidence = search.prune();
    let mut alike = rivals(dictionary, &search.current.explanation, &search.accepted)?;
    if is_part {
        search.enter(Stage::Settle);
        search.look_at(observed.clone())?;
        given = Given::of(&begin(observed)?)?;
    }
    let (reduced_misfit, cost_at_floor) = search.at_floor()?;
    let remaining = Remaining {
        share_before: given.unexplained.max(0.0).sqrt(),
        share_after: search.current.estimate.unexplained.max(0.0).sqrt(),
        evidence: cost_at_floor - search.current.estimate.cost,
    };
    let mut terms: Vec<Term> = search
        .accepted
        .iter()
        .enumerate()
        .map(|(i, &candidate)| Term {
            candidate,
            evidence: evidence[i],
            rivals: std::mem::take(&mut alike[i]),
        })
        .collect();
    terms.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let Attempt {
        explanation,
        estimate,
        ..
    } = search.current;
    Ok(Selection {
        terms,
        values: explanation.values,
        reduced_misfit,
        estimate,
        nominal_misfit: given.misfit,
        noise: explanation.noise,
        remaining,
        considered: search.first_round,
        observed: explanation.observed,
    })
}

impl Selection {
    /// Which candidates were accepted.
    pub fn accepted(&self) -> Vec<usize> {
        self.terms.iter().map(|term| term.candidate).collect()
    }
}

/// Samples that are searched in, where there are many more: of a machine with many
/// coordinates fewer, as each costs more and says more.
fn search_samples(dictionary: &Dictionary) -> usize {
    let n = dictionary.machine.coordinate_count();
    (SEARCHED / (n * n)).max(FEWEST_SEARCHED)
}

const SEARCHED: usize = 100_000;
const FEWEST_SEARCHED: usize = 1000;

/// What the model as given leaves.
struct Given {
    misfit: f64,
    unexplained: f64,
}

impl Given {
    fn of(search: &Search<'_>) -> Result<Self, SolveError> {
        Ok(Self {
            misfit: search.at_floor()?.0,
            unexplained: search.current.estimate.unexplained,
        })
    }
}

/// Some unexplained force to begin with.
fn first_noise(dictionary: &Dictionary, observed: &Observed) -> Result<ProcessNoise, SolveError> {
    let dynamics = linearised(&dictionary.focus(&[]), observed, &dictionary.defaults)?;
    Ok(ProcessNoise {
        force_sd: dynamics.force_scale * FIRST_SHARE,
    })
}

const FIRST_SHARE: f64 = 0.1;

/// The departure's equation, without columns, for `focus` with these of the dictionary's
/// values.
pub(super) fn linearised(
    focus: &Focus,
    observed: &Observed,
    values: &[f64],
) -> Result<ErrorDynamics, SolveError> {
    let none: [Columns<'_>; 0] = [];
    ErrorDynamics::new(
        &focus.machine,
        &focus.slopes,
        &none,
        &observed.curve,
        observed.hold,
        &focus.values(values),
    )
}

/// Fits the parameters of some candidates, noise and curve.
fn fit(
    dictionary: &Dictionary,
    candidates: &[usize],
    explanation: Explanation,
) -> Result<Attempt, SolveError> {
    fit_holding(dictionary, candidates, explanation, 0)
}

/// The same with the noise held for the first few steps.
fn fit_holding(
    dictionary: &Dictionary,
    candidates: &[usize],
    mut explanation: Explanation,
    held: usize,
) -> Result<Attempt, SolveError> {
    let estimate = refine(dictionary, candidates, &mut explanation, held)?;
    Ok(Attempt {
        candidates: candidates.to_vec(),
        cost: estimate.cost + 0.5 * estimate.parameters.len() as f64 * (estimate.rows as f64).ln(),
        estimate,
        explanation,
    })
}

impl Search<'_> {
    fn enter(&self, stage: Stage) {
        let subject = |&c: &usize| self.dictionary.candidates[c].subject.to_string();
        let found: Vec<String> = self.accepted.iter().map(subject).collect();
        self.progress.enter(stage, &found);
    }

    /// Fits the accepted terms to another part of the log.
    fn look_at(&mut self, observed: Observed) -> Result<(), SolveError> {
        let mut explanation = self.current.explanation.clone();
        let hold = explanation.observed.hold;
        explanation.observed = Observed { hold, ..observed };
        self.current = self.sharpened(fit(self.dictionary, &self.accepted, explanation)?);
        Ok(())
    }

    /// Mean squared innovation, and negative log likelihood, if sensor noise alone is to
    /// blame for what remains.
    fn at_floor(&self) -> Result<(f64, f64), SolveError> {
        let Explanation {
            observed, values, ..
        } = &self.current.explanation;
        let focus = self.dictionary.focus(&self.accepted);
        let dynamics = linearised(&focus, observed, values)?;
        let readings = observed.readings(&focus, values, &dynamics.accelerations());
        let settled = settle(&dynamics, &readings, &[], &mut floor(&dynamics), Adapt::Not);
        let rows = settled.gram.rows().max(1) as f64;
        Ok((settled.gram.data_misfit() / rows, settled.cost()))
    }

    /// All candidates' worth now, and the explanation with the best of them if it earns
    /// its place.
    fn step(&self) -> Result<(Vec<Considered>, Option<Attempt>), SolveError> {
        self.enter(Stage::Screen);
        let screen = Screen::new(self.dictionary, &self.current.explanation, &self.accepted)?;
        let considered = screen.considered(&screen.grams());
        let leaders = leaders(&screen, &considered, self.dictionary);
        self.enter(Stage::Fit);
        // A candidate under which the machine cannot move is no explanation.
        let tried = leaders
            .into_par_iter()
            .map(|leader| self.attempt(&[leader]).ok());
        let mut tried: Vec<Attempt> = tried.collect::<Vec<_>>().into_iter().flatten().collect();
        tried.extend(self.swaps(&considered));
        tried.retain(|attempt| self.is_possible(attempt) && self.earns(attempt));
        let lowest = tried.iter().map(|a| a.cost).min_by(f64::total_cmp);
        let Some(lowest) = lowest else {
            return Ok((considered, None));
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
        let both = self.at_once(&screen, &chosen, &considered);
        let both = both.map(|both| self.sharpened(both));
        Ok((considered, Some(both.unwrap_or(chosen))))
    }

    /// Whether an attempt is worth its price.
    fn earns(&self, attempt: &Attempt) -> bool {
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let (before, after) = (
            self.current.estimate.unexplained,
            attempt.estimate.unexplained,
        );
        let something = before > NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE;
        attempt.cost + search_price + MARGIN < self.current.cost
            && (!something || after < (1.0 - LEAST_REMOVED) * before)
    }

    /// Whether every new strength has left its default, and no bound of nature was hit.
    fn is_possible(&self, attempt: &Attempt) -> bool {
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

    /// Two simple effects at the place of a rich one that explain the log as well with
    /// fewer parameters: Coulomb and viscous friction, not Stribeck's.
    fn in_two_parts(
        &self,
        screen: &Screen<'_>,
        whole: &Attempt,
        considered: &[Considered],
    ) -> Option<Attempt> {
        let &rich = whole.candidates.last()?;
        let rich_gain = considered.iter().find(|c| c.candidate == rich)?.gain;
        let on = self.dictionary.candidates[rich].subject.on();
        let size = |c: &Considered| self.dictionary.candidates[c.candidate].size();
        let rich_size = self.dictionary.candidates[rich].size();
        let simple: Vec<&Considered> = considered
            .iter()
            .filter(|c| c.candidate != rich && c.gain > 0.0)
            .filter(|c| self.dictionary.candidates[c.candidate].subject.on() == on)
            .collect();
        let mut pairs = screen.pairs(&simple, |a, b| size(a) + size(b) < rich_size);
        pairs.retain(|pair| pair.gain > PAIR_SHARE * rich_gain);
        pairs.truncate(MAX_LEADERS);
        let parts = self.attempt_pairs(&pairs);
        parts
            .filter(|parts| parts.cost < whole.cost + TIE)
            .filter(|parts| self.is_possible(parts) && self.earns(parts))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    fn attempt_pairs(&self, pairs: &[Pair]) -> impl Iterator<Item = Attempt> + use<> {
        let both = |pair: &Pair| self.attempt(&[&pair.members[0], &pair.members[1]]).ok();
        let attempts: Vec<_> = pairs.par_iter().map(both).collect();
        attempts.into_iter().flatten()
    }

    /// Two candidates that only together explain the log: taken one after the other, the
    /// first might have been something that resembles both. Better than `single` by what a
    /// further term must bring.
    fn at_once(
        &self,
        screen: &Screen<'_>,
        single: &Attempt,
        considered: &[Considered],
    ) -> Option<Attempt> {
        if single.estimate.unexplained <= NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE {
            return None;
        }
        let likely = considered.iter().filter(|c| c.score > MARGIN);
        let singles: Vec<&Considered> = likely
            .take(MAX_PAIRED)
            .flat_map(|c| std::iter::once(c).chain(&c.other_shapes))
            .collect();
        let mut pairs = screen.pairs(&singles, |_, _| true);
        // Each pair in its best shapes.
        let mut seen = BTreeSet::new();
        pairs.retain(|pair| seen.insert(pair.members.each_ref().map(|c| c.candidate)));
        pairs.truncate(MAX_PROFILED);
        let rows = screen.dynamics.t.len() as f64;
        let mut profiled: Vec<(f64, Pair)> = pairs
            .into_par_iter()
            .map(|pair| {
                let [a, b] = &pair.members;
                let size = |c: &Considered| self.dictionary.candidates[c.candidate].size();
                let price = 0.5 * (size(a) + size(b)) as f64 * rows.ln();
                (screen.profile(&[a, b]) + price, pair)
            })
            .collect();
        profiled.sort_by(|a, b| a.0.total_cmp(&b.0));
        profiled.truncate(MAX_LEADERS);
        let pairs: Vec<Pair> = profiled.into_iter().map(|(_, pair)| pair).collect();
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let limit = single.cost - search_price - MARGIN;
        self.attempt_pairs(&pairs)
            .filter(|both| both.cost < limit && self.is_possible(both) && self.earns(both))
            .filter(|both| {
                let (before, after) = (single.estimate.unexplained, both.estimate.unexplained);
                after < (1.0 - LEAST_REMOVED) * before
            })
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// The accepted terms and some more, fitted together.
    fn attempt(&self, more: &[&Considered]) -> Result<Attempt, SolveError> {
        let mut explanation = self.current.explanation.clone();
        let mut candidates = self.accepted.clone();
        for leader in more {
            for &(parameter, value) in &leader.values {
                explanation.values[parameter] = value;
            }
            candidates.push(leader.candidate);
        }
        fit(self.dictionary, &candidates, explanation)
    }

    /// Leading candidates in the stead of a term at the same place: a rich effect may be
    /// what a simple one was taken for.
    fn swaps(&self, considered: &[Considered]) -> Vec<Attempt> {
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

    /// Takes the other assumption about inputs if the log is more likely under it.
    fn ask_about_hold(&mut self) {
        if self.current.explanation.observed.record.u.is_empty() {
            return;
        }
        let mut explanation = self.current.explanation.clone();
        explanation.observed.hold = match explanation.observed.hold {
            Hold::Linear => Hold::Previous,
            Hold::Previous => Hold::Linear,
        };
        // An assumption under which the machine cannot move is none.
        let Ok(other) = fit(self.dictionary, &self.accepted, explanation) else {
            return;
        };
        let other = self.sharpened(other);
        // In doubt inputs are as they are drawn: straight from sample to sample. To stay,
        // and to be later by half a sample, is nearly the same.
        let margin = match other.explanation.observed.hold {
            Hold::Linear => TIE,
            Hold::Previous => -TIE,
        };
        if other.cost < self.current.cost + margin {
            self.current = other;
        }
    }

    /// The attempt fitted once more, also under less noise: as long as much counts as
    /// unexplained, the fit may rest too early.
    fn sharpened(&self, attempt: Attempt) -> Attempt {
        if attempt.estimate.unexplained <= NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE {
            return attempt;
        }
        let mut attempt = attempt;
        for _ in 0..SHARPENINGS {
            let mut sharper = attempt.explanation.clone();
            sharper.noise.force_sd *= SHARPER;
            let starts = [(attempt.explanation.clone(), 0), (sharper, SHARP_STEPS)];
            let again = starts.into_par_iter().map(|(explanation, held)| {
                fit_holding(self.dictionary, &attempt.candidates, explanation, held).ok()
            });
            let again = again.collect::<Vec<_>>().into_iter().flatten();
            match again.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
                Some(again) if again.cost < attempt.cost - 1.0 => attempt = again,
                _ => break,
            }
        }
        attempt
    }

    /// Evidence of each accepted term given the others; those that no longer earn their
    /// place go, the weakest first.
    fn prune(&mut self) -> Vec<f64> {
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
                Some(weakest) if evidence[weakest] < MARGIN => {
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

/// The leading candidates: by a linear fit, and then by one that adapts the noise.
fn leaders<'a>(
    screen: &Screen<'_>,
    considered: &'a [Considered],
    dictionary: &Dictionary,
) -> Vec<&'a Considered> {
    let earns = |c: &&Considered| c.score > MARGIN && c.held_out_gain > MARGIN;
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

fn reset(dictionary: &Dictionary, explanation: &mut Explanation, candidate: usize) {
    let Candidate { parameters, .. } = &dictionary.candidates[candidate];
    for &parameter in parameters {
        explanation.values[parameter] = dictionary.defaults[parameter];
    }
}

/// What inputs most likely do between samples: the assumption under which the log
/// is more likely, with as much force unexplained as each demands.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn likelier_hold(dictionary: &Dictionary, observed: &Observed) -> Result<Hold, SolveError> {
    if observed.record.u.is_empty() {
        return Ok(Hold::Linear);
    }
    let part = observed.excerpt(search_samples(dictionary));
    let observed = part.as_ref().unwrap_or(observed);
    let cost = |hold: Hold| -> Result<f64, SolveError> {
        let observed = Observed {
            hold,
            ..observed.clone()
        };
        let explanation = Explanation {
            noise: first_noise(dictionary, &observed)?,
            values: dictionary.defaults.clone(),
            observed,
        };
        Ok(fit(dictionary, &[], explanation)?.cost)
    };
    let (linear, previous) = (cost(Hold::Linear)?, cost(Hold::Previous)?);
    Ok(if previous < linear - TIE {
        Hold::Previous
    } else {
        Hold::Linear
    })
}

/// Moves the curve of a log to where sensors and a model agree.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub(super) fn smooth(
    dictionary: &Dictionary,
    accepted: &[usize],
    observed: Observed,
    values: &[f64],
) -> Result<Observed, SolveError> {
    let dynamics = linearised(&dictionary.focus(accepted), &observed, values)?;
    let mut explanation = Explanation {
        noise: ProcessNoise {
            force_sd: DVector::from(dynamics.force_scale * FIRST_SHARE),
        },
        values: values.to_vec(),
        observed,
    };
    refine_curve(dictionary, accepted, &mut explanation)?;
    Ok(explanation.observed)
}
