//! Parameters of a machine whose forces were measured: linear regression of the inverse
//! dynamics.
//!
//! ```text
//! Q_D + B u − (M a − Q_C) = Y(q, v, a) δφ + F(q, v, a) ψ + noise
//! ```
//!
//! `δφ` are corrections to the bodies' standard inertial parameters, drawn to the model's
//! own values by a prior; `ψ` are friction, rotor inertia, offset and couplings, each
//! taken in only if it predicts blocks of the log that it was not fitted to. One point mass on a
//! body competes with them: `δφ` of that body is then `m (1, p, …)`, which is not linear in its
//! place `p`. What the model states of all these already is where the estimate begins. Under
//! constraints the equations are projected onto the directions that no multiplier
//! reaches, the null space of `A`. Errors are reported on a part of the log that nothing was fitted to.

mod columns;
mod compare;
mod consistent;
mod correction;
mod efforts;
mod equations;
mod estimate;
mod extended;
mod frame;
mod groups;
mod inertial;
mod judged;
mod losses;
mod narrowing;
mod neighbours;
mod page;
mod point;
mod select;
mod signs;
mod unmeasured;
mod written;

pub use compare::{
    Base, Comparison, ConstraintError, Kind, Process, Row, Settings, compare,
    page as comparison_page,
};
pub use efforts::{LeftOut, Reason};
pub use inertial::{Doubt, InertialParameter};
pub use judged::{Curves, Error, ForceSeries};
pub use page::page;
pub(crate) use page::{percent, rows};
pub use written::{Source, Unwritable, written};

use crate::floating::{ByRates, Unrated};
use crate::log::{Gauge, Log, LogError, Record, said_of};
use crate::machine::{Machine, SolveError};
use crate::number::short;
use crate::smooth::SmoothError;
use crate::trace::TraceError;
use columns::Columns;
use correction::Correction;
use dynamics_codegen::{Compiled, Report};
use efforts::no_forces;
use equations::Equations;
use estimate::{Estimate, Signs, estimate};
use groups::{Coefficient, Group};
use inertial::inertial;
use judged::{curves, errors, floor};
use serde::Serialize;
use std::collections::BTreeMap;
use unmeasured::taken_as_measured;

/// How inertial parameters are treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Inertia {
    /// They are the model's.
    Fixed,
    /// Linear regression: any numbers, near the model's where the log is silent.
    Linear,
    /// Only numbers that a rigid body can have (log-Cholesky, Rucker and Wensing 2022).
    Consistent,
}

/// What to fit.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// The model as text, with the effects that may be missing.
    pub source: Source<'a>,
    /// The same, compiled.
    pub compiled: &'a Compiled,
    /// Its parameters' values.
    pub parameters: &'a [f64],
    /// The log to learn from.
    pub train: &'a Log,
    /// A log to judge by; without one, the last third of `train` is kept apart.
    pub test: Option<&'a Log>,
    /// How inertial parameters are treated.
    pub inertia: Inertia,
    /// Coordinates whose efforts are not to be learnt from.
    pub leave_out: &'a [String],
    /// Whether to learn from efforts although they look like no forces of their joints.
    pub trust_columns: bool,
}

impl<'a> Request<'a> {
    /// A request with nothing stated but the model, its parameters' values and the log: the last third
    /// of it is kept apart to judge by, inertial parameters may be any numbers, every coordinate is learnt from.
    pub fn new(
        source: Source<'a>,
        compiled: &'a Compiled,
        parameters: &'a [f64],
        train: &'a Log,
    ) -> Self {
        Self {
            source,
            compiled,
            parameters,
            train,
            test: None,
            inertia: Inertia::Linear,
            leave_out: &[],
            trust_columns: false,
        }
    }
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Value {
    /// The estimate.
    pub value: f64,
    /// Its standard error; errors that follow one another are accounted for by blocks. Not a
    /// number (`null` in JSON) where the value is held at zero, below which it cannot be, and
    /// infinite (also `null`) where only the bounds of inertias moved it away from there.
    pub std: f64,
}

/// A group of terms that the model lacked.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Term {
    /// What its effects say that they are part of: `term friction;`.
    pub term: String,
    /// The coordinates, or the body, that it acts on.
    pub on: Vec<String>,
    /// Its coefficients by name, with what the model states of them already.
    pub coefficients: BTreeMap<String, Value>,
    /// What the model states of them, where it does.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub stated: BTreeMap<String, f64>,
    /// By how much it lowers the mean squared error of blocks it was not fitted to, as a
    /// share of what was left before it.
    pub gain: f64,
    /// By how many nats these blocks are likelier with it.
    pub evidence: f64,
    /// Of a payload: whether it is where the body's own centre of mass is, so that the body may as
    /// well be heavier than stated.
    pub may_be_body: bool,
    #[serde(skip)]
    details: Details,
}

