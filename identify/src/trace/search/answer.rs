//! What a search says: terms with their evidence, rivals, and what remains.

use super::beam::Search;
use super::channel::{clock_of_inputs, delay_of_inputs, is_time, timed_input, timed_sensor};
use super::fit::{Fitted, fit, fit_with};
use super::hypothesis::Hypothesis;
use crate::machine::SolveError;
use crate::trace::dictionary::Dictionary;
use crate::trace::finding::{Rival, says_no_strength, worth};
use crate::trace::refine::{Effort, Explanation};
use crate::trace::remaining::{Remaining, beside};
use crate::trace::selection::{Selection, Term};
use crate::trace::sensor_memory::WithoutForces;
use crate::trace::separate::{Relation, relation};
use crate::trace::settings::TIE;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// What a search found.
#[derive(Clone)]
pub struct Answer {
    /// That.
    pub selection: Selection,
    /// Whether it explains the log up to white noise of the sensors, and is likelier than the model as given beside
    /// sensors that err as they look.
    pub is_whole: bool,
}

/// For how many rivals of a term a motion is sought that tells them apart.
const TOLD_APART: usize = 4;

/// The answer of a finished search, of which this is the best that is [`determined`].
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn answer(search: &Search<'_>, best: &Fitted) -> Result<Answer, SolveError> {
    let dictionary = search.dictionary;
    let nothing = Hypothesis::nothing(best.hypothesis.hold);
    let mut given = search.given.iter();
    let given = match given.find(|given| given.hypothesis == nothing) {
        // Nothing was found: what is left is what was there.
        _ if best.hypothesis == nothing => Arc::new(best.clone()),
        Some(given) => Arc::clone(given),
        None => Arc::new(search.as_given(best)?),
    };
    let mut estimate = best.estimate.clone();
    let held_otherwise = held_otherwise(search, best).cloned();
    if let Some(values) = &held_otherwise {
        estimate.covariance += doubt_about_hold(best, values);
    }
    let [beside_given, beside_best] =
        [&given, best].map(|fitted| WithoutForces::new(dictionary, fitted));
    let (beside_given, beside_best) = (beside_given?, beside_best?);
    let share = |fitted: &Fitted| fitted.estimate.unexplained.max(0.0).sqrt();
    let forces = |fitted: &Fitted| {
        let terms = fitted.hypothesis.candidates();
        beside(dictionary, terms, &fitted.explanation)
    };
    let term = |&candidate: &usize| Term {
        candidate,
        evidence: evidence(search, best, candidate),
        rivals: rivals(search, best, candidate),
        is_its_own: is_its_own(search, best, candidate),
    };
    let mut terms: Vec<Term> = best.hypothesis.candidates().iter().map(term).collect();
    terms.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let evidence = beside_best.cost - best.estimate.cost;
    let (share_after, forces_after) = match evidence > 0.0 {
        true => (share(best), forces(best)?),
        // What sensor noise explains is no force.
        false => (0.0, Vec::new()),
    };
    let selection = Selection {
        terms,
        reduced_misfit: beside_best.misfit,
        nominal_misfit: beside_given.misfit,
        log_likelihood: [&beside_given, &beside_best].map(|without| without.log_likelihood),
        remaining: Remaining {
            share_before: share(&given),
            share_after,
            evidence,
            forces: forces_after,
        },
        given_forces: forces(&given)?,
        considered: search.fresh.to_vec(),
        left_out_nameless: search.left_out_nameless,
        narrowing: 1,
        averaged_over: 0.0,
        held_otherwise,
        values: best.explanation.values.clone(),
        estimate,
        observed: best.explanation.observed.clone(),
    };
    let is_white = !best.leaves_forces() && !beside_best.explain_more(best);
    Ok(Answer {
        is_whole: is_white && beside_best.score(best) < beside_given.score(&given),
        selection,
    })
}

/// The best hypothesis, without terms of which the log says no strength as far as it is about as likely
/// without them: what is not known takes nothing from what is.
pub fn determined(search: &Search<'_>) -> Arc<Fitted> {
    let dictionary = search.dictionary;
    let mut best = Arc::clone(search.best());
    loop {
        let (values, known) = (&best.explanation.values, best.estimate.known());
        let mut terms = best.hypothesis.candidates().iter();
        let Some(&term) = terms.find(|&&term| says_no_strength(dictionary, term, values, known))
        else {
            return best;
        };
        let start = Explanation {
            values: dictionary.without(&[term], values),
            ..best.explanation.clone()
        };
        match fit(dictionary, &best.hypothesis.exchange(&[term], &[]), start) {
            Ok(without) if without.score < best.score + TIE => best = Arc::new(without),
            _ => return best,
        }
    }
}

/// Nats by which the log is less likely without a term, after all prices; where there is no fit without
/// it, since the machine cannot move so or nowhere near the log, to second order.
fn evidence(search: &Search<'_>, best: &Fitted, term: usize) -> f64 {
    let without = search.explored.of(&best.hypothesis.exchange(&[term], &[]));
    match without.filter(|without| without.score.is_finite()) {
        Some(without) => without.score - best.score,
        None => {
            let known = best.estimate.known();
            worth(search.dictionary, term, &best.explanation.values, known)
        }
    }
}

