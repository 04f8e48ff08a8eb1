//! A sensor or a drive that is late by much.
//!
//! Applies where forces remain. What is late by a good part of the motion's own time is
//! far from what a line says of it, and beside another thing that is missing even the sign of a
//! small step may be wrong. Times are few and bounded: they are tried as they are.

use super::Move;
use crate::trace::search::channel::{number_of_channel, timed_sensor};
use crate::trace::search::explored::Explored;
use crate::trace::search::lateness::Glance;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::MAX_TERMS;
use dynamics_codegen::dimension::Dimension;

/// A sensor or a drive that is late by much.
pub struct Late;

impl Move for Late {
    fn propose(&self, at: &Neighbourhood<'_>, explored: &Explored) -> Vec<Proposal> {
        if at.terms().len() >= MAX_TERMS {
            return Vec::new();
        }
        let glance = Glance::new(at);
        let all = 0..at.dictionary.candidates.len();
        let new = all.filter(|&candidate| !at.fitted.hypothesis.contains(candidate));
        let times = new.filter_map(|candidate| {
            let (_, unit) = number_of_channel(at.dictionary, candidate)?;
            let radian = match timed_sensor(at.dictionary, candidate) {
                Some(coordinate) => glance.radian(coordinate),
                None => glance.quickest(),
            };
            (unit == Dimension::TIME).then(|| glance.times(candidate, radian))
        });
        glance.likely(times.flatten().collect(), explored)
    }
}
