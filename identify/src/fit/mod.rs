//! Parameters of a machine whose forces were measured: linear regression of the inverse
//! dynamics.
//!
//! ```text
//! Q_D + B u − (M a − Q_C) = Y(q, v, a) δφ + F(q, v, a) ψ + noise
//! ```
//!
//! `δφ` are corrections to the bodies' standard inertial parameters, drawn to the model's
//! own values by a prior; `ψ` are friction, rotor inertia, offset and couplings, each
//! taken in only if it predicts blocks of the log that it was not fitted to. Under
//! constraints the equations are projected onto the directions that no multiplier
//! reaches, the null space of `A`. Errors are reported on a part of the log that nothing was fitted to.

mod columns;
mod compare;
mod consistent;
mod correction;
mod equations;
mod estimate;
mod frame;
mod inertial;
mod page;
mod select;
mod signs;

pub use compare::{
    Base, Comparison, ConstraintError, Kind, Process, Row, Settings, compare,
    page as comparison_page,
};
pub use inertial::{Doubt, InertialParameter};
pub use page::page;

use crate::log::{Log, LogError, Record, said_of};
use crate::machine::{Machine, SolveError};
use crate::number::short;
use crate::smooth::SmoothError;
use columns::Columns;
use correction::Correction;
use dynamics_codegen::Compiled;
use equations::Equations;
use estimate::{Estimate, Signs, estimate};
use inertial::inertial;
use serde::Serialize;
use std::collections::BTreeMap;

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
    /// The model.
    pub compiled: &'a Compiled,
    /// Its parameters' values.
    pub parameters: &'a [f64],
    /// The log to learn from.
    pub train: &'a Log,
    /// A log to judge by; without one, the last third of `train` is kept apart.
    pub test: Option<&'a Log>,
    /// How inertial parameters are treated.
    pub inertia: Inertia,
}

/// Root mean squares of what the model leaves of the measured forces, per coordinate and
/// over all, in the unit of the force on that coordinate, within the band in which the
/// log shows accelerations at all.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Error {
    /// By coordinate.
    pub by_coordinate: BTreeMap<String, f64>,
    /// Root mean square over all coordinates.
    pub total: f64,
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
pub struct Term {
    /// `friction`, `armature`, `constant_force` or `joint_coupling`.
    pub term: String,
    /// The coordinates that it acts on.
    pub on: Vec<String>,
    /// Its coefficients by name.
    pub coefficients: BTreeMap<String, Value>,
    /// By how much it lowers the mean squared error of blocks it was not fitted to, as a
    /// share of what was left before it.
    pub gain: f64,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Fit {
    /// Error of the model as given, on data that nothing was fitted to.
    pub before: Error,
    /// The same with the new terms and the corrected inertias.
    pub after: Error,
    /// Whether that is larger: what follows fits the log it was learnt from and nothing else.
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
}

/// Why a log could not be fitted.
#[derive(Debug, thiserror::Error)]
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
    /// Nothing measured.
    #[error(
        "the model has no input: without measured forces only ratios of parameters show; \
         use `dynamics trace`, or `dynamics fit --compare` to let Gaussian processes learn what \
         the model leaves"
    )]
    NoInput,
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
    Ok(learn(request)?.0)
}

/// As [`fit`], with what it adds to the equation of motion.
fn learn(request: &Request<'_>) -> Result<(Fit, Correction), FitError> {
    let model = &request.compiled.model;
    if model.inputs.is_empty() {
        return Err(FitError::NoInput);
    }
    let (train, test) = split(request)?;
    let mut machine = Machine::new(request.compiled.clone());
    let columns = Columns::new(&mut machine, request.parameters, request.inertia)?;
    let learnt = Equations::new(&machine, &columns, request.parameters, &train, None)?;
    let fastest = learnt.fastest.clone();
    let judged = Equations::new(
        &machine,
        &columns,
        request.parameters,
        &test,
        Some(&fastest),
    )?;
    let (chosen, learnt) = select::select(&columns, learnt);
    let (estimate, at_edge) = match request.inertia {
        Inertia::Consistent if chosen.inertias => consistent::refine(&columns, &learnt, &chosen),
        _ => {
            let kept = Signs::Kept;
            let found = estimate(&columns, &learnt, &chosen.groups, chosen.inertias, kept);
            (found, vec![false; columns.inertial])
        }
    };
    let names: Vec<String> = model.coordinates.iter().map(|c| c.name.clone()).collect();
    let error = |x: &[f64]| error(&names, &judged.rms(x));
    let nothing = vec![0.0; columns.count()];
    let (before, after) = (error(&nothing), error(&estimate.values));
    let mut warnings = said_of(&train, &test, request.test.is_some());
    let worse = after.total > before.total;
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
        worse,
        terms: terms(&columns, &chosen, &estimate),
        inertia: if chosen.inertias {
            request.inertia
        } else {
            Inertia::Fixed
        },
        inertial: if chosen.inertias {
            inertial(&columns, &estimate, &at_edge)
        } else {
            Vec::new()
        },
        base_parameters: columns.structural_rank(&machine, request.parameters),
        determined: estimate.determined,
        samples: (train.len(), test.len()),
        warnings,
    };
    let correction = Correction {
        columns,
        values: estimate.values,
        fastest,
    };
    Ok((fit, correction))
}

fn error(names: &[String], rms: &[f64]) -> Error {
    let squares: f64 = rms.iter().map(|x| x * x).sum();
    Error {
        by_coordinate: names.iter().cloned().zip(rms.iter().copied()).collect(),
        total: (squares / rms.len() as f64).sqrt(),
    }
}

fn terms(columns: &Columns, chosen: &select::Chosen, estimate: &Estimate) -> Vec<Term> {
    let of = |&(group, gain): &(usize, f64)| {
        let group = &columns.groups[group];
        let values = group.columns.clone().zip(&group.names);
        let coefficients = values.map(|(column, name)| {
            let value = Value {
                value: estimate.values[column],
                std: estimate.std[column],
            };
            (name.to_string(), value)
        });
        Term {
            term: group.term.to_string(),
            on: group.on.clone(),
            coefficients: coefficients.collect(),
            gain,
        }
    };
    chosen
        .groups
        .iter()
        .zip(&chosen.gains)
        .map(|(&g, &gain)| of(&(g, gain)))
        .collect()
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
    let whole = request.train.select(&coordinates, &inputs)?;
    let (train, test) = match request.test {
        Some(test) => (whole, test.select(&coordinates, &inputs)?),
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