/// Whether a term says that a sensor, or some of the inputs, are late by part of a sample, and the log is clearly less
/// likely with all inputs late by one time instead, whatever they do between samples.
fn is_its_own(search: &Search<'_>, best: &Fitted, term: usize) -> bool {
    let dictionary = search.dictionary;
    let (hypothesis, found) = (&best.hypothesis, &best.explanation);
    let is_of_all = clock_of_inputs(dictionary, term).is_some();
    let is_of_sensor = timed_sensor(dictionary, term).is_some();
    if is_of_all || !is_of_sensor && timed_input(dictionary, term).is_none() {
        return false;
    }
    let time = dictionary.candidates[term].parameters[0];
    if !found.observed.record.hides(found.values[time]) || search.progress.ended().is_some() {
        return false;
    }
    let as_likely = best.estimate.cost + TIE;
    let cost = |shared: Hypothesis, clock: usize| {
        let mut values = dictionary.without(&[term], &found.values);
        if values[clock] == dictionary.defaults[clock] {
            values[clock] = found.values[time].abs();
        }
        let start = Explanation {
            values,
            ..found.clone()
        };
        let effort = Effort {
            bar: as_likely,
            enough: as_likely,
            ..Effort::FULL
        };
        let fitted = fit_with(dictionary, &shared, start, effort);
        fitted.map_or(f64::INFINITY, |fitted| fitted.estimate.cost)
    };
    let is_told_from = |(candidate, clock): (usize, usize)| {
        let shared = hypothesis.exchange(&[term], &[candidate]);
        let otherwise = search.free_hold.then(|| shared.held_otherwise());
        let mut shared = std::iter::once(shared).chain(otherwise);
        shared.all(|shared| cost(shared, clock) > as_likely)
    };
    let candidates = 0..dictionary.candidates.len();
    let clocks = candidates.filter_map(|c| Some((c, delay_of_inputs(dictionary, c)?)));
    let clocks: Vec<(usize, usize)> = clocks.collect();
    !clocks.is_empty() && clocks.into_iter().all(is_told_from)
}

/// What the log cannot tell from a term, the best first, with motions that would tell. A law that holds
/// the term's as a special case and has become it is no rival: it is that law by a longer name.
fn rivals(search: &Search<'_>, found: &Fitted, term: usize) -> Vec<Rival> {
    let best = &found.explanation;
    let others = search.explored.all().filter_map(|(other, outline)| {
        let (own, instead) = found.hypothesis.differs_by_one(other)?;
        // What is believed beforehand says nothing of how well the log tells them apart.
        let better = (found.score - found.prior) - (outline.score - outline.prior);
        (own == term && outline.is_possible && better > -TIE).then_some((
            better,
            instead,
            &outline.values,
        ))
    });
    let mut others: Vec<(f64, usize, &Vec<f64>)> = others.collect();
    others.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut rivals = Vec::new();
    for (i, (better, instead, values)) in others.into_iter().enumerate() {
        let mut rival = Rival::new(&search.dictionary.candidates[instead].subject, better);
        if i < TOLD_APART {
            let both = found.hypothesis.exchange(&[], &[instead]);
            let values = [best.values.as_slice(), values];
            let moved = match could_degenerate(search.dictionary, term, instead) {
                true => about_as_likely(search.dictionary, found, term),
                false => Vec::new(),
            };
            let (dictionary, observed) = (search.dictionary, &best.observed);
            match relation(dictionary, observed, both.candidates(), values, &moved) {
                Relation::Same => continue,
                Relation::Different(motion) => rival.separating_motion = motion,
            }
        }
        rivals.push(rival);
    }
    rivals
}

/// Whether a law at the same place has more numbers than another, so that it may be that law.
fn could_degenerate(dictionary: &Dictionary, plain: usize, rich: usize) -> bool {
    let [plain, rich] = [plain, rich].map(|term| &dictionary.candidates[term]);
    rich.subject.on() == plain.subject.on() && rich.parameters.len() > plain.parameters.len()
}

/// What was found, with each number of a term two standard errors off.
fn about_as_likely(dictionary: &Dictionary, found: &Fitted, term: usize) -> Vec<Vec<f64>> {
    let estimate = &found.estimate;
    let own = &dictionary.candidates[term].parameters;
    let numbers = estimate.parameters.iter().enumerate();
    let moved = numbers.filter(|(_, p)| own.contains(p)).map(|(i, &p)| {
        let mut values = found.explanation.values.clone();
        values[p] += 2.0 * estimate.covariance[(i, i)].max(0.0).sqrt();
        values
    });
    moved.collect()
}

/// All parameters under the other assumption about inputs between samples, where one that was found is
/// a time and the log is about as likely so: an input that is held is as late as one that is drawn
/// straight and half a sample later.
fn held_otherwise<'a>(search: &'a Search<'_>, found: &Fitted) -> Option<&'a Vec<f64>> {
    let mut terms = found.hypothesis.candidates().iter();
    terms.find(|&&term| is_time(search.dictionary, term))?;
    let otherwise = search.explored.of(&found.hypothesis.held_otherwise())?;
    (otherwise.cost - found.estimate.cost <= TIE).then_some(&otherwise.values)
}

/// What that doubt adds to the covariance of times and all else: `½ Δ Δᵀ`, with how far `Δ` the
/// estimate moves.
fn doubt_about_hold(found: &Fitted, otherwise: &[f64]) -> DMatrix<f64> {
    let parameters = &found.estimate.parameters;
    let moved = parameters
        .iter()
        .map(|&p| otherwise[p] - found.explanation.values[p]);
    let moved = DVector::from_iterator(parameters.len(), moved);
    0.5 * &moved * moved.transpose()
}
