//! Errors before and after on a log that nothing was fitted to.

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::error::TraceError;
use super::estimate::Observed;
use super::finding::something_remains;
use super::focus::Focus;
use super::foretold::{Foretold, costs};
use super::linearised::smooth;
use super::outcome::Basis;
use super::run::Request;
use super::score::{
    Errors, Look, Predicted, RolloutErrors, Score, ScoreError, Scoring, inner_samples,
};
use super::selection::{Selection, Term};
use super::series::{Explained, Series};
use super::subject::Subject;
use super::unmeasured::{begun_anew, echo, take};
use crate::log::Record;
use crate::machine::{Begun, States};
use crate::regression::Hold;
use crate::smooth::{SmoothError, savgol_states};
use std::sync::Arc;

/// An error above this many times that of the model as given is worse.
const WORSE: f64 = 1.1;

/// A model with the values of its own parameters, out of the dictionary's.
pub(super) struct Judged<'a> {
    pub focus: Arc<Focus>,
    pub values: Vec<f64>,
    dictionary_values: &'a [f64],
    /// How its internal states begin in the log that it is judged by.
    begun: Arc<Begun>,
}

impl<'a> Judged<'a> {
    /// The model with some terms, and with the dictionary's parameters at some values.
    pub fn new(dictionary: &Dictionary, terms: &[usize], dictionary_values: &'a [f64]) -> Self {
        let focus = dictionary.focus(terms);
        Self {
            values: focus.values(dictionary_values),
            focus,
            dictionary_values,
            begun: Arc::default(),
        }
    }

    /// With internal states that begin as along a curve.
    fn begun_as(self, curve: &States) -> Self {
        Self {
            begun: Arc::clone(&curve.begun),
            ..self
        }
    }

    /// What scores it, with predictions over `horizon` s.
    pub fn scoring(&self, hold: Hold, horizon: f64) -> Scoring<'_> {
        Scoring {
            machine: &self.focus.machine,
            values: &self.values,
            hold,
            horizon,
            begun: &self.begun,
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
        Self {
            given: Judged::new(dictionary, &[], &dictionary.defaults),
            patched: Judged::new(dictionary, &selection.accepted(), &selection.values),
        }
    }

    /// The patched model without each of its terms, and what that is to be called.
    pub fn without_each(
        dictionary: &'a Dictionary,
        selection: &'a Selection,
    ) -> impl Iterator<Item = (&'a Subject, Judged<'a>)> {
        let accepted = selection.accepted();
        selection.terms.iter().map(move |Term { candidate, .. }| {
            let mut others = accepted.clone();
            others.retain(|other| other != candidate);
            let model = Judged::new(dictionary, &others, &selection.values);
            (&dictionary.candidates[*candidate].subject, model)
        })
    }

    /// Both, as [`Series::new`] takes them.
    pub fn in_series(&self) -> [(&Focus, &[f64]); 2] {
        [&self.given, &self.patched].map(|model| (&*model.focus, model.dictionary_values))
    }
}

/// What a log says that nothing was fitted to.
pub(super) struct HeldOut {
    /// Errors of the model as given, of the patched one, and the floor.
    pub scores: [Score; 3],
    /// The curves behind them.
    pub series: Series,
    /// What findings gain, where there are any.
    pub foretold: Option<Foretold>,
}

