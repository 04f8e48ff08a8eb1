//! The whole loop: log in, findings and patched model out.

use super::command::drives;
use super::constraints::{check_corrected, check_measured};
use super::dictionary::{Dictionary, Ranges, Source};
use super::error::TraceError;
use super::estimate::Observed;
use super::finding::{Finding, Verdict, findings, verdict};
use super::forces;
use super::judge::{is_worse, judge};
use super::learn::{Learner, Learnt};
use super::logs::Logs;
use super::microscope::{MicroscopeError, Unnamed, look};
use super::misread::misread;
use super::outcome::{Basis, Outcome};
use super::patch::patch;
use super::progress::{Progress, Stage};
use super::score::{Score, Scoring};
use super::select::Selection;
use super::series::{Details, Series, weighed};
use super::waves::missing;
use crate::log::{Log, Record};
use crate::machine::Machine;
use crate::regression::Hold;
use dynamics_codegen::{Compiled, Library};
use std::collections::{BTreeMap, BTreeSet};

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
    /// Who is told how far the work is; [`Silent`](super::Silent) does not care.
    pub progress: &'a dyn Progress,
}

/// An error below this many times the noise floor is the floor.
const AT_FLOOR: f64 = 1.05;
/// The same of open-loop predictions, of which a log holds few; where there are none, they say
/// nothing.
const ROLLOUT_AT_FLOOR: f64 = 1.5;

