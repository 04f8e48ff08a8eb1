//! One term less.
//!
//! Applies to every term: what came first may have stood for what came later.

use super::Move;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;

/// One term less.
pub struct Remove;

impl Move for Remove {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let values = &at.fitted.explanation.values;
        let each = at.terms().iter();
        each.map(|&term| Proposal {
            // What was fitted before the others had found their values may rest in a bad place.
            within_reach: f64::NEG_INFINITY,
            ..at.exchanged(&[term], &[], values.clone())
        })
        .collect()
    }
}