/// Before, after, and the floor, on data that nothing was fitted to, and what findings gain there.
pub(super) fn judge(
    dictionary: &Dictionary,
    selection: &Selection,
    test: &Record,
    request: &Request<'_>,
    hold: Hold,
) -> Result<HeldOut, TraceError> {
    let failed = |error: ScoreError| match error {
        ScoreError::Smooth(error) => TraceError::Smooth(error),
        ScoreError::Solve(error) => TraceError::at(error, &test.t),
    };
    let located = |error| TraceError::at(error, &test.t);
    let (accepted, values) = (selection.accepted(), &selection.values);
    let Models { given, patched } = Models::new(dictionary, selection);
    // Of what nothing measures, the best estimate is that of the patched model.
    let mut estimated = test.clone();
    if !test.is_wholly_measured() {
        let mut observed = as_observed(test, selection, hold)?;
        if reads_otherwise(dictionary, &accepted) {
            // Where no other motion is found, the one at hand is the best.
            observed = begun_anew(&patched.focus, values, &observed).unwrap_or(observed);
        }
        let known = smooth(dictionary, &accepted, observed, values).map_err(located)?;
        take(&mut estimated, &known.observed.curve);
    }
    let test = &estimated;
    let faultless = corrected(test, &patched.focus, &patched.values)?;
    // The states of the test log as the patched model sees them, from where faultless sensors
    // would have.
    let mut observed = as_observed(test, selection, hold)?;
    let as_logged = observed.clone();
    if patched.focus.machine.has_sensor_errors() {
        observed.curve = Observed::new(faultless.clone(), hold)?.curve;
    }
    let explanation = smooth(dictionary, &accepted, observed, values).map_err(located)?;
    let patched = patched.begun_as(&explanation.observed.curve);
    let (given, foretold) = match accepted.is_empty() {
        true => (given.begun_as(&explanation.observed.curve), None),
        false => {
            let known =
                smooth(dictionary, &[], as_logged, &dictionary.defaults).map_err(located)?;
            let before = costs(dictionary, &[], &known).map_err(located)?;
            let after = costs(dictionary, &accepted, &explanation).map_err(located)?;
            let given = given.begun_as(&known.observed.curve);
            (given, Some(Foretold::new(&before, &after)))
        }
    };
    let models = Models { given, patched };
    let before = models.given.scoring(hold, request.horizon);
    let before = before.look(test).map_err(failed)?;
    let floor = models.patched.scoring(hold, request.horizon);
    let after = floor.look(&faultless).map_err(failed)?;
    let echo = echo(dictionary, &accepted, &explanation, request.seed).map_err(located)?;
    let observed = Observed {
        echo,
        ..explanation.observed
    };
    // Those that are not worth a name are what shakes any machine.
    let forces_remain = something_remains(&selection.remaining);
    let floor = floor
        .noise_floor(&observed, forces_remain, request.seed)
        .map_err(failed)?;
    let mut explained = Vec::new();
    for (subject, model) in Models::without_each(dictionary, selection) {
        let model = model.begun_as(&observed.curve);
        let faultless = corrected(test, &model.focus, &model.values)?;
        match model.scoring(hold, request.horizon).missing(&faultless) {
            Ok(without) => explained.push(Explained::new(subject, without)),
            // Without it the machine cannot move: there is nothing to show.
            Err(ScoreError::Solve(_)) => {}
            Err(error @ ScoreError::Smooth(_)) => return Err(failed(error)),
        }
    }
    let series = Series::new(models.in_series(), &observed, [&before, &after], explained)
        .map_err(located)?;
    Ok(HeldOut {
        scores: [before.score, after.score, floor],
        series,
        foretold,
    })
}

/// Whether sensors misread under some terms.
fn reads_otherwise(dictionary: &Dictionary, terms: &[usize]) -> bool {
    let inputs = &dictionary.machine.compiled.model.inputs;
    let is_input = |name: &String| inputs.iter().any(|input| input.name == *name);
    let mut terms = terms.iter().map(|&term| &dictionary.candidates[term]);
    terms.any(|term| term.channel && !term.subject.on().iter().any(is_input))
}

/// A log that is judged by, with what was learnt of noise.
fn as_observed(test: &Record, selection: &Selection, hold: Hold) -> Result<Observed, SmoothError> {
    let own = &selection.observed;
    let mut observed = Observed {
        input_noise: own.input_noise.clone(),
        correlation: own.correlation.clone(),
        ..Observed::new(test.clone(), hold)?
    };
    observed.err_as(own);
    Ok(observed)
}

