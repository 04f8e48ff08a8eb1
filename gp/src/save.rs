//! Saved models: one JSON file with format name, version and checksum.

use crate::data::Scaling;
use crate::error::{GpError, Result, finite};
use crate::functional::Functionals;
use crate::model::Model;
use crate::posterior::Posterior;
use serde::{Deserialize, Serialize};
use serde_json::Value;

const FORMAT: &str = "gp2-model";

/// Version of the files this build writes, and the only one it reads.
pub const VERSION: u64 = 1;

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

#[derive(Serialize)]
struct FileRef<'a> {
    format: &'a str,
    version: u64,
    checksum: String,
    body: &'a Saved,
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
        let file = FileRef {
            format: FORMAT,
            version: VERSION,
            checksum: self.checksum()?,
            body: self,
        };
        serde_json::to_string(&file).map_err(|e| GpError::Saved(format!("cannot be written: {e}")))
    }

    /// From text. Errors name what is wrong: not JSON, truncated, another
    /// format, an older or newer version, missing or unknown fields, numbers
    /// that were changed, inconsistent shapes.
    pub fn from_json(text: &str) -> Result<Self> {
        let value: Value = serde_json::from_str(text).map_err(|e| {
            GpError::Saved(if e.is_eof() {
                format!("the file is truncated: it ends at line {}, column {}; copy it again or retrain", e.line(), e.column())
            } else {
                format!("not a JSON file: {e}")
            })
        })?;
        if value.get("format").and_then(Value::as_str) != Some(FORMAT) {
            return Err(GpError::Saved(format!(
                "expected \"format\": \"{FORMAT}\"; this is some other JSON file"
            )));
        }
        match value.get("version").and_then(Value::as_u64) {
            Some(VERSION) => {}
            Some(v) if v < VERSION => {
                return Err(GpError::Saved(format!(
                    "version {v} is older than {VERSION}, the one this build reads; retrain, or convert it with the build that wrote it"
                )));
            }
            Some(v) => {
                return Err(GpError::Saved(format!(
                    "version {v} is newer than {VERSION}, the one this build reads; update the program"
                )));
            }
            None => {
                return Err(GpError::Saved(
                    "the field \"version\" is missing or not a number".into(),
                ));
            }
        }
        let body = value
            .get("body")
            .ok_or_else(|| GpError::Saved("the field \"body\" is missing".into()))?;
        let saved = Self::deserialize(body).map_err(|e| GpError::Saved(format!("body: {e}")))?;
        saved.validate()?;
        let (found, stated) = (
            saved.checksum()?,
            value.get("checksum").and_then(Value::as_str),
        );
        if stated != Some(found.as_str()) {
            return Err(GpError::Saved(format!(
                "checksum {found} does not match the stated {}; the body was changed",
                stated.unwrap_or("(none)")
            )));
        }
        Ok(saved)
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
        finite("theta", &self.theta)?;
        finite("model parameters", &self.model.params())?;
        for scaling in self.inputs.iter().chain(&self.outputs) {
            scaling.validate()?;
        }
        self.model.check(&self.data)?;
        self.data.check_channels(self.model.log_noise.len())
    }

    /// FNV-1a over the canonical text of the body.
    fn checksum(&self) -> Result<String> {
        let text = serde_json::to_string(self)
            .map_err(|e| GpError::Saved(format!("cannot be written: {e}")))?;
        let mut hash = 0xcbf2_9ce4_8422_2325u64;
        for byte in text.bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        Ok(format!("{hash:016x}"))
    }
}
