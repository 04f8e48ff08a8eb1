//! Two simple terms in the place of a rich one.
//!
//! Applies to a term with more parameters than two others of its place have together: Coulomb and
//! viscous friction, not Stribeck's.

use super::Move;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::EXCHANGED;

/// Two simple terms in the place of a rich one.
pub struct Split;

impl Move for Split {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let of_term = |&term: &usize| at.splits(term).into_iter().take(EXCHANGED);
        let all = at.terms().iter().flat_map(of_term);
        all.map(|one| at.proposal(one)).collect()
    }
}