/// What is needed to write a term into a model.
#[derive(Debug, Clone, PartialEq)]
struct Details {
    /// What the coefficients are of.
    coefficients: Vec<Coefficient>,
    /// Shapes of its effects: effect, parameter, value.
    shapes: Vec<(String, String, f64)>,
    /// Whether it is a load: its first coefficient is a mass, the others a place.
    is_load: bool,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Fit {
    /// Error of the model as given, on data that nothing was fitted to.
    pub before: Error,
    /// The same with the new terms and the corrected inertias.
    pub after: Error,
    /// What the measured forces vary by: their standard deviations. Zero along a coordinate that no
    /// input drives.
    pub measured: Error,
    /// What noise of the position, velocity and acceleration sensors alone would leave of them, were
    /// the model exactly right; not known under constraints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<Error>,
    /// Coordinates whose efforts are no forces of theirs, or are not to be learnt from: nothing of them
    /// enters the fit, and they have no errors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// Whether the error after is larger than before: what follows fits the log it was learnt from and nothing else.
    pub worse: bool,
    /// Terms, in the order in which they were taken in.
    pub terms: Vec<Term>,
    /// How inertial parameters were treated; held where corrections do not predict.
    pub inertia: Inertia,
    /// The inertial parameters; empty if they were held.
    pub inertial: Vec<InertialParameter>,
    /// How many combinations of inertial parameters any motion could determine (the base
    /// parameters).
    pub base_parameters: usize,
    /// How many combinations this log determines better than its prior: those whose
    /// variance it has at least halved.
    pub determined: usize,
    /// Samples learnt from, and judged by.
    pub samples: (usize, usize),
    /// What should be known about the logs.
    pub warnings: Vec<String>,
    /// Curves along the log that was judged by, for a page; not part of the JSON.
    #[serde(skip)]
    pub curves: Curves,
    /// Nats by which corrected inertias make blocks likelier that they were not fitted to.
    #[serde(skip)]
    inertia_evidence: f64,
}

/// Why a log could not be fitted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// The log cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log cannot be smoothed.
    #[error(transparent)]
    Smooth(#[from] SmoothError),
    /// The equation of motion has no solution somewhere along the log.
    #[error("the model cannot be evaluated along the log: {0}")]
    Solve(#[from] SolveError),
    /// The model says what cannot be said of a body that floats by the rates of its pose.
    #[error("{}", crate::trace::unrated(.body, .report))]
    Floats {
        /// Which.
        body: String,
        /// What the compiler says.
        report: Box<Report>,
    },
    /// Nothing measured.
    #[error(
        "the model has no input: without measured forces only ratios of parameters show; \
         use `dynamics trace`, or `dynamics fit --compare` to let Gaussian processes learn what \
         the model leaves"
    )]
    NoInput,
    /// What is to be left out is not there.
    #[error("`{name}` is no coordinate of the model; there are {known}")]
    NoCoordinate {
        /// What it was called.
        name: String,
        /// What there is.
        known: String,
    },
    /// Nothing can be learnt from.
    #[error(
        "no effort of the log is a force that the model knows ({each}); a map of the log says what the \
         columns are (docs/log-format.md), and --trust-columns fits all the same"
    )]
    NoForce {
        /// Why, by coordinate.
        each: String,
    },
    /// Too little.
    #[error("the log has {samples} samples; at least {needed} are needed")]
    TooShort {
        /// What there is.
        samples: usize,
        /// What is needed.
        needed: usize,
    },
    /// Nothing moves.
    #[error("nothing moves along the log: there is nothing to learn from")]
    Motionless,
    /// A Gaussian process cannot be set up.
    #[error("what the model leaves cannot be learnt: {0}")]
    Process(#[from] gp::GpError),
    /// What the sensors' noise leaves is not known.
    #[error("the noise floor of the forces cannot be found: {0}")]
    Floor(Box<TraceError>),
    /// A coordinate that no column shows cannot be estimated.
    #[error(transparent)]
    Unmeasured(Box<TraceError>),
    /// An effect of the library does not fit the model.
    #[error("an effect that is part of a term does not compile with the model:\n{0}")]
    Effects(Box<Report>),
    /// A template cannot be part of a term.
    #[error(
        "`{effect}` cannot be fitted: {why}; without `term …;` in its file `dynamics fit` leaves it alone"
    )]
    Unfit {
        /// Which.
        effect: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// The bodies do not form a tree.
    #[error("{0}")]
    Tree(String),
}

