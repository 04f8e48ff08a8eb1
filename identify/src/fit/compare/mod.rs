//! Semi-parametric models (thesis chapter 4), compared on data that none of them has seen.
//!
//! With the analytic model `a = L b + P Q` (with `P` as of [3.42]) and Gaussian processes
//! `g`, `f`, `ε_u` of `x = (q, v, u)`, one independent squared-exponential kernel per output:
//!
//! | model | prediction | source |
//! |---|---|---|
//! | analytic | `a` | 4.8 |
//! | output residual | `a + g(x)` | 4.28 |
//! | latent force (GP²) | `a + P f(x)` | 5.6 |
//! | contact-invariant | `a + P J_u ε_u(x)` | 4.37 |
//!
//! The output residual knows nothing of constraints; the other two cannot leave them, since
//! `A P = 0`. Each is learnt on the model as given and on the model with what
//! [`fit`](super::fit) finds.

mod along;
mod learner;
mod page;
mod process;

pub use page::page;

use super::{Correction, Fit, FitError, Request, by_rates, learn, split};
use crate::machine::{Machine, SolveError};
use crate::trace::Errors;
use along::{Along, Predicted};
use learner::{Learner, Taught};
use serde::Serialize;
use std::collections::BTreeMap;

/// How to compare.
#[derive(Debug, Clone, Copy, Default)]
pub struct Settings {
    /// Points that the processes learn from; without a number, as many as keep the joint
    /// covariance of GP² at about 1200 rows (100 to 400).
    pub points: Option<usize>,
    /// Seed of the first point and of the optimiser's starts.
    pub seed: u64,
    /// Tells seconds since some moment, if training is to be timed.
    pub clock: Option<fn() -> f64>,
}

/// Which semi-parametric model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The equations of motion alone.
    Analytic,
    /// A process per coordinate on the acceleration that they leave [4.28].
    OutputResidual,
    /// A process per generalised force, pushed through the constrained dynamics [5.6].
    LatentForce,
    /// A process per direction that no multiplier reaches [4.37].
    ContactInvariant,
}

/// What the processes are added to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Base {
    /// The model as given.
    Given,
    /// The model with the terms and inertias that [`fit`](super::fit) finds.
    Fitted,
}

/// By how much predicted accelerations miss `A a = b`, in the constraints' own units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ConstraintError {
    /// Root mean square of `‖A a − b‖` over samples.
    pub rms: f64,
    /// The largest `‖A a − b‖`.
    pub max: f64,
}

/// A trained Gaussian process.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Process {
    /// What it stands for: a coordinate, or a direction.
    pub of: String,
    /// Whether its evidence beats that of white noise; if not, it predicts nothing.
    pub learnt: bool,
    /// Standard deviation of its prior: m/s² or rad/s², N or N·m.
    pub signal_sd: f64,
    /// Length-scale per variable, in units of that variable's standard deviation: the
    /// shorter, the more it matters.
    pub length_scales: BTreeMap<String, f64>,
}

/// One model's figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Row {
    /// Which model.
    pub model: Kind,
    /// What it is added to.
    pub base: Base,
    /// Error of the predicted acceleration on data that nothing was fitted to, as
    /// [`Score::acceleration`](crate::trace::Score::acceleration).
    pub acceleration: Errors,
    /// By how much predictions miss the constraints; `None` if there are none.
    pub constraint: Option<ConstraintError>,
    /// How long training took by the clock of [`Settings`], s; `None` without one, and where
    /// nothing is trained.
    pub training_seconds: Option<f64>,
    /// By how many nats the processes explain the points better than white noise does, less
    /// the price of their hyper-parameters; 0 where there is nothing to learn, `None`
    /// without processes.
    pub evidence: Option<f64>,
    /// The processes' hyper-parameters.
    pub processes: Vec<Process>,
    /// Standard deviation of what is left as noise, per output, in its unit.
    pub noise: BTreeMap<String, f64>,
}

/// The table.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Comparison {
    /// The models.
    pub rows: Vec<Row>,
    /// Points that processes learnt from, spread by farthest point sampling.
    pub points: usize,
    /// Samples that the points were taken from.
    pub candidates: usize,
    /// Samples that were judged by.
    pub judged: usize,
    /// How learning and judging were kept apart.
    pub split: String,
    /// Where the measured accelerations come from.
    pub measured: String,
    /// Variables of the processes: what moves of `q`, `v`, `u`.
    pub variables: Vec<String>,
    /// The seed.
    pub seed: u64,
    /// What should be known.
    pub notes: Vec<String>,
}

/// Compares semi-parametric models, after [`fit`](super::fit) where that is possible: a
/// machine without inputs has nothing to fit, and yet something to learn.
///
/// # Errors
/// If log and model cannot be used together.
pub fn compare(
    request: &Request<'_>,
    settings: &Settings,
) -> Result<(Option<Fit>, Comparison), FitError> {
    by_rates(request, |request| compared(request, settings))
}

