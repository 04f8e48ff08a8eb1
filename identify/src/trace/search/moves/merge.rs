//! One term in the place of several.
//!
//! Applies to parameters and effects on bodies, and to a force beside one of them. A load on a link
//! changes its mass, its centre of mass and its inertia: each of them alone explains part of it, so
//! that one after the other is taken for wrong. One cause is simpler than two or three that happen
//! to be there at once.

use super::Move;
use crate::trace::dictionary::Dictionary;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::EXCHANGED;
use crate::trace::subject::Subject;

/// One term in the place of several.
pub struct Merge;

impl Move for Merge {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let is_massive = |c: usize| is_massive(at.dictionary, c);
        let (massive, others): (Vec<usize>, Vec<usize>) =
            at.terms().iter().partition(|&&c| is_massive(c));
        let forces = others
            .into_iter()
            .filter(|&c| !at.dictionary.candidates[c].channel);
        let forces: Vec<usize> = forces.collect();
        let mut sets = pairs(&massive, &forces);
        // How good one effect on a body is shows only when its place there has been found.
        let is_load = |c: usize| is_on_a_body(at.dictionary, &at.dictionary.candidates[c].subject);
        let loads = match massive.len() {
            0 | 1 => Vec::new(),
            _ => at.exchanges_in_shape(&massive, is_load),
        };
        let loads = loads.into_iter().take(EXCHANGED).map(|(_, load)| load);
        if massive.len() > 2 {
            sets.push(massive);
        }
        let merged = sets.iter().flat_map(|set| {
            let mut merged = at.exchanges(set, is_massive);
            merged.truncate(EXCHANGED);
            merged
        });
        let merged = merged.chain(loads);
        let mut merged: Vec<Proposal> = merged.map(|one| at.proposal(one)).collect();
        merged.sort_by(|a, b| a.promise.total_cmp(&b.promise));
        merged
    }
}

/// Whether a candidate is about a part: another value of a parameter, or an effect on one body.
fn is_massive(dictionary: &Dictionary, candidate: usize) -> bool {
    let own = &dictionary.candidates[candidate];
    match &own.subject {
        Subject::Parameter(_) => !own.is_loss,
        subject @ Subject::Effect { .. } => is_on_a_body(dictionary, subject),
    }
}

/// Whether an effect acts on one body.
pub fn is_on_a_body(dictionary: &Dictionary, subject: &Subject) -> bool {
    let on = subject.on();
    let mut bodies = dictionary.machine.compiled.model.moving_bodies();
    on.len() == 1 && bodies.any(|body| body.name == on[0])
}

/// What may be one cause: every two of what is `massive`, and one of it with one of the `forces`.
fn pairs(massive: &[usize], forces: &[usize]) -> Vec<Vec<usize>> {
    let mut pairs = Vec::new();
    for (i, &a) in massive.iter().enumerate() {
        let others = massive[i + 1..].iter().chain(forces);
        pairs.extend(others.map(|&b| vec![a, b]));
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::pairs;

    #[test]
    fn pairs_have_a_massive_member() {
        assert!(pairs(&[1], &[]).is_empty());
        assert!(pairs(&[], &[7, 8]).is_empty());
        assert_eq!(pairs(&[1, 2], &[]), [[1, 2]]);
        assert_eq!(pairs(&[1], &[7, 8]), [[1, 7], [1, 8]]);
        assert_eq!(pairs(&[1, 2, 3], &[]), [[1, 2], [1, 3], [2, 3]]);
    }
}
