//! The parts of a GP² model: latent prior, noise, and the structure that maps
//! latent functions to measurements.

use crate::error::{GpError, Result, finite, shape};
use crate::functional::Functionals;
use crate::latent::LatentPrior;
use serde::{Deserialize, Serialize};

/// Prior of the latent functions and noise variance of every channel.
///
/// The measurement model is `y_r = H_r f(x) + m_r + e_r`, `e_r ~ N(0, σ_c²)`
/// with `c` the channel of row `r`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Prior of the latent forces or accelerations.
    pub prior: LatentPrior,
    /// `ln σ_c²` per channel.
    pub log_noise: Vec<f64>,
}

impl Model {
    /// A model with noise *variances* per channel. Errors: a variance that is
    /// not positive and finite.
    pub fn new(prior: LatentPrior, noise_variances: &[f64]) -> Result<Self> {
        for (c, &v) in noise_variances.iter().enumerate() {
            if !(v.is_finite() && v > 0.0) {
                return Err(GpError::Parameter {
                    name: format!("noise[{c}]"),
                    value: v,
                    expected: "a positive variance".into(),
                });
            }
        }
        Ok(Self {
            prior,
            log_noise: noise_variances.iter().map(|v| v.ln()).collect(),
        })
    }

    /// Parameters of the prior, then `ln σ_c²` of every channel.
    pub fn params(&self) -> Vec<f64> {
        let mut out = self.prior.params();
        out.extend(&self.log_noise);
        out
    }

    /// Number of parameters.
    pub fn n_params(&self) -> usize {
        self.prior.n_params() + self.log_noise.len()
    }

    /// Names in the order of [`Model::params`]; noise is `log_noise[c]`.
    pub fn param_names(&self) -> Vec<String> {
        let mut out = self.prior.param_names();
        out.extend((0..self.log_noise.len()).map(|c| format!("log_noise[{c}]")));
        out
    }

    /// Replace all parameters. Errors: wrong count, NaN or infinity.
    pub fn set_params(&mut self, values: &[f64]) -> Result<()> {
        if values.len() != self.n_params() {
            return Err(shape("model parameters", self.n_params(), values.len()));
        }
        finite("model parameters", values)?;
        let (prior, noise) = values.split_at(self.prior.n_params());
        self.prior.set_params(prior)?;
        self.log_noise.copy_from_slice(noise);
        Ok(())
    }

    /// Check this model against functionals it is to be used with.
    pub(crate) fn check(&self, f: &Functionals) -> Result<()> {
        if f.n_latent() != self.prior.n_latent() {
            return Err(shape(
                "latent functions of the functionals",
                format!("{} (those of the prior)", self.prior.n_latent()),
                f.n_latent(),
            ));
        }
        self.prior.check(f.dims())?;
        for (c, &v) in self.log_noise.iter().enumerate() {
            if !v.is_finite() || v.abs() > 300.0 {
                return Err(GpError::Parameter {
                    name: format!("log_noise[{c}]"),
                    value: v,
                    expected: "a finite logarithm within ±300".into(),
                });
            }
        }
        Ok(())
    }

    /// Noise variance of every row of `f`.
    pub(crate) fn noise_of(&self, f: &Functionals) -> Result<Vec<f64>> {
        f.check_channels(self.log_noise.len())?;
        Ok(f.channels()
            .iter()
            .map(|&c| self.log_noise[c].exp())
            .collect())
    }
}

/// Derivative of `H` and `m` in one model parameter, laid out like the functionals.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Tangent {
    /// `∂H/∂θ`, `R × n_latent` row-major.
    pub rows: Vec<f64>,
    /// `∂m/∂θ`, length `R`.
    pub mean: Vec<f64>,
}

/// What the measurements are functionals of, as a function of model parameters `θ`.
///
/// This is the only door through which physics enters the crate: it is
/// supplied from generated code, from a tape, or by hand.
pub trait Structure: Sync {
    /// Number of model parameters `p`.
    fn n_theta(&self) -> usize;

    /// Rows and means at `θ`.
    fn functionals(&self, theta: &[f64]) -> Result<Functionals>;

    /// Derivatives in every model parameter at `θ`, one [`Tangent`] each.
    fn tangents(&self, theta: &[f64]) -> Result<Vec<Tangent>>;
}

/// Nothing to learn in the structure: the functionals stand for themselves.
impl Structure for Functionals {
    fn n_theta(&self) -> usize {
        0
    }

    fn functionals(&self, _: &[f64]) -> Result<Functionals> {
        Ok(self.clone())
    }

    fn tangents(&self, _: &[f64]) -> Result<Vec<Tangent>> {
        Ok(Vec::new())
    }
}
