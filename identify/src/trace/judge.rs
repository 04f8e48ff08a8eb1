//! Errors before and after on a log that nothing was fitted to.

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::error::TraceError;
use super::estimate::Observed;
use super::run::{Basis, Request};
use super::score::{Score, ScoreError, Scoring};
use super::select::{Selection, smooth};
use super::series::Series;
use crate::log::Record;
use crate::regression::Hold;

/// An error above this many times that of the model as given is worse.
const WORSE: f64 = 1.1;

/// Before, after, and the floor, on data that nothing was fitted to.
pub(super) fn judge(
    dictionary: &Dictionary,
    selection: &Selection,
    test: &Record,
    request: &Request<'_>,
    hold: Hold,
) -> Result<([Score; 3], Series), TraceError> {
    let failed = |error: ScoreError| match error {
        ScoreError::Smooth(error) => TraceError::Smooth(error),
        ScoreError::Solve(error) => TraceError::at(error, &test.t),
    };
    let accepted = selection.accepted();
    let (given, patched) = (dictionary.focus(&[]), dictionary.focus(&accepted));
    let (given_values, patched_values) = (
        given.values(&dictionary.defaults),
        patched.values(&selection.values),
    );
    let scoring = |machine, values| Scoring {
        machine,
        values,
        hold,
        horizon: request.horizon,
    };
    let before = scoring(&given.machine, &given_values);
    let after = scoring(&patched.machine, &patched_values);
    let floor = after;
    let before = before.look(test).map_err(failed)?;
    let faultless = corrected(test, &patched, &patched_values)?;
    let after = after.look(&faultless).map_err(failed)?;
    // The states of the test log as the patched model sees them.
    let observed = Observed::new(test.clone(), hold)?;
    let observed = smooth(dictionary, &accepted, observed, &selection.values)
        .map_err(|error| TraceError::at(error, &test.t))?;
    let forces_remain = selection.forces_remain();
    let floor = floor
        .noise_floor(&observed, forces_remain, request.seed)
        .map_err(failed)?;
    let models = [
        (&*given, &dictionary.defaults[..]),
        (&*patched, &selection.values[..]),
    ];
    let series = Series::new(models, &observed, &before, &after)
        .map_err(|error| TraceError::at(error, &test.t))?;
    Ok(([before.score, after.score, floor], series))
}

/// Whether the patched model predicts worse. Both measures must say so: where little moves,
/// accelerations are mostly the filter's corners.
pub(super) fn is_worse(basis: Basis, [before, after, _]: &[Score; 3]) -> bool {
    match basis {
        Basis::Forces => after.force.total > before.force.total,
        Basis::Motion => {
            after.acceleration.total > WORSE * before.acceleration.total
                && after.rollout.errors.total > before.rollout.errors.total
        }
    }
}
