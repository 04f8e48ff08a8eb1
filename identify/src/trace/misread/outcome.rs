//! The outcome where columns are mistaken beyond doubt: the model as given, on the log as it is
//! read and as it should be. Nothing is searched for, since nothing that is found would be true.

use super::Misread;
use crate::log::said_of;
use crate::regression::Hold;
use crate::trace::dictionary::{Dictionary, Source};
use crate::trace::error::TraceError;
use crate::trace::estimate::Observed;
use crate::trace::finding::Verdict;
use crate::trace::judge::motionless;
use crate::trace::logs::Logs;
use crate::trace::outcome::{Basis, HoldIs, Outcome, sensor_noise};
use crate::trace::remaining::Remaining;
use crate::trace::run::Request;
use crate::trace::score::{Look, ScoreError, Scoring};
use crate::trace::series::{Details, Series};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is said of a log whose columns are mistaken. Errors "after" are those of the model as
/// given, on the log read otherwise.
///
/// # Errors
/// If the log that is judged by cannot be smoothed, or the model not be evaluated along it.
pub(in crate::trace) fn outcome(
    request: &Request<'_>,
    source: &Source<'_>,
    logs: Logs,
    misread: Misread,
) -> Result<Outcome, TraceError> {
    let Logs { train, test, split } = logs;
    let hold = request.hold.unwrap_or(Hold::Linear);
    let observed = Observed::new(misread.mended(&test), hold)?;
    let located = |error| TraceError::at(error, &test.t);
    let dictionary = Dictionary::of_parameters(source, &observed.ranges()).map_err(Box::new)?;
    let focus = dictionary.focus(&[]);
    let scoring = Scoring {
        machine: &focus.machine,
        values: &focus.values(&dictionary.defaults),
        hold,
        horizon: request.horizon,
        begun: &Arc::default(),
    };
    // Along a log that is far from any motion of the machine it may not even move.
    let look = |record| -> Result<Look, TraceError> {
        match scoring.look(record) {
            Ok(look) => Ok(look),
            Err(ScoreError::Smooth(error)) => Err(error.into()),
            Err(ScoreError::Solve(_)) => Ok(motionless(record, request.horizon)?),
        }
    };
    let (before, after) = (look(&test)?, look(&observed.record)?);
    let noise_floor = match scoring.noise_floor(&observed, true, request.seed) {
        Ok(floor) => floor,
        Err(ScoreError::Smooth(error)) => return Err(error.into()),
        Err(ScoreError::Solve(_)) => motionless(&observed.record, request.horizon)?.score,
    };
    let model = (&*focus, &dictionary.defaults[..]);
    let series =
        Series::new([model; 2], &observed, [&before, &after], Vec::new()).map_err(located)?;
    Ok(Outcome {
        verdict: Verdict::Channel,
        basis: Basis::Motion,
        findings: Vec::new(),
        nearest: None,
        before: before.score,
        after: after.score,
        noise_floor,
        foretold: None,
        remaining: Remaining::NOT_SEARCHED,
        unnamed: None,
        misfit_before: f64::NAN,
        misfit_after: f64::NAN,
        log_likelihood_before: f64::NAN,
        log_likelihood_after: f64::NAN,
        sensor_noise: sensor_noise(&observed),
        input_hold: hold,
        between_samples: std::collections::BTreeMap::new(),
        if_held_otherwise: BTreeMap::new(),
        input_hold_is: match request.hold {
            Some(_) => HoldIs::Stated,
            None => HoldIs::Assumed,
        },
        split,
        unfinished: None,
        seed: request.seed,
        misread: Some(misread),
        warnings: said_of(&train, &test, request.test.is_some()),
        next: Vec::new(),
        patched_model: request.model_text.to_string(),
        details: Details {
            considered: Vec::new(),
            series,
        },
    })
}
