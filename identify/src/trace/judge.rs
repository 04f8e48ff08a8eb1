//! Errors before and after on a log that nothing was fitted to.

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::error::TraceError;
use super::estimate::Observed;
use super::focus::Focus;
use super::outcome::Basis;
use super::run::Request;
use super::score::{Score, ScoreError, Scoring};
use super::select::{Selection, smooth};
use super::series::Series;
use crate::log::Record;
use crate::regression::Hold;
use std::sync::Arc;

/// An error above this many times that of the model as given is worse.
const WORSE: f64 = 1.1;

/// A model with the values of its own parameters, out of the dictionary's.
pub(super) struct Judged<'a> {
    pub focus: Arc<Focus>,
    pub values: Vec<f64>,
    dictionary_values: &'a [f64],
}

impl Judged<'_> {
    /// What scores it, with predictions over `horizon` s.
    pub fn scoring(&self, hold: Hold, horizon: f64) -> Scoring<'_> {
        Scoring {
            machine: &self.focus.machine,
            values: &self.values,
            hold,
            horizon,
        }
    }
}

/// The model as given and the patched one.
pub(super) struct Models<'a> {
    pub given: Judged<'a>,
    pub patched: Judged<'a>,
}

impl<'a> Models<'a> {
    pub fn new(dictionary: &'a Dictionary, selection: &'a Selection) -> Self {
        let of = |accepted: &[usize], dictionary_values: &'a [f64]| {
            let focus = dictionary.focus(accepted);
            Judged {
                values: focus.values(dictionary_values),
                focus,
                dictionary_values,
            }
        };
        Self {
            given: of(&[], &dictionary.defaults),
            patched: of(&selection.accepted(), &selection.values),
        }
    }

    /// Both, as [`Series::new`] takes them.
    pub fn in_series(&self) -> [(&Focus, &[f64]); 2] {
        [&self.given, &self.patched].map(|model| (&*model.focus, model.dictionary_values))
    }
}

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
    let models = Models::new(dictionary, selection);
    let Models { given, patched } = &models;
    let before = given.scoring(hold, request.horizon);
    let after = patched.scoring(hold, request.horizon);
    let floor = after;
    let before = before.look(test).map_err(failed)?;
    let faultless = corrected(test, &patched.focus, &patched.values)?;
    let after = after.look(&faultless).map_err(failed)?;
    // The states of the test log as the patched model sees them.
    let observed = Observed::new(test.clone(), hold)?;
    let observed = smooth(
        dictionary,
        &selection.accepted(),
        observed,
        &selection.values,
    )
    .map_err(|error| TraceError::at(error, &test.t))?;
    let forces_remain = selection.forces_remain();
    let floor = floor
        .noise_floor(&observed, forces_remain, request.seed)
        .map_err(failed)?;
    let series = Series::new(models.in_series(), &observed, &before, &after)
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
