//! The whole loop: log in, findings and patched model out.

use super::command::drives;
use super::corrected::corrected;
use super::described::opened;
use super::dictionary::Dictionary;
use super::error::TraceError;
use super::estimate::Observed;
use super::finding::{Finding, Verdict, findings, verdict};
use super::forces;
use super::judge::{is_worse, judge};
use super::microscope::{Unnamed, look};
use super::misread::misread;
use super::patch::patch;
use super::progress::{Progress, Stage};
use super::score::{Score, Scoring};
use super::select::{Remaining, Selection, likelier_hold, select};
use super::series::{Details, weighed};
use crate::log::{Log, Record};
use crate::machine::SolveError;
use crate::regression::Hold;
use dynamics_codegen::model::ConstraintKind;
use dynamics_codegen::syntax::PortKind;
use dynamics_codegen::{Compiled, Library};
use serde::Serialize;
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
    /// Who is told how far the work is; [`Silent`](super::Silent) does not care.
    pub progress: &'a dyn Progress,
}

/// Which samples served what.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Split {
    /// The log that was learnt from.
    pub train_log: String,
    /// Its samples that were used.
    pub train_samples: usize,
    /// The log that was judged by.
    pub test_log: String,
    /// Its samples that were used.
    pub test_samples: usize,
    /// How the two were kept apart.
    pub method: String,
}

/// What effects were found in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Motion as it follows from inputs: what explains it leaves sensor noise.
    Motion,
    /// The balance of measured forces: many effects at once, or a model that cannot move as
    /// given. Other forces remain.
    Forces,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// What kind of error the model has.
    pub verdict: Verdict,
    /// What effects were found in.
    pub basis: Basis,
    /// What it lacks, strongest first.
    pub findings: Vec<Finding>,
    /// Errors on data that neither fitting nor selection saw, of the model as given.
    pub before: Score,
    /// The same of the patched model.
    pub after: Score,
    /// The same if the patched model were exactly right.
    pub noise_floor: Score,
    /// What the findings leave unexplained.
    pub remaining: Remaining,
    /// What has no name, if the verdict says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unnamed: Option<Unnamed>,
    /// Mean squared whitened prediction error on the training data, of the model as given.
    pub misfit_before: f64,
    /// The same of the patched model; one if sensor noise explains it.
    pub misfit_after: f64,
    /// Estimated standard deviation of each channel's noise.
    pub sensor_noise: BTreeMap<String, f64>,
    /// What inputs do between samples.
    pub input_hold: Hold,
    /// Which samples served what.
    pub split: Split,
    /// Seed of everything random.
    pub seed: u64,
    /// Mistakes in the columns of the log under which the model would explain it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub misread: Vec<String>,
    /// What should be known about the logs.
    pub warnings: Vec<String>,
    /// The model with the findings written in.
    pub patched_model: String,
    /// Curves and candidates, for plots; not part of the JSON outcome.
    #[serde(skip)]
    pub details: Details,
}

/// An error below this many times the noise floor is the floor.
const AT_FLOOR: f64 = 1.05;
/// The same of open-loop predictions, of which a log holds few; where there are none, they say
/// nothing.
const ROLLOUT_AT_FLOOR: f64 = 1.5;
/// Fewest samples for learning, and for judging.
const FEWEST: usize = 50;
/// More terms than this are suspicious: one wrong length looks like many effects.
const FEW_TERMS: usize = 2;
/// Between learning and judging, s.
const GUARD: f64 = 0.5;

