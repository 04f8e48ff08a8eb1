//! What terms are worth, and what would do as well, where each has the shape in which it explains most.
//!
//! In the few shapes that are tried a load is beside its place, and what makes up for that would seem to be
//! as good as anything else that was found.

use super::balance::{Balance, Forces};
use super::choose::{Choice, Chosen};
use super::plainer::Explained;
use crate::machine::SolveError;
use crate::trace::finding::Rival;
use crate::trace::screen::ShapedCandidate;
use crate::trace::selection::Term;

/// The terms with what they are worth and what would do as well, strongest first.
///
/// # Errors
/// If a state's equation has no solution along the curve.
pub(super) fn terms(
    choice: Choice<'_>,
    balance: &Balance,
    explained: &Explained,
) -> Result<Vec<Term>, SolveError> {
    let OwnShapes {
        columns,
        options,
        terms: chosen,
    } = in_own_shapes(&choice, balance, explained)?;
    let (equations, gram) = choice.equations.extended(&choice.gram, &columns);
    let choice = Choice {
        options: &options,
        gram,
        visible: equations.visible(),
        equations: &equations,
        ..choice
    };
    let state = &choice.state(chosen);
    let rival = |(candidate, better): (usize, f64)| {
        Rival::new(&choice.dictionary.candidates[candidate].subject, better)
    };
    let each = state.terms.iter().zip(choice.questioned(state));
    let terms = each.map(|(term, (evidence, rivals))| Term {
        candidate: choice.options[term.option].candidate,
        evidence,
        rivals: rivals.into_iter().map(rival).collect(),
        is_its_own: false,
    });
    let mut terms: Vec<Term> = terms.collect();
    terms.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    Ok(terms)
}

/// All that is asked with.
struct OwnShapes {
    /// Those of the terms, behind all that there are.
    columns: Vec<Forces>,
    options: Vec<ShapedCandidate>,
    terms: Vec<Chosen>,
}

/// Columns of some terms in the shapes in which they explain most, all options with those of these, and the
/// terms with them.
fn in_own_shapes(
    choice: &Choice<'_>,
    balance: &Balance,
    explained: &Explained,
) -> Result<OwnShapes, SolveError> {
    let dictionary = choice.dictionary;
    let mut values = explained.settled.values.clone();
    let accepted = choice.candidates(&explained.terms);
    for &candidate in &accepted {
        for &strength in &dictionary.candidates[candidate].strengths {
            values[strength] = dictionary.defaults[strength];
        }
    }
    let focus = dictionary.focus(&accepted);
    let own = focus.values(&values);
    let states = balance.remembered(&focus.machine, &own)?;
    let added = balance.added(&states, &focus.by_parameter, &own);
    let parameters = dictionary.parameters_of(&accepted);
    let mut options = choice.options.to_vec();
    let (mut terms, mut columns) = (Vec::new(), Vec::new());
    let known = choice.visible.len();
    for (term, &candidate) in explained.terms.iter().zip(&accepted) {
        let first = known + columns.len();
        let strengths = &dictionary.candidates[candidate].strengths;
        for strength in strengths {
            let place = parameters.iter().position(|p| p == strength);
            columns.push(added[place.expect("a parameter of an accepted term")].clone());
        }
        let acts = |&i: &usize| {
            explained.settled.values[strengths[i]] != dictionary.defaults[strengths[i]]
        };
        terms.push(Chosen {
            option: options.len(),
            kept: (0..strengths.len()).filter(acts).collect(),
        });
        options.push(ShapedCandidate {
            candidate,
            shape: choice.options[term.option].shape,
            columns: (first..known + columns.len()).collect(),
        });
    }
    Ok(OwnShapes {
        columns,
        options,
        terms,
    })
}
