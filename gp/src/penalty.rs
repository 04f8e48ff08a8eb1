//! Priors on parameters, for maximum-a-posteriori training.

use serde::{Deserialize, Serialize};

/// Prior density of one parameter `z` as the optimiser sees it (a logarithm
/// for everything positive, natural scale for `θ` and coregionalisation weights).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Penalty {
    /// `z ~ N(mean, sd²)`: log-normal in the natural scale of a logarithmic parameter.
    Normal {
        /// Mean of `z`.
        mean: f64,
        /// Standard deviation of `z`.
        sd: f64,
    },
    /// `e^z ~ Gamma(shape, rate)`; the mode in `e^z` is `(shape - 1)/rate`.
    Gamma {
        /// Shape, dimensionless.
        shape: f64,
        /// Rate, one over the unit of `e^z`.
        rate: f64,
    },
    /// `e^z ~ |N(0, scale²)|`.
    HalfNormal {
        /// Scale, unit of `e^z`.
        scale: f64,
    },
}

impl Penalty {
    /// `-ln p` up to a constant, and its derivative in `z`.
    ///
    /// Densities of `e^z` are taken in `e^z`, so a MAP estimate does not
    /// depend on the logarithmic scale.
    pub fn value(&self, z: f64) -> (f64, f64) {
        match *self {
            Self::Normal { mean, sd } => {
                let t = (z - mean) / sd;
                (0.5 * t * t, t / sd)
            }
            Self::Gamma { shape, rate } => {
                let x = z.exp();
                (rate * x - (shape - 1.0) * z, rate * x - (shape - 1.0))
            }
            Self::HalfNormal { scale } => {
                let x = z.exp() / scale;
                (0.5 * x * x, x * x)
            }
        }
    }

    /// The parameters are positive and finite.
    pub(crate) fn is_valid(&self) -> bool {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        match *self {
            Self::Normal { mean, sd } => mean.is_finite() && positive(sd),
            Self::Gamma { shape, rate } => positive(shape) && positive(rate),
            Self::HalfNormal { scale } => positive(scale),
        }
    }
}