/// Finds what the model lacks.
///
/// # Errors
/// If the log, the model or the two together cannot be used; each error says the
/// place and the mend.
pub fn trace(request: &Request<'_>) -> Result<Outcome, TraceError> {
    let Request {
        model_name,
        model_text,
        library,
        progress,
        ..
    } = *request;
    progress.enter(Stage::Smooth, &[]);
    let plain = dynamics_codegen::compile(model_name, model_text, library).map_err(Box::new)?;
    check_overrides(&plain, &request.parameters)?;
    let (train, test, split) = split(request, &plain)?;
    let train = thinned(train);
    let (train, test) = as_driven(&plain, train, test);
    let observed = Observed::new(train, request.hold.unwrap_or(Hold::Linear))?;
    let ranges = observed.ranges();
    progress.enter(Stage::Derive, &[]);
    let of_text = |text: &str| {
        Dictionary::new(model_name, text, library, &request.parameters, &ranges).map_err(Box::new)
    };
    let mut dictionary = of_text(model_text)?;
    let times = observed.record.t.clone();
    let located = |source: SolveError| TraceError::at(source, &times);
    check_motion(&observed.record, &split.train_log)?;
    check_motion(&test, &split.test_log)?;
    check_constraints(&dictionary, &observed)?;
    let misread = misread(&dictionary, &observed.record);
    progress.enter(Stage::Fit, &[]);
    let immobile = is_immobile(&dictionary, &observed);
    let by_forces = forces::learn(&dictionary, &observed, immobile)?;
    let by_motion = |dictionary: &Dictionary| -> Result<Selection, SolveError> {
        let mut observed = observed.clone();
        if request.hold.is_none() {
            observed.hold = likelier_hold(dictionary, &observed)?;
        }
        select_with_slow_errors(dictionary, observed, request.hold.is_none(), progress)
    };
    let (mut basis, mut selection) = match by_forces {
        None => (Basis::Motion, by_motion(&dictionary).map_err(located)?),
        Some(forces) if immobile => (Basis::Forces, forces),
        // One sensor that misreads makes forces everywhere: what explains the motion with less
        // is right.
        Some(forces) => match by_motion(&dictionary) {
            Ok(motion) if motion.explains_with_less(&forces) => (Basis::Motion, motion),
            _ => (Basis::Forces, forces),
        },
    };
    // What effects do not explain, or many only together, may be a number of the description.
    let is_suspicious = selection.forces_remain() || selection.terms.len() > FEW_TERMS;
    if !immobile
        && is_suspicious
        && let Some(text) = opened(model_text)
    {
        progress.enter(Stage::Derive, &[]);
        let given = (model_name, text.as_str(), library);
        let parameters = &request.parameters;
        // Neither compiles where the model has names of its own like the description's.
        let numbers = Dictionary::of_parameters(given.0, given.1, given.2, parameters, &ranges);
        let is_better = |other: &Selection| {
            other.explains_with_less(&selection) || other.leaves_much_less(&selection)
        };
        if let Ok(numbers) = numbers
            && by_motion(&numbers).is_ok_and(|alone| is_better(&alone))
            && let Ok(open) = of_text(&text)
            && let Ok(other) = by_motion(&open)
            && is_better(&other)
        {
            (dictionary, selection, basis) = (open, other, Basis::Motion);
        }
    }
    let hold = selection.observed.hold;
    progress.enter(Stage::Judge, &[]);
    let judged = |selection: &Selection| match basis {
        Basis::Forces => forces::judge(&dictionary, selection, &test, request, hold),
        Basis::Motion => judge(&dictionary, selection, &test, request, hold),
    };
    let mut judgement = judged(&selection)?;
    // What predicts worse than the model as given explains nothing, whatever its evidence.
    let worse = is_worse(basis, &judgement.0);
    if worse {
        selection = selection.without_terms(&dictionary);
        judgement = judged(&selection)?;
    }
    let ([before, after, noise_floor], series) = judgement;
    let observed = &selection.observed;
    let drives = drives(&dictionary, &observed.record);
    let told = |f: &Finding| {
        drives
            .iter()
            .any(|d| (&d.effect, &d.on) == (&f.effect, &f.on))
    };
    let by_motion = findings(&dictionary, &selection).into_iter();
    let found: Vec<Finding> = (drives.iter().cloned())
        .chain(by_motion.filter(|finding| !told(finding)))
        .collect();
    let [predicted, possible] = [&after, &noise_floor].map(|score| score.rollout.errors.total);
    let at_floor = after.acceleration.total < AT_FLOOR * noise_floor.acceleration.total
        && (predicted.is_nan() || predicted <= ROLLOUT_AT_FLOOR * possible);
    let verdict = if worse {
        Verdict::Unknown
    } else {
        match verdict(&dictionary, &selection, at_floor || basis == Basis::Forces) {
            Verdict::None | Verdict::Parameter if !drives.is_empty() => Verdict::Channel,
            verdict => verdict,
        }
    };
    let sources = observed.record.warnings.iter().chain(&test.warnings);
    let mut warnings: Vec<String> = sources.map(ToString::to_string).collect();
    let unnamed = match verdict {
        Verdict::Unknown => {
            let focus = dictionary.focus(&[]);
            let scoring = Scoring {
                machine: &focus.machine,
                values: &focus.values(&dictionary.defaults),
                hold,
                horizon: request.horizon,
            };
            progress.enter(Stage::Look, &[]);
            let errors = (before.acceleration.total, noise_floor.acceleration.total);
            let seen = look(
                &dictionary,
                &selection,
                &scoring,
                &test,
                errors,
                request.seed,
            );
            match seen {
                Ok(unnamed) => Some(unnamed),
                Err(error) => {
                    warnings.push(format!(
                        "the unexplained force cannot be described: {error}"
                    ));
                    None
                }
            }
        }
        _ => None,
    };
    let (kind, [error_before, error_after]) = match basis {
        Basis::Motion => (
            "acceleration",
            [&before, &after].map(|s| s.acceleration.total),
        ),
        Basis::Forces => ("force", [&before, &after].map(|s| s.force.total)),
    };
    let rollouts = [&before, &after].map(|s| s.rollout.errors.total);
    let rollouts = match rollouts {
        [before, after] if before.is_finite() => format!(", rollout {before:.3} -> {after:.3}"),
        _ => String::new(),
    };
    let provenance = format!(
        "dynamics trace, {}: held-out {kind} error {error_before:.3} -> {error_after:.3}{rollouts} (seed {})",
        split.train_log, request.seed
    );
    let robot = dictionary.machine.compiled.model.robot.as_ref();
    let described = robot.map_or(&[][..], |robot| &robot.described);
    Ok(Outcome {
        verdict,
        basis,
        // What does not explain the log is not written into the model; what two measured
        // columns say of a drive is.
        patched_model: match verdict {
            Verdict::Unknown => patch(model_text, &drives, described, &provenance),
            _ => patch(model_text, &found, described, &provenance),
        },
        findings: found,
        before,
        after,
        noise_floor,
        unnamed,
        remaining: selection.remaining,
        misfit_before: selection.nominal_misfit,
        misfit_after: selection.reduced_misfit,
        sensor_noise: sensor_noise(observed),
        input_hold: hold,
        split,
        seed: request.seed,
        misread,
        warnings,
        details: Details {
            considered: weighed(&dictionary, &selection),
            series,
        },
    })
}

