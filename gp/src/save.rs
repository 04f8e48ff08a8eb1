//! Saved models: one JSON file with format name, version and checksum.

use crate::data::Scaling;
use crate::envelope;
use crate::error::{GpError, Result, finite};
use crate::functional::Functionals;
use crate::model::Model;
use crate::posterior::Posterior;
use serde::{Deserialize, Serialize};

const FORMAT: &str = "gp2-model";

/// A trained model with all it needs to predict: round-trips bit for bit.
///
/// The training data are part of the file, so the posterior after loading is
/// the posterior before saving.
///
/// ```
/// # use gp::{Functionals, Inputs, Kernel, LatentPrior, Model};
/// # let x = Inputs::from_rows(&[[0.0], [1.0]])?;
/// # let data = Functionals::identity(&x, 1);
/// # let prior = LatentPrior::independent(vec![Kernel::squared_exponential(&[0.3], 1.0)]);
/// # let model = Model::new(prior, &[0.01])?;
/// let saved = gp::Saved::new(model, vec![], data, vec![0.1, 0.2]);
/// let text = saved.to_json()?;
/// assert_eq!(gp::Saved::from_json(&text)?, saved);
/// assert!(gp::Saved::from_json(&text[..text.len() / 2]).unwrap_err().to_string().contains("truncated"));
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    /// Prior and noise.
    pub model: Model,
    /// Model parameters `θ` the functionals were made with.
    pub theta: Vec<f64>,
    /// Functionals that were measured.
    pub data: Functionals,
    /// Measurements.
    pub y: Vec<f64>,
    /// How raw kernel inputs were scaled, when they were.
    pub inputs: Option<Scaling>,
    /// How raw measurements were scaled, when they were.
    pub outputs: Option<Scaling>,
}

impl Saved {
    /// Without scalings.
    pub fn new(model: Model, theta: Vec<f64>, data: Functionals, y: Vec<f64>) -> Self {
        Self {
            model,
            theta,
            data,
            y,
            inputs: None,
            outputs: None,
        }
    }

    /// Condition the model on the data.
    pub fn posterior(&self) -> Result<Posterior> {
        Posterior::new(&self.model, &self.data, &self.y)
    }

    /// As text. Errors: a number JSON cannot hold, inconsistent shapes.
    pub fn to_json(&self) -> Result<String> {
        self.validate()?;
        envelope::write(FORMAT, self)
    }

    /// From text. Errors name what is wrong: not JSON, truncated, another
    /// format, an older or newer version, missing or unknown fields, numbers
    /// that were changed, inconsistent shapes.
    pub fn from_json(text: &str) -> Result<Self> {
        envelope::read(FORMAT, text, Self::validate)
    }

    fn validate(&self) -> Result<()> {
        if self.y.len() != self.data.n_rows() {
            return Err(GpError::Saved(format!(
                "{} measurements for {} rows",
                self.y.len(),
                self.data.n_rows()
            )));
        }
        finite("measurements y", &self.y)?;
        finite("model parameters", &self.model.params())?;
        check_surroundings(&self.theta, [&self.inputs, &self.outputs])?;
        self.model.check(&self.data)?;
        self.data.check_channels(self.model.log_noise.len())
    }
}

/// What every saved model carries beside the posterior.
pub(crate) fn check_surroundings(theta: &[f64], scalings: [&Option<Scaling>; 2]) -> Result<()> {
    finite("theta", theta)?;
    scalings
        .into_iter()
        .flatten()
        .try_for_each(Scaling::validate)
}