/// Finds what the model lacks.
///
/// # Errors
/// If the log, the model or the two together cannot be used; each error says the
/// place and the mend.
pub fn trace(request: &Request<'_>) -> Result<Outcome, TraceError> {
    let progress = request.progress;
    let source = Source {
        name: request.model_name,
        text: request.model_text,
        library: request.library,
        parameters: &request.parameters,
    };
    progress.enter(Stage::Smooth, &[]);
    let plain = source.compile().map_err(Box::new)?;
    check_overrides(&plain, &request.parameters)?;
    let Logs { train, test, split } = Logs::of(request, &plain)?;
    let mut observed = Observed::new(train, request.hold.unwrap_or(Hold::Linear))?;
    progress.enter(Stage::Derive, &[]);
    let ranges = ranges(&source, plain, &observed);
    let dictionary = Dictionary::new(&source, &ranges).map_err(Box::new)?;
    observed.believe(&dictionary)?;
    check_measured(&dictionary, &observed)?;
    let misread = misread(&dictionary, &observed.record);
    progress.enter(Stage::Fit, &[]);
    let learner = Learner {
        source,
        observed: &observed,
        ranges: &ranges,
        free_hold: request.hold.is_none(),
        progress,
    };
    let mut learnt = learner.learn(dictionary)?;
    check_corrected(&learnt.dictionary, &learnt.selection)?;
    progress.enter(Stage::Judge, &[]);
    let mut judgement = judged(&learnt, &test, request)?;
    // What predicts worse than the model as given explains nothing, whatever its evidence.
    let worse = is_worse(learnt.basis, &judgement.0);
    if worse {
        learnt.selection = learnt.selection.without_terms(&learnt.dictionary);
        judgement = judged(&learnt, &test, request)?;
    }
    let ([before, after, noise_floor], series) = judgement;
    let Learnt {
        dictionary,
        selection,
        basis,
    } = learnt;
    let record = &selection.observed.record;
    let drives = drives(&dictionary, record);
    let verdict = if worse {
        Verdict::Unknown
    } else {
        let explained = basis == Basis::Forces || is_at_floor(&after, &noise_floor);
        match verdict(&dictionary, &selection, explained) {
            Verdict::None | Verdict::Parameter if !drives.is_empty() => Verdict::Channel,
            verdict => verdict,
        }
    };
    // Of both halves of one log the same is said once.
    let mut said = BTreeSet::new();
    let sources = record.warnings.iter().chain(&test.warnings);
    let mut warnings: Vec<String> = sources.map(ToString::to_string).collect();
    warnings.retain(|warning| said.insert(warning.clone()));
    let unnamed = match verdict {
        Verdict::Unknown => {
            progress.enter(Stage::Look, &[]);
            let errors = (before.acceleration.total, noise_floor.acceleration.total);
            let seen = seen(&dictionary, &selection, &test, errors, request);
            let untold = |error| format!("the unexplained force cannot be described: {error}");
            seen.map_err(|error| warnings.push(untold(error))).ok()
        }
        _ => None,
    };
    let told = |f: &Finding| {
        let same = |d: &Finding| (&d.effect, &d.on) == (&f.effect, &f.on);
        drives.iter().any(same)
    };
    let by_motion = findings(&dictionary, &selection).into_iter();
    let by_motion = by_motion.filter(|finding| !told(finding));
    let found: Vec<Finding> = drives.iter().cloned().chain(by_motion).collect();
    // What does not explain the log is not written into the model; what two measured columns
    // say of a drive is.
    let written = match verdict {
        Verdict::Unknown => &drives,
        _ => &found,
    };
    let provenance = provenance(basis, &before, &after, &split.train_log, request.seed);
    let robot = dictionary.machine.compiled.model.robot.as_ref();
    let described = robot.map_or(&[][..], |robot| &robot.described);
    Ok(Outcome {
        verdict,
        basis,
        patched_model: patch(request.model_text, written, described, &provenance),
        findings: found,
        before,
        after,
        noise_floor,
        unnamed,
        misfit_before: selection.nominal_misfit,
        misfit_after: selection.reduced_misfit,
        sensor_noise: sensor_noise(&selection.observed),
        input_hold: selection.observed.hold,
        split,
        seed: request.seed,
        misread,
        warnings,
        details: Details {
            considered: weighed(&dictionary, &selection),
            series,
        },
        remaining: selection.remaining,
    })
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
fn ranges(source: &Source<'_>, plain: Compiled, observed: &Observed) -> Ranges {
    let machine = Machine::new(plain);
    Ranges {
        missing: missing(&machine, &source.values(&machine), observed),
        ..observed.ranges()
    }
}

fn judged(
    learnt: &Learnt,
    test: &Record,
    request: &Request<'_>,
) -> Result<([Score; 3], Series), TraceError> {
    let Learnt {
        dictionary,
        selection,
        basis,
    } = learnt;
    let hold = selection.observed.hold;
    match basis {
        Basis::Forces => forces::judge(dictionary, selection, test, request, hold),
        Basis::Motion => judge(dictionary, selection, test, request, hold),
    }
}

/// Whether a model is as near to a log as sensor noise allows.
fn is_at_floor(score: &Score, floor: &Score) -> bool {
    let [predicted, possible] = [score, floor].map(|score| score.rollout.errors.total);
    score.acceleration.total < AT_FLOOR * floor.acceleration.total
        && (predicted.is_nan() || predicted <= ROLLOUT_AT_FLOOR * possible)
}

/// What the missing force looks like.
fn seen(
    dictionary: &Dictionary,
    selection: &Selection,
    test: &Record,
    errors: (f64, f64),
    request: &Request<'_>,
) -> Result<Unnamed, MicroscopeError> {
    let focus = dictionary.focus(&[]);
    let scoring = Scoring {
        machine: &focus.machine,
        values: &focus.values(&dictionary.defaults),
        hold: selection.observed.hold,
        horizon: request.horizon,
    };
    look(dictionary, selection, &scoring, test, errors, request.seed)
}

/// What the patched model says about its additions.
fn provenance(basis: Basis, before: &Score, after: &Score, log: &str, seed: u64) -> String {
    let scores = [before, after];
    let (kind, [error_before, error_after]) = match basis {
        Basis::Motion => ("acceleration", scores.map(|s| s.acceleration.total)),
        Basis::Forces => ("force", scores.map(|s| s.force.total)),
    };
    let rollouts = match scores.map(|s| s.rollout.errors.total) {
        [before, after] if before.is_finite() => format!(", rollout {before:.3} -> {after:.3}"),
        _ => String::new(),
    };
    format!(
        "dynamics trace, {log}: held-out {kind} error {error_before:.3} -> {error_after:.3}{rollouts} (seed {seed})"
    )
}

fn sensor_noise(observed: &Observed) -> BTreeMap<String, f64> {
    let record = &observed.record;
    let mut noise = BTreeMap::new();
    for (i, name) in record.coordinates.iter().enumerate() {
        noise.insert(format!("q_{name}"), observed.position_sd[i]);
        if record.dq[i].is_some() {
            noise.insert(format!("dq_{name}"), observed.velocity_sd[i]);
        }
        if record.ddq[i].is_some() {
            noise.insert(format!("ddq_{name}"), observed.acceleration_sd[i]);
        }
    }
    noise
}
