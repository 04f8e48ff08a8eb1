//! Explanations that the log cannot tell apart.

use super::dictionary::{Dictionary, Subject};
use super::refine::Explanation;
use super::screen::Screen;
use super::select::TIE;
use crate::machine::SolveError;

/// Per accepted candidate: the subjects that could stand in its place, with the nats by
/// which each explains the log better (if negative, worse), best first. To first order
/// about `explanation`, under its noise.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub(super) fn rivals(
    dictionary: &Dictionary,
    explanation: &Explanation,
    accepted: &[usize],
) -> Result<Vec<Vec<(Subject, f64)>>, SolveError> {
    if accepted.is_empty() {
        return Ok(Vec::new());
    }
    let screen = Screen::new(dictionary, explanation, accepted)?;
    let grams = screen.grams();
    let rows = grams.first().map_or(1.0, |gram| gram.rows() as f64);
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
        let mut found: Vec<Option<f64>> = vec![None; dictionary.candidates.len()];
        for (option, gram) in screen.options.iter().zip(&grams) {
            let whole = gram.fit(&base).misfit;
            let shifted = gram.with_data_shifted(&shift);
            let scale = (whole / rows).max(1.0);
            let Some(kept) = screen.instead(&shifted, &others, option) else {
                continue;
            };
            let mut with = others.clone();
            with.extend(kept.iter().map(|i| base.len() + i));
            let size = dictionary.candidates[option.candidate].parameters.len() as f64;
            let price = 0.5 * (size - candidate.parameters.len() as f64) * rows.ln();
            let better = 0.5 * (whole - shifted.fit(&with).misfit) / scale - price;
            if better > -TIE && found[option.candidate].is_none_or(|known| better > known) {
                found[option.candidate] = Some(better);
            }
        }
        let mut found: Vec<(Subject, f64)> = found
            .into_iter()
            .enumerate()
            .filter_map(|(i, better)| Some((dictionary.candidates[i].subject.clone(), better?)))
            .collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        all.push(found);
    }
    Ok(all)
}