/// Selects under the noise that the sensors show from sample to sample; where what
/// remains is faint but real, also under larger noise. A real sensor's slow errors (an
/// encoder that is not quite round) look like faint forces to a filter that believes the
/// sensor. Which noise is right shows in open-loop predictions along the training log.
fn select_with_slow_errors(
    dictionary: &Dictionary,
    observed: Observed,
    free_hold: bool,
    progress: &dyn Progress,
) -> Result<Selection, SolveError> {
    let start = observed.clone();
    let mut best = select(dictionary, observed, free_hold, progress)?;
    let faint = best.remaining.share_after < FAINT_SHARE;
    if best.terms.is_empty() || !faint || verdict(dictionary, &best, false) != Verdict::Unknown {
        return Ok(best);
    }
    let prediction_error = |selection: &Selection| {
        let focus = dictionary.focus(&selection.accepted());
        let scoring = Scoring {
            machine: &focus.machine,
            values: &focus.values(&selection.values),
            hold: selection.observed.hold,
            horizon: JUDGED_HORIZON,
        };
        let record = corrected(&start.record, &focus, scoring.values).ok()?;
        let score = scoring.score(&record).ok()?;
        Some(score.rollout.errors.total).filter(|error| error.is_finite())
    };
    let mut lowest = prediction_error(&best).unwrap_or(f64::INFINITY);
    for factor in LARGER_NOISE {
        let mut noisier = start.clone();
        noisier.scale_noise(factor);
        // Noise under which nothing can be fitted is none.
        let Ok(selection) = select(dictionary, noisier, free_hold, progress) else {
            continue;
        };
        let Some(error) = prediction_error(&selection) else {
            continue;
        };
        if error < WORTH_IT * lowest {
            (lowest, best) = (error, selection);
        }
    }
    Ok(best)
}

/// Share of the accelerations below which what remains may be a sensor's slow error.
const FAINT_SHARE: f64 = 0.01;
/// Multiples of the sensors' noise to try.
const LARGER_NOISE: [f64; 2] = [3.0, 10.0];
/// Larger noise must bring predictions at least this much nearer to the log.
const WORTH_IT: f64 = 0.9;
/// How long the predictions run that judge between noises, s.
const JUDGED_HORIZON: f64 = 1.0;

/// Without inputs nothing happens between samples that the model does not predict, and
/// sensor errors of neighbouring samples resemble each other more than white noise does:
/// a fast log is thinned before it is learnt from.
fn thinned(train: Record) -> Record {
    let stride = (1.0 / (FASTEST * train.step())).floor();
    if train.inputs.is_empty() && stride > 1.0 && train.len() as f64 / stride > FEWEST as f64 {
        train.thinned(stride as usize)
    } else {
        train
    }
}

/// Samples per second beyond which a log without inputs is thinned.
const FASTEST: f64 = 200.0;

fn check_overrides(plain: &Compiled, given: &BTreeMap<String, f64>) -> Result<(), TraceError> {
    let known: Vec<&str> = plain
        .model
        .parameters
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    match given.keys().find(|name| !known.contains(&name.as_str())) {
        None => Ok(()),
        Some(name) => Err(TraceError::UnknownParameter {
            name: name.clone(),
            known: known.join(", "),
        }),
    }
}