/// Fewest samples to learn from.
const FEWEST: usize = 200;
/// Between learning and judging, s.
const GUARD: f64 = 0.5;

/// Fits inertial parameters, friction, rotor inertia and couplings.
///
/// # Errors
/// If log and model cannot be used together.
pub fn fit(request: &Request<'_>) -> Result<Fit, FitError> {
    by_rates(request, |request| Ok(learn(request)?.0))
}

/// Works on a request; where bodies float by their twists, by the rates of their poses.
fn by_rates<T>(
    request: &Request<'_>,
    work: impl FnOnce(&Request<'_>) -> Result<T, FitError>,
) -> Result<T, FitError> {
    let (source, model) = (request.source, &request.compiled.model);
    let text = (source.name, source.text, source.library);
    let by_rates = ByRates::of(text, model, (request.train, request.test));
    let by_rates = by_rates.map_err(|Unrated { body, report }| FitError::Floats {
        body,
        report: Box::new(report),
    })?;
    let Some(by_rates) = by_rates else {
        return work(request);
    };
    work(&Request {
        source: Source {
            text: &by_rates.text,
            ..source
        },
        compiled: &by_rates.compiled,
        parameters: &by_rates.values(model, request.parameters),
        train: &by_rates.train,
        test: by_rates.test.as_ref(),
        ..request.clone()
    })
}

/// As [`fit`], with what it adds to the equation of motion.
fn learn(request: &Request<'_>) -> Result<(Fit, Correction), FitError> {
    let model = &request.compiled.model;
    if model.inputs.is_empty() {
        return Err(FitError::NoInput);
    }
    let (train, test) = split(request)?;
    let mut machine = Machine::new(request.compiled.clone());
    let columns = Columns::new(&mut machine, request.parameters, &request.source)?;
    let mut learnt = Equations::new(&machine, &columns, request.parameters, &train, None)?;
    let fastest = learnt.fastest.clone();
    let mut judged = Equations::new(&machine, &columns, request.parameters, &test, Some(&learnt))?;
    let left_out = left_out(request, &columns, &learnt)?;
    for equations in [&mut learnt, &mut judged] {
        let out: Vec<usize> = left_out.iter().map(|(i, _)| *i).collect();
        equations.leave_out(&out, &columns.groups);
    }
    let (chosen, learnt) = select::select(&columns, learnt, request.inertia != Inertia::Fixed);
    let (estimate, at_edge) = match request.inertia {
        Inertia::Consistent if chosen.inertias => consistent::refine(&columns, &learnt, &chosen),
        _ => {
            let kept = Signs::Kept;
            let found = estimate(&columns, &learnt, &chosen.groups, chosen.inertias, kept);
            (found, vec![false; columns.inertial])
        }
    };
    let names: Vec<String> = model.coordinates.iter().map(|c| c.name.clone()).collect();
    let [before, after, measured] = errors(&names, &judged, &estimate.values);
    let terms = terms(&columns, &chosen, &estimate, &fastest);
    let inertial = match chosen.inertias {
        true => inertial(&columns, &estimate, &at_edge),
        false => Vec::new(),
    };
    let correction = Correction {
        columns,
        values: estimate.values,
        fastest,
    };
    let seen = (&test, learnt.narrowing);
    let noise_floor = floor(&names, &machine, request.parameters, &correction, seen)?;
    let noise_floor = noise_floor.map(|floor| floor.without(&names, &judged.left_out));
    let mut warnings = said_of(&train, &test, request.test.is_some());
    warnings.extend(learnt.said_of_band());
    let worse = after.total > before.total;
    warnings.extend(worse_joints(&before, &after).filter(|_| !worse));
    if worse {
        warnings.push(rise(&before, &after, request.test.is_some()));
    }
    if request.inertia != Inertia::Fixed && !chosen.inertias {
        warnings.push(
            "corrected inertias do not predict what they were not fitted to: the model's were kept"
                .to_string(),
        );
    }
    let fit = Fit {
        before,
        after,
        measured,
        noise_floor,
        curves: curves(&names, &judged, &correction.values),
        inertia_evidence: chosen.inertia_nats,
        left_out: left_out.into_iter().map(|(_, told)| told).collect(),
        worse,
        terms,
        inertia: if chosen.inertias {
            request.inertia
        } else {
            Inertia::Fixed
        },
        inertial,
        base_parameters: correction
            .columns
            .structural_rank(&machine, request.parameters),
        determined: estimate.determined,
        samples: (train.len(), test.len()),
        warnings,
    };
    Ok((fit, correction))
}

/// The coordinates that nothing is learnt from, and why.
fn left_out(
    request: &Request<'_>,
    columns: &Columns,
    equations: &Equations,
) -> Result<Vec<(usize, LeftOut)>, FitError> {
    let coordinates = &request.compiled.model.coordinates;
    let mut reasons: BTreeMap<usize, Reason> = match request.trust_columns {
        true => BTreeMap::new(),
        false => no_forces(columns, equations).into_iter().collect(),
    };
    for name in request.leave_out {
        let Some(i) = coordinates.iter().position(|c| c.name == *name) else {
            let known: Vec<&str> = coordinates.iter().map(|c| &c.name[..]).collect();
            return Err(FitError::NoCoordinate {
                name: name.clone(),
                known: known.join(", "),
            });
        };
        reasons.insert(i, Reason::Stated);
    }
    let told = reasons.into_iter().map(|(i, reason)| {
        let coordinate = coordinates[i].name.clone();
        (i, LeftOut { coordinate, reason })
    });
    let told: Vec<(usize, LeftOut)> = told.collect();
    match told.len() < coordinates.len() {
        true => Ok(told),
        false => Err(FitError::NoForce {
            each: told
                .iter()
                .map(|(_, t)| t.to_string())
                .collect::<Vec<_>>()
                .join("; "),
        }),
    }
}

fn terms(
    columns: &Columns,
    chosen: &select::Chosen,
    estimate: &Estimate,
    fastest: &[f64],
) -> Vec<Term> {
    let each = chosen.groups.iter().zip(&chosen.gains);
    each.map(|(&group, gain)| {
        let group = &columns.groups[group];
        let values = values(group, estimate);
        Term {
            term: group.term.clone(),
            on: group.on.clone(),
            coefficients: group
                .coefficients
                .iter()
                .map(|coefficient| coefficient.name.clone())
                .zip(values)
                .collect(),
            stated: group
                .coefficients
                .iter()
                .filter(|coefficient| coefficient.stated != 0.0)
                .map(|coefficient| (coefficient.name.clone(), coefficient.stated))
                .collect(),
            gain: gain.share,
            evidence: gain.nats,
            may_be_body: may_be_body(columns, group, estimate),
            details: Details {
                coefficients: group.coefficients.clone(),
                shapes: Columns::shapes(group, fastest)
                    .map(|(shape, value)| (shape.effect.clone(), shape.parameter.clone(), value))
                    .collect(),
                is_load: group.load.is_some(),
            },
        }
    })
    .collect()
}

/// Within so many standard errors two places are one.
const ONE_PLACE: f64 = 3.0;

/// Whether a load is, as far as the log knows, in the body's own centre of mass.
fn may_be_body(columns: &Columns, group: &Group, estimate: &Estimate) -> bool {
    let Some((load, (point, std))) = group.load.as_ref().zip(estimate.point) else {
        return false;
    };
    let center = columns.centers[group.columns.start / point::TEN];
    let mut axes = point.at.iter().zip(center).zip(&std[1..]);
    load.carried.is_none() && axes.all(|((at, center), std)| (at - center).abs() < ONE_PLACE * std)
}

/// The coefficients of a group, with what the model states of them already.
fn values(group: &Group, estimate: &Estimate) -> Vec<Value> {
    if group.load.is_some() {
        let Some((point, std)) = &estimate.point else {
            return Vec::new();
        };
        let [x, y, z] = point.at;
        let values = [point.mass, x, y, z].into_iter().zip(std);
        return values.map(|(value, &std)| Value { value, std }).collect();
    }
    let columns = group.columns.clone().zip(&group.coefficients);
    let of = |(column, coefficient): (usize, &Coefficient)| Value {
        value: coefficient.stated + estimate.values[column],
        std: estimate.std[column],
    };
    columns.map(of).collect()
}

/// A joint's error on the data that is judged by has risen if it is larger by this share.
const RISEN: f64 = 0.02;

/// Joints that are predicted worse than before, though all together are predicted better.
fn worse_joints(before: &Error, after: &Error) -> Option<String> {
    let pairs = before.by_coordinate.iter();
    let pairs = pairs.map(|(name, &before)| (name, before, after.by_coordinate[name]));
    let risen = pairs.filter(|(_, before, after)| *after > (1.0 + RISEN) * before);
    let each = risen.map(|(name, before, after)| {
        format!("{name} (from {} to {})", short(before), short(after))
    });
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| {
        format!(
            "on the data that was judged by the error rises in {}: motion there differs from what was \
             learnt from",
            each.join(", ")
        )
    })
}