/// The comparison with a model whose positions each have a velocity of their own.
fn compared(
    request: &Request<'_>,
    settings: &Settings,
) -> Result<(Option<Fit>, Comparison), FitError> {
    let mut notes = Vec::new();
    let (fit, correction) = match learn(request) {
        Ok((fit, correction)) => (Some(fit), Some(correction)),
        Err(error @ (FitError::NoInput | FitError::Tree(_))) => {
            let why = match error {
                FitError::Tree(why) => why,
                _ => "the model has no input, so that no force is measured".to_string(),
            };
            notes.push(format!("nothing fitted: {why}"));
            (None, None)
        }
        Err(error) => return Err(error),
    };
    let (train, test) = split(request)?;
    let machine = Machine::new(request.compiled.clone());
    let parameters = request.parameters;
    let train = Along::new(&machine, train, parameters)?;
    let test = Along::new(&machine, test, parameters)?;
    let learner = Learner::new(&machine, &train, &test, settings)?;
    let mut table = Comparison {
        rows: Vec::new(),
        points: learner.points.len(),
        candidates: train.inner.len(),
        judged: test.inner.len(),
        split: split_in_words(request),
        measured: train.measured(),
        variables: learner.variables.clone(),
        seed: settings.seed,
        notes,
    };
    let mut bases = vec![(Base::Given, None)];
    match correction.filter(|c| !c.is_empty()) {
        Some(correction) => bases.push((Base::Fitted, Some(correction))),
        None if fit.is_some() => table
            .notes
            .push("fit finds nothing to add: the model as given is the fitted one".to_string()),
        None => (),
    }
    let mut failed = None;
    for (base, correction) in &bases {
        match rows(
            &machine,
            parameters,
            correction.as_ref(),
            *base,
            &learner,
            &test,
        ) {
            Ok((rows, notes)) => {
                table.rows.extend(rows);
                table.notes.extend(notes);
            }
            Err(error) => {
                table.notes.push(unsolved(*base, &error));
                failed = Some(error);
            }
        }
    }
    match failed {
        // What was fitted to forces stands, whether or not accelerations follow from it.
        Some(error) if table.rows.is_empty() && fit.is_none() => return Err(error.into()),
        _ => (),
    }
    Ok((fit, table))
}

/// Inverse dynamics, which are fitted, exist where accelerations do not.
fn unsolved(base: Base, error: &SolveError) -> String {
    match base {
        Base::Given => format!("the model as given has no accelerations: {error}"),
        // Free inertias need not be those of a body.
        Base::Fitted => {
            format!("the fitted model has no accelerations ({error}); try --inertia consistent")
        }
    }
}

/// All models on one base.
fn rows(
    machine: &Machine,
    parameters: &[f64],
    correction: Option<&Correction>,
    base: Base,
    learner: &Learner<'_>,
    test: &Along,
) -> Result<(Vec<Row>, Vec<String>), SolveError> {
    let known = Predicted::new(machine, learner.train, parameters, correction)?;
    let asked = Predicted::new(machine, test, parameters, correction)?;
    let nothing = vec![vec![0.0; test.len()]; machine.coordinate_count()];
    let row = |model, added: &[Vec<f64>]| Row {
        model,
        base,
        acceleration: test.errors(&asked, added),
        constraint: asked.constraint_error(&test.inner, added),
        training_seconds: None,
        evidence: None,
        processes: Vec::new(),
        noise: BTreeMap::new(),
    };
    let (mut rows, mut notes) = (vec![row(Kind::Analytic, &nothing)], Vec::new());
    for model in [
        Kind::OutputResidual,
        Kind::LatentForce,
        Kind::ContactInvariant,
    ] {
        let begin = learner.clock.map(|clock| clock());
        let taught = match model {
            Kind::OutputResidual => learner.output_residual(&known),
            Kind::LatentForce => learner.latent_force(&known),
            _ => learner.contact_invariant(&known),
        };
        let seconds = learner
            .clock
            .zip(begin)
            .map(|(clock, begin)| clock() - begin);
        match taught.and_then(|taught| Ok((taught.added(&asked)?, taught))) {
            Ok((
                added,
                Taught {
                    processes,
                    noise,
                    gain,
                    ..
                },
            )) => rows.push(Row {
                training_seconds: seconds,
                evidence: Some(gain),
                processes,
                noise,
                ..row(model, &added)
            }),
            Err(error) => notes.push(format!("{model:?} could not be trained: {error}")),
        }
    }
    Ok((rows, notes))
}

fn split_in_words(request: &Request<'_>) -> String {
    let train = request.train.name();
    match request.test {
        Some(test) => format!("learnt from {train}, judged by {}", test.name()),
        None => format!(
            "learnt from the first two thirds of {train}, judged by its last third, {} s apart",
            super::GUARD
        ),
    }
}