/// The errors of the model with some terms, and with the dictionary's parameters at some values, on
/// what was learnt from.
pub(super) fn trained(
    dictionary: &Dictionary,
    (terms, values, observed): (&[usize], &[f64], &Observed),
    horizon: f64,
) -> Result<Score, TraceError> {
    let record = &observed.record;
    let failed = |error: ScoreError| match error {
        ScoreError::Smooth(error) => TraceError::Smooth(error),
        ScoreError::Solve(error) => TraceError::at(error, &record.t),
    };
    let model = Judged::new(dictionary, terms, values).begun_as(&observed.curve);
    let faultless = corrected(record, &model.focus, &model.values)?;
    let scoring = model.scoring(observed.hold, horizon);
    scoring.score(&faultless).map_err(failed)
}

/// The look of a model that cannot move.
pub(super) fn motionless(record: &Record, horizon: f64) -> Result<Look, SmoothError> {
    let states = savgol_states(record)?;
    let n = record.q.len();
    let nowhere = Errors::of(record, &vec![f64::INFINITY; n], &vec![1.0; n]);
    Ok(Look {
        inner: inner_samples(record, &states),
        score: Score {
            acceleration: nowhere.clone(),
            force: nowhere.clone(),
            rollout: RolloutErrors {
                horizon,
                windows: 0,
                diverged: 0,
                errors: nowhere,
            },
        },
        missing: vec![vec![f64::NAN; record.len()]; n],
        predicted: Predicted {
            q: vec![vec![f64::NAN; record.len()]; n],
            starts: Vec::new(),
            length: 0,
            travel: vec![f64::NAN; n],
        },
        states,
    })
}

/// Whether the patched model predicts worse: one measure is clearly worse, and another no better.
/// A single one misleads: where little moves, accelerations are mostly the filter's corners, and
/// predictions of an unstable machine run anywhere. Forces that are found in forces must be smaller there, unless
/// both that a model can move by are nearer with them.
pub(super) fn is_worse(basis: Basis, [before, after, _]: &[Score; 3]) -> bool {
    let ratio = |total: fn(&Score) -> f64| total(after) / total(before);
    let acceleration = ratio(|score| score.acceleration.total);
    let rollout = ratio(|score| score.rollout.errors.total);
    let force = ratio(|score| score.force.total);
    let worse = |a: f64, b: f64| a > WORSE && b >= 1.0;
    let moves_worse = worse(acceleration, rollout) || worse(rollout, acceleration);
    // What cannot move as given is infinitely wrong, and anything else nearer.
    let nearer = |ratio: f64| ratio > 0.0 && ratio < 1.0;
    let moves_better = nearer(acceleration) && nearer(rollout);
    moves_worse || basis == Basis::Forces && force > 1.0 && !moves_better
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn score([acceleration, rollout, force]: [f64; 3]) -> Score {
        let errors = |total| Errors {
            per_coordinate: BTreeMap::new(),
            total,
        };
        Score {
            acceleration: errors(acceleration),
            force: errors(force),
            rollout: RolloutErrors {
                horizon: 0.5,
                windows: 1,
                diverged: 0,
                errors: errors(rollout),
            },
        }
    }

    #[test]
    fn worse_takes_two_measures() {
        let worse =
            |basis, after| is_worse(basis, &[score([1.0; 3]), score(after), score([0.0; 3])]);
        let cases = [
            ([1.2, 0.9, 1.0], false),
            ([1.2, 1.0, 1.0], true),
            ([0.9, 1.2, 1.0], false),
            ([1.0, 1.2, 1.0], true),
            ([1.05, 1.05, 1.0], false),
            ([f64::NAN, f64::NAN, 0.5], false),
        ];
        for (after, expected) in cases {
            assert_eq!(worse(Basis::Motion, after), expected, "{after:?}");
            assert_eq!(worse(Basis::Forces, after), expected, "{after:?}");
        }
        for (after, expected) in [
            ([0.5, 0.5, 1.01], false),
            ([0.5, 1.01, 1.01], true),
            ([0.0, 0.0, 1.01], true),
        ] {
            assert_eq!(worse(Basis::Forces, after), expected, "{after:?}");
            assert!(!worse(Basis::Motion, after), "{after:?}");
        }
    }
}