/// The records with the command as the input wherever the model says what the drive makes of
/// it: elsewhere the input is what was measured.
fn as_driven(plain: &Compiled, train: Record, test: Record) -> (Record, Record) {
    let driven = |record: Record| {
        let mut record = record;
        let inputs = record.inputs.clone();
        for (i, name) in inputs.iter().enumerate() {
            let mut effects = plain.model.effects.iter();
            let on_it = |kind: &PortKind, on: &String| *kind == PortKind::Input && on == name;
            let is_driven = effects.any(|e| e.on.iter().any(|(kind, on)| on_it(kind, on)));
            if is_driven && let Some(command) = record.commanded[i].take() {
                record.u[i] = command;
            }
        }
        record
    };
    (driven(train), driven(test))
}

/// Whether the model as given cannot be solved for accelerations along the log.
fn is_immobile(dictionary: &Dictionary, observed: &Observed) -> bool {
    let focus = dictionary.focus(&[]);
    let values = focus.values(&dictionary.defaults);
    let motion = focus.machine.motion(&observed.curve, &values);
    matches!(motion, Err(SolveError::Singular { .. }))
}

/// What to learn from and what to judge by.
fn split(request: &Request<'_>, plain: &Compiled) -> Result<(Record, Record, Split), TraceError> {
    let coordinates: Vec<String> = plain
        .model
        .coordinates
        .iter()
        .map(|c| c.name.clone())
        .collect();
    let inputs: Vec<String> = plain.model.inputs.iter().map(|u| u.name.clone()).collect();
    let whole = request.train.select(&coordinates, &inputs)?;
    let name = |log: &Log| {
        log.path
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    };
    let (train, test, method) = match request.test {
        Some(test) => (
            whole,
            test.select(&coordinates, &inputs)?,
            "a log of its own".to_string(),
        ),
        None => {
            let needed = 3 * FEWEST;
            if whole.len() < needed {
                return Err(TraceError::TooShort {
                    samples: whole.len(),
                    needed,
                });
            }
            let begin = whole.len() - whole.len() / 3;
            let guard = whole
                .t
                .partition_point(|&t| t < whole.t[begin] - GUARD)
                .max(FEWEST);
            let method = format!("the last third of the log, {GUARD} s apart");
            (
                whole.slice(0..guard),
                whole.slice(begin..whole.len()),
                method,
            )
        }
    };
    let split = Split {
        train_log: name(request.train),
        train_samples: train.len(),
        test_log: name(request.test.unwrap_or(request.train)),
        test_samples: test.len(),
        method,
    };
    Ok((train, test, split))
}

/// Something must move.
fn check_motion(record: &Record, log: &str) -> Result<(), TraceError> {
    let moves = |q: &Vec<f64>| q.iter().any(|x| *x != q[0]);
    match record.q.iter().any(moves) {
        true => Ok(()),
        false => Err(TraceError::Motionless {
            log: log.to_string(),
        }),
    }
}

/// Holonomic constraints must hold in the measured positions themselves.
fn check_constraints(dictionary: &Dictionary, observed: &Observed) -> Result<(), TraceError> {
    let focus = dictionary.focus(&[]);
    let machine = &focus.machine;
    let measured = crate::machine::States {
        q: observed.record.q.clone(),
        ..observed.curve.clone()
    };
    let terms = machine.terms(&measured, &focus.values(&dictionary.defaults));
    let travel: Vec<f64> = observed
        .ranges()
        .positions
        .iter()
        .map(|sorted| sorted[sorted.len() - 1] - sorted[0])
        .collect();
    for (row, constraint) in machine.compiled.model.constraints.iter().enumerate() {
        if constraint.kind != ConstraintKind::Holonomic {
            continue;
        }
        let (mut square, mut noise, mut scale, mut worst) = (0.0, 0.0, 0.0_f64, (0.0, 0.0));
        for (sample, at) in terms.iter().enumerate() {
            let c = at.constraint_residual[row];
            square += c * c;
            if c.abs() > worst.0 {
                worst = (c.abs(), measured.t[sample]);
            }
            for i in 0..travel.len() {
                let slope = at.constraint_matrix[(row, i)];
                noise += (slope * observed.position_sd[i]).powi(2);
                scale = scale.max((slope * travel[i].min(1.0)).abs());
            }
        }
        let violation = (square / terms.len() as f64).sqrt();
        let expected = (noise / terms.len() as f64).sqrt();
        if !(violation <= 20.0 * expected || violation <= GROSS_VIOLATION * scale) {
            return Err(TraceError::Constraint {
                constraint: constraint.name.clone(),
                violation,
                expected,
                time: worst.1,
                worst: worst.0,
            });
        }
    }
    Ok(())
}

/// A violation below this share of the coordinates' travel (a turn counts as 1 rad) may be a geometry that
/// is a little off; above, it is another machine.
const GROSS_VIOLATION: f64 = 0.05;

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
