//! Forward selection with re-judgement: which candidates earn their place?
//!
//! Every hypothesis carries forces that nothing explains, as large as the log demands
//! under it. A term is worth what it adds to the likelihood when that size is chosen
//! anew: the right name leaves sensor noise alone, a wrong one leaves forces.

mod ahead;
mod fitting;
mod gather;
mod hold;
mod kin;
mod late;
mod leaders;
mod nearly;
mod outdone;
mod pairs;
mod position;
mod resisting;
mod search;
mod simplify;
#[cfg(test)]
pub(super) mod wheel;

pub(super) use fitting::{first_noise, linearised, smooth};
pub use hold::likelier_hold;
pub(super) use search::MARGIN;

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::finding::Rival;
use super::progress::{Progress, Stage};
use super::refine::{Estimate, Explanation, SMALLEST_SHARE};
use super::rivals::{Alternative, rivals};
use super::screen::Considered;
use super::separate::separating_motion;
use crate::machine::SolveError;
use fitting::fit;
use search::{Attempt, Search};

/// A term that was accepted.
#[derive(Debug, Clone)]
pub struct Term {
    /// Which candidate.
    pub candidate: usize,
    /// Evidence in nats: how much worse the log would be explained without it,
    /// less what its parameters cost.
    pub evidence: f64,
    /// What explains about as well what it explains.
    pub rivals: Vec<Rival>,
}

/// What the accepted terms leave.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Remaining {
    /// Root mean square of the accelerations that unexplained forces make, as a share of
    /// the machine's own, under the model as given; in the balance of forces these, as a share of
    /// what the inputs exert, not a number (`null` in JSON) where they drive nothing.
    pub share_before: f64,
    /// The same with all terms.
    pub share_after: f64,
    /// Nats by which the log is more likely with unexplained forces beside the terms
    /// than with sensor noise alone.
    pub evidence: f64,
}

impl Remaining {
    /// Of a log in which nothing was searched for.
    pub(super) const NOT_SEARCHED: Self = Self {
        share_before: f64::NAN,
        share_after: f64::NAN,
        evidence: f64::NAN,
    };
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
    /// How much that is.
    pub remaining: Remaining,
    /// The first round's candidates, best first.
    pub considered: Vec<Considered>,
    /// The log with the curve through it.
    pub observed: Observed,
}

/// Nats within which two explanations count as equal.
pub(super) const TIE: f64 = 6.0;
/// Terms at most.
const MAX_TERMS: usize = 12;

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
        let current = fit(dictionary, &[], start)?;
        Ok(Search {
            dictionary,
            progress,
            accepted: Vec::new(),
            first_round: Vec::new(),
            given_cost: current.cost,
            current,
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
        search.take(better);
        if free_hold {
            search.ask_about_hold();
        }
        if search.accepted.len() >= MAX_TERMS {
            break;
        }
    }
    search.enter(Stage::Question);
    while let Some(simpler) = search.simplified(&search.current, &search.accepted) {
        search.take(simpler);
    }
    while let Some(plainer) = search.plainer() {
        search.take(plainer);
    }
    if let Some(one) = search.alone() {
        search.take(one);
    }
    if free_hold && let Some(later) = search.hold_for_a_time() {
        search.take(later);
    }
    let loads = loop {
        match search.gathered(search.loads_instead()) {
            Ok(gathered) => {
                search.take(gathered);
            }
            Err(loads) => break loads,
        }
    };
    let mut evidence = search.prune();
    let alike = |search: &Search<'_>| -> Result<Vec<Vec<Alternative>>, SolveError> {
        let explanation = &search.current.explanation;
        let mut alternatives = rivals(dictionary, explanation, &search.accepted)?;
        search.fit_nearly_alike(&mut alternatives);
        search.add_kin(&mut alternatives);
        Ok(alternatives)
    };
    let mut alternatives = alike(&search)?;
    for _ in 0..MAX_TERMS {
        let Some(better) = search.outdone(&alternatives) else {
            break;
        };
        search.take(better);
        evidence = search.prune();
        alternatives = alike(&search)?;
    }
    while let Some(resisting) = search.resisting(&alternatives) {
        search.take(resisting);
        evidence = search.prune();
        alternatives = alike(&search)?;
    }
    // A time may only just have come, in the stead of another term.
    if free_hold && let Some(later) = search.hold_for_a_time() {
        search.take(later);
        evidence = search.prune();
        alternatives = alike(&search)?;
    }
    search.add_loads(loads, &mut alternatives);
    if is_part {
        search.enter(Stage::Settle);
        search.look_at(observed.clone())?;
        given = Given::of(&begin(observed)?)?;
    }
    if free_hold && let Some(doubt) = search.doubt_about_hold() {
        search.current.estimate.covariance += doubt;
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
            rivals: search.told_apart(&alternatives[i]),
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
        remaining,
        considered: search.first_round,
        observed: explanation.observed,
    })
}

/// For how many alternatives of a term a motion is sought that tells them apart.
const TOLD_APART: usize = 4;

impl Search<'_> {
    /// The alternatives of an accepted term, with motions that would tell them from it.
    fn told_apart(&self, alternatives: &[Alternative]) -> Vec<Rival> {
        let Explanation {
            observed, values, ..
        } = &self.current.explanation;
        let each = alternatives.iter().enumerate().map(|(i, alternative)| {
            let subject = &self.dictionary.candidates[alternative.candidate].subject;
            let mut rival = Rival::new(subject, alternative.better);
            if i < TOLD_APART {
                let mut both = self.accepted.clone();
                both.push(alternative.candidate);
                let values = [values.as_slice(), &alternative.values];
                rival.separating_motion =
                    separating_motion(self.dictionary, observed, &both, values);
            }
            rival
        });
        each.collect()
    }
}

impl Selection {
    /// Whether forces remain that nothing explains.
    pub fn forces_remain(&self) -> bool {
        self.estimate.unexplained > search::NO_EXCESS * SMALLEST_SHARE * SMALLEST_SHARE
    }

    /// Whether this leaves no forces, and has fewer terms.
    pub(super) fn explains_with_less(&self, than: &Self) -> bool {
        !self.forces_remain() && self.terms.len() < than.terms.len()
    }

    /// Whether the forces that this leaves are no more than half as large.
    pub(super) fn leaves_much_less(&self, than: &Self) -> bool {
        4.0 * self.estimate.unexplained < than.estimate.unexplained
    }

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

const SEARCHED: usize = 75_000;
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
