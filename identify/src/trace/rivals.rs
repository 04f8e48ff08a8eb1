//! Explanations that the log cannot tell apart.

use super::dictionary::Dictionary;
use super::refine::Explanation;
use super::screen::{Assignment, Screen};
use super::select::TIE;
use crate::machine::SolveError;

/// What could stand in the place of an accepted candidate.
#[derive(Debug, Clone)]
pub(super) struct Alternative {
    /// Which candidate.
    pub candidate: usize,
    /// Nats by which it explains the log better (if negative, worse).
    pub better: f64,
    /// All the dictionary's parameters with it in that place.
    pub values: Vec<f64>,
}

/// Adds one to the alternatives of a term, in the stead of what was known of that candidate.
pub(super) fn join(alternatives: &mut Vec<Alternative>, one: Alternative) {
    alternatives.retain(|known| known.candidate != one.candidate);
    alternatives.push(one);
    alternatives.sort_by(|a, b| b.better.total_cmp(&a.better));
}

/// An alternative may lose this share of what the term explains, to first order, and be the same
/// law all the same: a fit decides.
const NEARLY: f64 = 0.05;

/// Per accepted candidate: what could stand in its place, best first. To first order
/// about `explanation`, under its noise; also what is not as good, but nearly.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub(super) fn rivals(
    dictionary: &Dictionary,
    explanation: &Explanation,
    accepted: &[usize],
) -> Result<Vec<Vec<Alternative>>, SolveError> {
    if accepted.is_empty() {
        return Ok(Vec::new());
    }
    let screen = Screen::new(dictionary, explanation, accepted)?;
    let grams = screen.grams();
    let rows = grams.first().map_or(1.0, |gram| gram.readings() as f64);
    let base: Vec<usize> = (0..screen.base.len()).collect();
    let mut all = Vec::new();
    let mut first = 0;
    for &term in accepted {
        let candidate = &dictionary.candidates[term];
        let own = first..first + candidate.parameters.len();
        first = own.end;
        let others: Vec<usize> = base.iter().copied().filter(|i| !own.contains(i)).collect();
        // Without the term: its part goes back into the data.
        let shift: Vec<(usize, f64)> = candidate
            .parameters
            .iter()
            .enumerate()
            .filter(|(_, p)| candidate.strengths.contains(p))
            .map(|(i, &p)| {
                (
                    own.start + i,
                    explanation.values[p] - dictionary.defaults[p],
                )
            })
            .collect();
        let mut found: Vec<Option<Alternative>> = vec![None; dictionary.candidates.len()];
        for (option, gram) in screen.options.iter().zip(&grams) {
            let whole = gram.fit(&base).misfit;
            let shifted = gram.with_data_shifted(&shift);
            let scale = (whole / rows).max(1.0);
            let worth = 0.5 * (shifted.fit(&others).misfit - whole) / scale;
            let least = -TIE.max(NEARLY * worth);
            let Some((kept, own_values)) = screen.instead(&shifted, &others, option) else {
                continue;
            };
            let mut with = others.clone();
            with.extend(kept.iter().map(|i| base.len() + i));
            let size = dictionary.candidates[option.candidate].parameters.len() as f64;
            let price = 0.5 * (size - candidate.parameters.len() as f64) * rows.ln();
            let fit = shifted.fit(&with);
            let better = 0.5 * (whole - fit.misfit) / scale - price;
            let known = found[option.candidate].as_ref().map(|known| known.better);
            if better > least && known.is_none_or(|known| better > known) {
                let beside = others.iter().map(|&i| screen.base[i]);
                let moved: Assignment = beside.zip(fit.coefficients.iter().copied()).collect();
                found[option.candidate] = Some(Alternative {
                    candidate: option.candidate,
                    better,
                    values: with_instead(dictionary, explanation, term, &moved, &own_values),
                });
            }
        }
        let mut found: Vec<Alternative> = found.into_iter().flatten().collect();
        found.sort_by(|a, b| b.better.total_cmp(&a.better));
        all.push(found);
    }
    Ok(all)
}

/// The explanation's values without `term`, with others `moved` and another's `own`.
fn with_instead(
    dictionary: &Dictionary,
    explanation: &Explanation,
    term: usize,
    moved: &Assignment,
    own: &Assignment,
) -> Vec<f64> {
    let bounds = &dictionary.machine.compiled.model.parameters;
    let mut values = explanation.values.clone();
    for &parameter in &dictionary.candidates[term].parameters {
        values[parameter] = dictionary.defaults[parameter];
    }
    for &(parameter, step) in moved {
        let (lower, upper) = (bounds[parameter].lower, bounds[parameter].upper);
        values[parameter] = (values[parameter] + step).clamp(lower, upper);
    }
    for &(parameter, value) in own {
        values[parameter] = value;
    }
    values
}
