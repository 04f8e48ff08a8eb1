//! The ways from a hypothesis to others. Each proposes what is worth a fit, and none decides: all
//! proposals are fitted and compared by one score.

mod add;
mod apart;
mod clock;
mod fallback;
mod family;
mod hold;
mod late;
pub mod merge;
mod odd;
mod pair;
mod remove;
mod split;
mod swap;
mod timing;

use super::explored::Explored;
use super::neighbourhood::Neighbourhood;
use super::proposal::Proposal;

/// A way from a hypothesis to others.
pub trait Move: Sync {
    /// Hypotheses that are worth a fit, the most promising first; what was `explored` is known.
    fn propose(&self, at: &Neighbourhood<'_>, explored: &Explored) -> Vec<Proposal>;
}

/// What leads on: one more term, or what the newest one was taken for.
pub const STEP: &[&dyn Move] = &[&add::Add, &swap::SwapHere, &timing::Timing, &hold::Hold];
/// What several places have alike, where forces remain after that: before what resembles it leads astray.
pub const ALIKE: &[&dyn Move] = &[&family::Family, &clock::Clock, &apart::Apart];
/// One more term alone.
pub const MORE: &[&dyn Move] = &[&add::Add];
/// What leads on where forces remain after that.
pub const LEAP: &[&dyn Move] = &[&fallback::Fallback, &late::Late, &pair::Pair];
/// What questions every term.
pub const EXCHANGE: &[&dyn Move] = &[
    &remove::Remove,
    &split::Split,
    &apart::Apart,
    &swap::Swap,
    &timing::Timing,
    &merge::Merge,
    &odd::Odd,
    &hold::HoldForTime,
];
