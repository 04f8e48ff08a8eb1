//! What was learnt from, what that leaves, and what it gains on other data, in words.

use super::is_stopped;
use crate::number::short;
use crate::trace::{Basis, Foretold, Outcome};

/// What was learnt from, and what that leaves.
pub(super) fn learnt(outcome: &Outcome) -> String {
    let (split, seed) = (&outcome.split, outcome.seed);
    if is_stopped(outcome) {
        return format!("Nothing was learnt. Seed {seed}.");
    }
    let learnt = format!(
        "Learnt from {} samples of {}",
        split.train_samples, split.train_log
    );
    let before = short(outcome.misfit_before);
    let share = |share: f64| match share.is_finite() {
        true => format!("{} %", short(100.0 * share)),
        false => "-".to_string(),
    };
    let left = share(outcome.remaining.share_after);
    let (misfit, left) = match &outcome.nearest {
        Some(nearest) => (
            format!("{before} (nearest: {})", short(nearest.misfit)),
            format!("{left} (nearest: {})", share(nearest.share)),
        ),
        None => (format!("{before} -> {}", short(outcome.misfit_after)), left),
    };
    let gained = gained(outcome);
    match outcome.basis {
        Basis::Motion => format!(
            "{learnt}; mean squared prediction error in units of sensor noise {misfit}; \
             unexplained: {left} of the accelerations.{gained} Seed {seed}."
        ),
        Basis::Forces => format!(
            "{learnt}; mean squared force error in units of what all effects together leave \
             {misfit}; unexplained: {left} of what the inputs exert.{gained} Seed {seed}."
        ),
    }
}

/// What was found, or comes nearest, gains on the log that is judged by.
fn gained(outcome: &Outcome) -> String {
    let what = match outcome.nearest {
        Some(_) => "what comes nearest makes",
        None => "the findings make",
    };
    let gained = outcome.foretold.map(|Foretold { gain, error, .. }| {
        let test = &outcome.split.test_log;
        format!(" By {gain:.0} ± {error:.0} nats {what} the samples of {test} likelier.")
    });
    gained.unwrap_or_default()
}
