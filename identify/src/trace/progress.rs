//! What a trace is doing at the moment, for whoever waits for it.

use serde::Serialize;
use std::fmt;

/// A part of the work; the parts follow one another, those of the search more than once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Stage {
    /// The columns are looked at: are they what they are taken for?
    Columns,
    /// A curve is drawn through the log, and the sensors' noise is estimated.
    Smooth,
    /// Every effect at every place is derived.
    Derive,
    /// All candidates are weighed beside the accepted ones.
    Screen,
    /// The leading candidates are fitted.
    Fit,
    /// Accepted terms are questioned: is each needed, and would another do?
    Question,
    /// The accepted terms are fitted to the whole log.
    Settle,
    /// Errors before and after on the log that is judged by.
    Judge,
    /// A force without a name is looked at.
    Look,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Columns => "columns",
            Self::Smooth => "smooth",
            Self::Derive => "derive",
            Self::Screen => "screen",
            Self::Fit => "fit",
            Self::Question => "question",
            Self::Settle => "settle",
            Self::Judge => "judge",
            Self::Look => "look",
        })
    }
}

/// Why a search ends before it is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Ended {
    /// It may take no longer.
    TimeLimit,
    /// Whoever waits for it wants what there is.
    Interrupt,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TimeLimit => "the time limit",
            Self::Interrupt => "an interrupt",
        })
    }
}

/// Is told when a stage begins, and says when the search must end.
pub trait Progress: fmt::Debug + Sync {
    /// A stage begins, and the one before has ended; `found` names what has been accepted
    /// so far.
    fn enter(&self, stage: Stage, found: &[String]);

    /// Something that whoever waits should know at once.
    fn notice(&self, text: &str);

    /// Whether the search is to end with the best that it has, and why. It ends after the fits
    /// that are under way. Once it has to, it always has to.
    fn ended(&self) -> Option<Ended> {
        None
    }
}

/// Does not want to know, and has time.
#[derive(Debug, Clone, Copy)]
pub struct Silent;

impl Progress for Silent {
    fn enter(&self, _: Stage, _: &[String]) {}

    fn notice(&self, _: &str) {}
}
