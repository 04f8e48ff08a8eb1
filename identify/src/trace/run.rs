//! The whole loop: log in, findings and patched model out.

use super::advice::advice;
use super::another_memory::is_another;
use super::between_samples::set_apart;
use super::blows;
use super::command::drives;
use super::conclude::judged;
use super::constraints::{check_corrected, check_measured};
use super::contradicted;
use super::described::with_open_losses;
use super::dictionary::{Dictionary, Ranges, Source};
use super::error::TraceError;
use super::estimate::Observed;
use super::finding::Verdict;
use super::learn::{Learner, Learnt};
use super::logs::{Logs, selected};
use super::microscope::View;
use super::misread;
use super::outcome::{Basis, Outcome};
use super::progress::{Progress, Silent, Stage};
use super::score::Score;
use super::search::Given;
use super::unmeasured::estimated;
use super::waves::missing;
use crate::floating::{ByRates, Unrated, as_given};
use crate::log::{Log, Record, said_of};
use crate::machine::Machine;
use crate::regression::Hold;
use dynamics_codegen::{Compiled, Library};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// What to trace.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// What messages call the model.
    pub model_name: &'a str,
    /// The model's text.
    pub model_text: &'a str,
    /// The effects that may be missing.
    pub library: &'a Library,
    /// Values that replace the model's nominal ones.
    pub parameters: BTreeMap<String, f64>,
    /// The log to learn from.
    pub train: &'a Log,
    /// A log to judge by; without one, the last third of `train` is kept apart.
    pub test: Option<&'a Log>,
    /// What inputs do between samples; found from the log if not stated.
    pub hold: Option<Hold>,
    /// How long open-loop predictions run, s.
    pub horizon: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Whether to search although columns of the log look mistaken beyond doubt.
    pub trust_columns: bool,
    /// Who is told how far the work is; [`Silent`](super::Silent) does not care.
    pub progress: &'a dyn Progress,
}

impl<'a> Request<'a> {
    /// A request with nothing stated but the model, the effects that may be missing and the log: the
    /// last third of it is kept apart to judge by, predictions run for 0.5 s, the seed is 1.
    pub fn new(
        model_name: &'a str,
        model_text: &'a str,
        library: &'a Library,
        train: &'a Log,
    ) -> Self {
        Self {
            model_name,
            model_text,
            library,
            parameters: BTreeMap::new(),
            train,
            test: None,
            hold: None,
            horizon: 0.5,
            seed: 1,
            trust_columns: false,
            progress: &Silent,
        }
    }

    /// The model, as text.
    fn source(&self) -> Source<'_> {
        Source {
            name: self.model_name,
            text: self.model_text,
            library: self.library,
            parameters: &self.parameters,
        }
    }

    /// The model as given, with values that it may have.
    fn compiled(&self) -> Result<Compiled, TraceError> {
        let plain = self.source().compile().map_err(Box::new)?;
        check_overrides(&plain, &self.parameters)?;
        Ok(plain)
    }

    /// The model with the losses that its description states as parameters, where they may be: as text, and compiled.
    fn with_open_losses(&self, plain: &Compiled) -> Option<(String, Compiled)> {
        let text = with_open_losses(self.model_text, &plain.model)?;
        let source = Source {
            text: &text,
            ..self.source()
        };
        // A parameter of the model may have such a name.
        let compiled = source.compile().ok()?;
        Some((text, compiled))
    }

    /// Model and logs by the rates of poses, if bodies float by their twists.
    fn by_rates(&self, plain: &Compiled) -> Result<Option<ByRates>, TraceError> {
        let source = (self.model_name, self.model_text, self.library);
        let by_rates = ByRates::of(source, &plain.model, (self.train, self.test));
        by_rates.map_err(|Unrated { body, report }| TraceError::Floats {
            body,
            report: Box::new(report),
        })
    }

    /// The same request by the rates of poses.
    fn with<'b>(&self, by_rates: &'b ByRates) -> Request<'b>
    where
        'a: 'b,
    {
        Request {
            model_text: &by_rates.text,
            train: &by_rates.train,
            test: by_rates.test.as_ref(),
            ..self.clone()
        }
    }
}