/// What a fit that makes the model worse is told about.
fn rise(before: &Error, after: &Error, has_test: bool) -> String {
    let (judged, more) = match has_test {
        true => (
            "the test log",
            "a training log that moves as the test log does",
        ),
        false => ("the part that was kept apart", "a longer log"),
    };
    let (from, to) = (short(before.total), short(after.total));
    let percent = short(100.0 * (after.total / before.total - 1.0));
    format!(
        "the fit makes the model worse: on {judged} the error rises from {from} to {to} (by {percent} %); \
         keep the model as it is, or give {more}"
    )
}

/// What to learn from and what to judge by.
fn split(request: &Request<'_>) -> Result<(Record, Record), FitError> {
    let model = &request.compiled.model;
    let coordinates: Vec<String> = model.coordinates.iter().map(|c| c.name.clone()).collect();
    let inputs: Vec<String> = model.inputs.iter().map(|u| u.name.clone()).collect();
    let gauges = Gauge::of(model);
    let select = |log: &Log| {
        let record = log.select_sensed(&coordinates, &inputs, &gauges)?;
        taken_as_measured(request, record)
    };
    let whole = select(request.train)?;
    let (train, test) = match request.test {
        Some(test) => (whole, select(test)?),
        None => {
            let begin = whole.len() - whole.len() / 3;
            let until = whole.t[begin] - GUARD;
            let guard = whole.t.partition_point(|&t| t < until);
            (whole.slice(0..guard), whole.slice(begin..whole.len()))
        }
    };
    let samples = train.len().min(test.len());
    if samples < FEWEST {
        let alone = request.test.is_some();
        return Err(FitError::TooShort {
            samples: if alone { samples } else { request.train.len() },
            needed: if alone { FEWEST } else { 3 * FEWEST },
        });
    }
    Ok((train, test))
}
