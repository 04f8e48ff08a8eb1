//! Saved sparse models: what predicts, without the data it was learnt from.

use crate::data::Scaling;
use crate::envelope;
use crate::error::{GpError, Result, finite, shape};
use crate::functional::Functionals;
use crate::inputs::Inputs;
use crate::linalg::Square;
use crate::model::Model;
use crate::save::check_surroundings;
use crate::sparse::{Solved, SparsePosterior};
use serde::{Deserialize, Serialize};

const FORMAT: &str = "gp2-sparse-model";

/// A sparse posterior as a file: prior, inducing inputs, two triangular factors and
/// the weights. Its size depends on the number of inducing inputs alone; no
/// measurement can be read from it directly. What is loaded predicts bit for bit as
/// what was saved.
///
/// ```
/// # use gp::{Functionals, Inputs, Kernel, LatentPrior, Model, SavedSparse, SparsePosterior};
/// # let x = Inputs::from_rows(&[[0.0], [0.5], [1.0]])?;
/// # let data = Functionals::identity(&x, 1);
/// # let prior = LatentPrior::independent(vec![Kernel::squared_exponential(&[0.3], 1.0)]);
/// # let model = Model::new(prior, &[0.01])?;
/// let inducing = Inputs::from_rows(&[[0.0], [1.0]])?;
/// let posterior = SparsePosterior::new(&model, &data, &[0.1, 0.3, 0.2], &inducing)?;
/// let text = SavedSparse::new(&posterior, vec![]).to_json()?;
/// let back = SavedSparse::from_json(&text)?.posterior()?;
/// assert_eq!(back.predict(&data)?, posterior.predict(&data)?);
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedSparse {
    model: Model,
    inducing: Inputs,
    /// Lower triangles, column by column.
    factor_u: Vec<f64>,
    factor_b: Vec<f64>,
    weights: Vec<f64>,
    bound: f64,
    jitter: f64,
    relative_jitter: f64,
    /// Model parameters `θ` the functionals were made with.
    pub theta: Vec<f64>,
    /// How raw kernel inputs were scaled, when they were.
    pub inputs: Option<Scaling>,
    /// How raw measurements were scaled, when they were.
    pub outputs: Option<Scaling>,
}

impl SavedSparse {
    /// Of a posterior, without scalings.
    pub fn new(posterior: &SparsePosterior, theta: Vec<f64>) -> Self {
        Self {
            model: posterior.model().clone(),
            inducing: posterior.inducing_inputs().clone(),
            factor_u: posterior.factor_u.lower(),
            factor_b: posterior.factor_b.lower(),
            weights: posterior.weights.clone(),
            bound: posterior.bound(),
            jitter: posterior.jitter(),
            relative_jitter: posterior.relative_jitter(),
            theta,
            inputs: None,
            outputs: None,
        }
    }

    /// The prior and the noise.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The posterior, as it was.
    pub fn posterior(&self) -> Result<SparsePosterior> {
        self.validate()?;
        let q = self.weights.len();
        let solved = Solved {
            factor_u: Square::from_lower(q, &self.factor_u),
            factor_b: Square::from_lower(q, &self.factor_b),
            weights: self.weights.clone(),
            bound: self.bound,
            jitter: self.jitter,
            relative: self.relative_jitter,
        };
        Ok(SparsePosterior::assembled(
            &self.model,
            &self.inducing,
            solved,
        ))
    }

    /// As text. Errors: inconsistent shapes, a number JSON cannot hold.
    pub fn to_json(&self) -> Result<String> {
        self.validate()?;
        envelope::write(FORMAT, self)
    }

    /// From text. Errors as [`crate::Saved::from_json`].
    pub fn from_json(text: &str) -> Result<Self> {
        envelope::read(FORMAT, text, Self::validate)
    }

    fn validate(&self) -> Result<()> {
        if self.inducing.is_empty() {
            return Err(GpError::Saved("there are no inducing inputs".into()));
        }
        let n = self.model.prior.n_latent();
        self.model
            .check(&Functionals::identity(&self.inducing, n))?;
        let q = self.inducing.len() * n;
        if self.weights.len() != q {
            return Err(shape("saved weights", q, self.weights.len()));
        }
        for (what, factor) in [("K_uu", &self.factor_u), ("B", &self.factor_b)] {
            let count = q * (q + 1) / 2;
            if factor.len() != count {
                return Err(shape(
                    format!("saved factor of {what}"),
                    count,
                    factor.len(),
                ));
            }
            finite(&format!("saved factor of {what}"), factor)?;
            let mut at = 0;
            for j in 0..q {
                if factor[at] <= 0.0 {
                    return Err(GpError::Saved(format!(
                        "the factor of {what} has {} on its diagonal, row {j}",
                        factor[at]
                    )));
                }
                at += q - j;
            }
        }
        finite("saved weights", &self.weights)?;
        finite(
            "saved bound and jitter",
            &[self.bound, self.jitter, self.relative_jitter],
        )?;
        check_surroundings(&self.theta, [&self.inputs, &self.outputs])
    }
}
