//! What a training reports.

use crate::model::Model;
use crate::optimise::Reason;
use serde::{Deserialize, Serialize};

/// Report of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Run {
    /// Where it started.
    pub start: Vec<f64>,
    /// Objective it reached (negative log evidence plus penalties), nats;
    /// `None` when its start could not be evaluated.
    pub objective: Option<f64>,
    /// Iterations used.
    pub iterations: u64,
    /// Evaluations of evidence and gradient used.
    pub evaluations: u64,
    /// Why it ended.
    pub reason: Reason,
}

/// Result of a training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Fitted {
    /// The model with its trained parameters.
    pub model: Model,
    /// Estimated model parameters `θ`.
    pub theta: Vec<f64>,
    /// Negative log evidence (or its bound through inducing inputs), nats, without penalties.
    pub nll: f64,
    /// Negative log evidence plus penalties, nats.
    pub objective: f64,
    /// Jitter in the final evaluation; 0 as a rule.
    pub jitter: f64,
    /// Pairs of data points with the same input, when the exact covariance needed jitter;
    /// empty otherwise.
    pub coincident: Vec<(usize, usize)>,
    /// Names of parameters that ended on a bound.
    pub at_bounds: Vec<String>,
    /// Number of the best run.
    pub best_run: usize,
    /// Every run, in order.
    pub runs: Vec<Run>,
    /// The seed all random choices came from.
    pub seed: u64,
}
