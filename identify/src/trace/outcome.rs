//! What tracing a log says.

use super::finding::{Finding, Verdict};
use super::microscope::Unnamed;
use super::score::Score;
use super::select::Remaining;
use super::series::Details;
use crate::regression::Hold;
use serde::Serialize;
use std::collections::BTreeMap;

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