/// Finds what the model lacks.
///
/// # Errors
/// If the log, the model or the two together cannot be used; each error says the
/// place and the mend.
pub fn trace(request: &Request<'_>) -> Result<Outcome, TraceError> {
    request.progress.enter(Stage::Columns, &[]);
    let plain = request.compiled()?;
    let Some(by_rates) = request.by_rates(&plain)? else {
        return traced(request, plain);
    };
    let compiled = by_rates.compiled.clone();
    let mut outcome = traced(&request.with(&by_rates), compiled)?;
    let text = &outcome.patched_model;
    outcome.patched_model =
        as_given(request.model_name, text, request.library).map_err(Box::new)?;
    Ok(outcome)
}

/// What a model lacks that is compiled, whose positions each have a velocity of their own.
fn traced(request: &Request<'_>, plain: Compiled) -> Result<Outcome, TraceError> {
    let progress = request.progress;
    let (text, plain) = match request.with_open_losses(&plain) {
        Some((text, compiled)) => (Cow::Owned(text), compiled),
        None => (Cow::Borrowed(request.model_text), plain),
    };
    let source = Source {
        text: &text,
        ..request.source()
    };
    let logs = Logs::of(request, &source, &plain)?;
    let plain = Machine::new(plain);
    let misread = misread::misread(misread::Look {
        machine: &plain,
        values: &source.values(&plain),
        record: &logs.train,
        log: request.train,
    });
    let misread = match misread {
        Some(misread) => {
            progress.notice(&misread.to_string());
            if misread.is_decisive && !request.trust_columns {
                let outcome = misread::outcome(request, &source, logs, misread)?;
                return Ok(advised(outcome, request));
            }
            Some(misread)
        }
        None => None,
    };
    progress.enter(Stage::Smooth, &[]);
    let Logs { train, test, split } = logs;
    let observed = Observed::new(train, request.hold.unwrap_or(Hold::Linear))?;
    progress.enter(Stage::Derive, &[]);
    let ranges = ranges(&source, &plain, &observed);
    let dictionary = Dictionary::new(&source, &ranges).map_err(Box::new)?;
    let judging = Observed::new(test, observed.hold)?;
    let [observed, judging] = [
        (observed, request.train),
        (judging, request.test.unwrap_or(request.train)),
    ]
    .map(|(observed, log)| contradicted::set_aside(&dictionary, observed, log));
    let mut observed = blows::decided(&dictionary, observed?);
    let test = blows::decided(&dictionary, judging?).record;
    observed.believe(&dictionary)?;
    check_measured(&dictionary, &observed)?;
    progress.enter(Stage::Fit, &[]);
    // A model that cannot move says nothing of what moves it; its forces may be in balance.
    let felt = observed.as_felt(&dictionary, request.hold.is_none(), progress);
    let felt = felt.unwrap_or_else(|_| observed.clone());
    let learner = Learner {
        source,
        observed: &observed,
        felt: &felt,
        ranges: &ranges,
        horizon: request.horizon,
        seed: request.seed,
        free_hold: request.hold.is_none(),
        given: Given::default(),
        progress,
    };
    let mut learnt = learner.learn(dictionary)?;
    let unfinished = progress.ended();
    let between_samples = set_apart(&learnt.dictionary, &mut learnt.selection);
    let test = learnt.selection.observed.felt_in(&test);
    check_corrected(&learnt.dictionary, &learnt.selection)?;
    progress.enter(Stage::Judge, &[]);
    let judged = judged(learnt, &test, request)?;
    let Learnt {
        dictionary,
        selection,
        basis,
    } = &judged.learnt;
    let record = &selection.observed.record;
    let drives = drives(dictionary, record);
    let view = |terms, values, errors: [&Score; 2]| View {
        dictionary,
        selection,
        terms,
        values,
        errors: errors.map(|score| score.acceleration.total),
        test: &test,
        request,
    };
    let mut warnings = said_of(record, &test, request.test.is_some());
    let mut look = |view: View<'_>| {
        progress.enter(Stage::Look, &[]);
        let untold = |error| format!("the unexplained force cannot be described: {error}");
        view.look()
            .map_err(|error| warnings.push(untold(error)))
            .ok()
    };
    let terms = selection.accepted();
    let left = match judged.leaves_much() {
        true => {
            let errors = [&judged.learnt_errors, &judged.noise_floor];
            look(view(&terms, &selection.values, errors))
        }
        false => None,
    };
    let is_other = left
        .as_ref()
        .is_some_and(|left| left.is_a_law() || judged.foretells_nothing())
        || *basis == Basis::Motion && is_another(dictionary, selection);
    let verdict = judged.verdict(&drives, is_other);
    let unnamed = match verdict {
        Verdict::Unknown => {
            let errors = [&judged.before, &judged.noise_floor];
            look(view(&[], &dictionary.defaults, errors))
        }
        _ => left,
    };
    let observed = &selection.observed;
    let said = observed.said_of_inputs().chain(observed.said_of_sensors());
    warnings.extend(said.map(|warning| warning.to_string()));
    warnings.extend(selection.said_of_band());
    warnings.extend(judged.contradiction());
    let outcome = judged.outcome(request, split, (verdict, drives), warnings);
    let outcome = Outcome {
        misread,
        remaining: outcome.remaining.seen(unnamed.as_ref()),
        unnamed,
        unfinished,
        between_samples,
        ..outcome
    };
    Ok(advised(outcome, request))
}

/// The log that a request would learn from, whole, with estimates of the positions \[rad or m\] and velocities (per
/// second) of all coordinates that no column measures: a Kalman smoother through the model, from its sensors, its
/// constraints and the inputs, beside forces without a name as large as the log demands. Measured coordinates stay as
/// they were read. Inputs are drawn straight between samples unless the request says that they are held. A body that
/// floats by its twist has the seven positions of its pose and their rates.
///
/// # Errors
/// As of [`trace`], and if the sensors do not determine a coordinate.
pub fn smoothed(request: &Request<'_>) -> Result<Record, TraceError> {
    let plain = request.compiled()?;
    match request.by_rates(&plain)? {
        None => smooth(request, &plain),
        Some(by_rates) => smooth(&request.with(&by_rates), &by_rates.compiled),
    }
}

/// The log of a request as a compiled model reads it, whose positions each have a velocity of their own.
fn smooth(request: &Request<'_>, plain: &Compiled) -> Result<Record, TraceError> {
    let record = selected(request.train, plain)?;
    let hold = request.hold.unwrap_or(Hold::Linear);
    estimated(&request.source(), record, hold)
}

/// An outcome that says what to do next.
fn advised(outcome: Outcome, request: &Request<'_>) -> Outcome {
    Outcome {
        next: advice(&outcome, request.library),
        ..outcome
    }
}

/// Values in the stead of nominal ones are those of parameters, within their bounds.
fn check_overrides(plain: &Compiled, given: &BTreeMap<String, f64>) -> Result<(), TraceError> {
    let parameters = &plain.model.parameters;
    for (name, &value) in given {
        let Some(parameter) = parameters.iter().find(|p| p.name == *name) else {
            let known: Vec<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
            return Err(TraceError::UnknownParameter {
                name: name.clone(),
                known: known.join(", "),
            });
        };
        let (lower, upper) = (parameter.lower, parameter.upper);
        if !(lower..=upper).contains(&value) {
            return Err(TraceError::OutOfBounds {
                name: name.clone(),
                value,
                bounds: match (lower.is_finite(), upper.is_finite()) {
                    (true, true) => format!("{lower} to {upper}"),
                    (true, false) => format!("{lower} or more"),
                    (false, _) => format!("{upper} or less"),
                },
            });
        }
    }
    Ok(())
}

/// Where the log goes, and what the model as given lacks there.
fn ranges(source: &Source<'_>, plain: &Machine, observed: &Observed) -> Ranges {
    Ranges {
        missing: missing(plain, &source.values(plain), observed),
        ..observed.ranges()
    }
}
