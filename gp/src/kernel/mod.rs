//! Scalar covariance functions as an algebra.
//!
//! Leaves (squared-exponential, Matérn, linear, bias, periodic, white) combine
//! by sum, product, scaling and restriction to some inputs. Positive
//! parameters are held as natural logarithms, and every gradient is exact and
//! with respect to those logarithms.

mod algebra;
mod bound;
mod forms;

pub(crate) use bound::Bound;

use crate::error::{GpError, Result, finite, shape};
use crate::inputs::Inputs;
use crate::simd::TILE;
use faer::Mat;
use serde::{Deserialize, Serialize};

/// One length-scale per input dimension and a variance, as logarithms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ard {
    /// `ln l_d`, one per input dimension, in the unit of that input.
    pub log_lengths: Vec<f64>,
    /// `ln σ²`, in the squared unit of the output.
    pub log_variance: f64,
}

/// Period and length-scale per input dimension and a variance, as logarithms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cyclic {
    /// `ln p_d`, period in the unit of that input.
    pub log_periods: Vec<f64>,
    /// `ln l_d`, dimensionless.
    pub log_lengths: Vec<f64>,
    /// `ln σ²`.
    pub log_variance: f64,
}

/// A scalar covariance function `k(x, x')`.
///
/// `x` and `x'` have length `D`, the number of input dimensions; with
/// `r² = Σ_d ((x_d - x'_d)/l_d)²`. Equation and section numbers are those of Rasmussen and
/// Williams (2006), "RW".
///
/// ```
/// use gp::Kernel;
/// let k = Kernel::squared_exponential(&[1.0, 2.0], 0.5)
///     + Kernel::bias(0.1) * Kernel::periodic(&[6.0], &[1.0], 1.0).on(&[1]);
/// assert!((k.value(&[0.0, 0.0], &[0.0, 6.0])? - (0.5 * (-4.5f64).exp() + 0.1)).abs() < 1e-12);
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Kernel {
    /// `σ² exp(-r²/2)` (RW 4.9, with one length-scale per dimension as in RW 5.1).
    /// Parameters: `ln l_1 … ln l_D, ln σ²`.
    SquaredExponential(Ard),
    /// `σ² (1 + √3 r) exp(-√3 r)` (RW 4.17). Parameters as above.
    Matern32(Ard),
    /// `σ² (1 + √5 r + 5 r²/3) exp(-√5 r)` (RW 4.17). Parameters as above.
    Matern52(Ard),
    /// `Σ_d v_d x_d x'_d` (RW 4.2.2). Parameters: `ln v_1 … ln v_D`.
    Linear {
        /// `ln v_d`, one per input dimension.
        log_variances: Vec<f64>,
    },
    /// The constant `σ²` (RW table 4.1). Parameter: `ln σ²`.
    Bias {
        /// `ln σ²`.
        log_variance: f64,
    },
    /// `σ² exp(-2 Σ_d sin²(π (x_d - x'_d)/p_d) / l_d²)` (MacKay 1998; RW 4.31).
    /// Parameters: `ln p_1 … ln p_D, ln l_1 … ln l_D, ln σ²`.
    Periodic(Cyclic),
    /// `σ²` when all coordinates of `x` and `x'` are equal, else 0 (RW 2.20). Parameter: `ln σ²`.
    White {
        /// `ln σ²`.
        log_variance: f64,
    },
    /// `Σ_i k_i` (RW 4.2.4). Parameters of the parts in order.
    Sum(Vec<Kernel>),
    /// `Π_i k_i` (RW 4.2.4). Parameters of the parts in order.
    Product(Vec<Kernel>),
    /// `c k`. Parameters: `ln c`, then those of the inner kernel.
    Scaled {
        /// `ln c`.
        log_factor: f64,
        /// The kernel that is scaled.
        inner: Box<Kernel>,
    },
    /// `k` acting on some inputs only (RW 4.2.4), in the order listed. Parameters of the inner kernel.
    On {
        /// Input dimensions the inner kernel sees.
        dims: Vec<usize>,
        /// The kernel that is restricted.
        inner: Box<Kernel>,
    },
}

fn logs(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| v.ln()).collect()
}

fn ard(lengths: &[f64], variance: f64) -> Ard {
    Ard {
        log_lengths: logs(lengths),
        log_variance: variance.ln(),
    }
}

impl Kernel {
    /// `σ² exp(-½ Σ_d ((x_d - x'_d)/l_d)²)` with lengths `l` and variance `σ²`.
    ///
    /// A value that is not positive is reported when the kernel is used.
    pub fn squared_exponential(lengths: &[f64], variance: f64) -> Self {
        Self::SquaredExponential(ard(lengths, variance))
    }

    /// Matérn kernel with smoothness 3/2: samples are differentiable once.
    pub fn matern32(lengths: &[f64], variance: f64) -> Self {
        Self::Matern32(ard(lengths, variance))
    }

    /// Matérn kernel with smoothness 5/2: samples are differentiable twice.
    pub fn matern52(lengths: &[f64], variance: f64) -> Self {
        Self::Matern52(ard(lengths, variance))
    }

    /// `Σ_d v_d x_d x'_d` with variances `v`.
    pub fn linear(variances: &[f64]) -> Self {
        Self::Linear {
            log_variances: logs(variances),
        }
    }

    /// The constant `variance`.
    pub fn bias(variance: f64) -> Self {
        Self::Bias {
            log_variance: variance.ln(),
        }
    }

    /// Periodic kernel with one period and one length-scale per input.
    pub fn periodic(periods: &[f64], lengths: &[f64], variance: f64) -> Self {
        Self::Periodic(Cyclic {
            log_periods: logs(periods),
            log_lengths: logs(lengths),
            log_variance: variance.ln(),
        })
    }

    /// `variance` at equal inputs, 0 elsewhere.
    pub fn white(variance: f64) -> Self {
        Self::White {
            log_variance: variance.ln(),
        }
    }

    /// `factor · self`, with `ln factor` as a parameter.
    pub fn scaled(self, factor: f64) -> Self {
        Self::Scaled {
            log_factor: factor.ln(),
            inner: Box::new(self),
        }
    }

    /// `self` acting only on the inputs `dims`.
    pub fn on(self, dims: &[usize]) -> Self {
        Self::On {
            dims: dims.to_vec(),
            inner: Box::new(self),
        }
    }

    /// Number of parameters.
    pub fn n_params(&self) -> usize {
        let mut n = 0;
        self.visit("", &mut |_, _| n += 1);
        n
    }

    /// All parameters in their documented order.
    pub fn params(&self) -> Vec<f64> {
        let mut out = Vec::new();
        self.visit("", &mut |_, v| out.push(v));
        out
    }

    /// Name of each parameter, for example `sum[0].log_length[2]`.
    pub fn param_names(&self) -> Vec<String> {
        let mut out = Vec::new();
        self.visit("", &mut |n, _| out.push(n));
        out
    }

    /// Replace all parameters. Errors: wrong count, NaN or infinity.
    pub fn set_params(&mut self, values: &[f64]) -> Result<()> {
        if values.len() != self.n_params() {
            return Err(shape("kernel parameters", self.n_params(), values.len()));
        }
        finite("kernel parameters", values)?;
        let mut next = values.iter();
        self.visit_mut(&mut |v| {
            if let Some(&x) = next.next() {
                *v = x;
            }
        });
        Ok(())
    }

    fn visit(&self, prefix: &str, f: &mut dyn FnMut(String, f64)) {
        let mut list = |name: &str, values: &[f64]| {
            for (i, &v) in values.iter().enumerate() {
                f(format!("{prefix}{name}[{i}]"), v);
            }
        };
        match self {
            Self::SquaredExponential(a) | Self::Matern32(a) | Self::Matern52(a) => {
                list("log_length", &a.log_lengths);
                f(format!("{prefix}log_variance"), a.log_variance);
            }
            Self::Linear { log_variances } => list("log_variance", log_variances),
            Self::Bias { log_variance } | Self::White { log_variance } => {
                f(format!("{prefix}log_variance"), *log_variance);
            }
            Self::Periodic(c) => {
                list("log_period", &c.log_periods);
                list("log_length", &c.log_lengths);
                f(format!("{prefix}log_variance"), c.log_variance);
            }
            Self::Sum(parts) | Self::Product(parts) => {
                let kind = if matches!(self, Self::Sum(_)) {
                    "sum"
                } else {
                    "product"
                };
                for (i, part) in parts.iter().enumerate() {
                    part.visit(&format!("{prefix}{kind}[{i}]."), f);
                }
            }
            Self::Scaled { log_factor, inner } => {
                f(format!("{prefix}log_factor"), *log_factor);
                inner.visit(prefix, f);
            }
            Self::On { inner, .. } => inner.visit(prefix, f),
        }
    }

    fn visit_mut(&mut self, f: &mut dyn FnMut(&mut f64)) {
        match self {
            Self::SquaredExponential(a) | Self::Matern32(a) | Self::Matern52(a) => {
                a.log_lengths.iter_mut().for_each(&mut *f);
                f(&mut a.log_variance);
            }
            Self::Linear { log_variances } => log_variances.iter_mut().for_each(f),
            Self::Bias { log_variance } | Self::White { log_variance } => f(log_variance),
            Self::Periodic(c) => {
                c.log_periods.iter_mut().for_each(&mut *f);
                c.log_lengths.iter_mut().for_each(&mut *f);
                f(&mut c.log_variance);
            }
            Self::Sum(parts) | Self::Product(parts) => {
                parts.iter_mut().for_each(|p| p.visit_mut(f));
            }
            Self::Scaled { log_factor, inner } => {
                f(log_factor);
                inner.visit_mut(f);
            }
            Self::On { inner, .. } => inner.visit_mut(f),
        }
    }

    /// Check dimensions and parameters against inputs of `dims` coordinates.
    pub(crate) fn check(&self, dims: usize) -> Result<()> {
        let usable = |v: &f64| v.is_finite() && v.abs() <= 300.0;
        if let Some(at) = self.params().iter().position(|v| !usable(v)) {
            return Err(GpError::Parameter {
                name: self.param_names().swap_remove(at),
                value: self.params()[at],
                expected: "a finite logarithm within ±300 (the value itself positive)".into(),
            });
        }
        self.check_dims(dims)
    }

    fn check_dims(&self, dims: usize) -> Result<()> {
        let same = |what: &str, found: usize| {
            if found == dims {
                Ok(())
            } else {
                Err(shape(what, format!("{dims} (input dimensions)"), found))
            }
        };
        match self {
            Self::SquaredExponential(a) | Self::Matern32(a) | Self::Matern52(a) => {
                same("length-scales", a.log_lengths.len())
            }
            Self::Linear { log_variances } => same("linear variances", log_variances.len()),
            Self::Bias { .. } | Self::White { .. } => Ok(()),
            Self::Periodic(c) => {
                same("periods", c.log_periods.len())?;
                same("periodic length-scales", c.log_lengths.len())
            }
            Self::Sum(parts) | Self::Product(parts) => {
                if parts.is_empty() {
                    return Err(shape(
                        "parts of a sum or product of kernels",
                        "at least 1",
                        0,
                    ));
                }
                parts.iter().try_for_each(|p| p.check_dims(dims))
            }
            Self::Scaled { inner, .. } => inner.check_dims(dims),
            Self::On { dims: seen, inner } => {
                if let Some(d) = seen.iter().find(|&&d| d >= dims) {
                    return Err(shape(
                        "kernel restriction",
                        format!("input dimensions below {dims}"),
                        d,
                    ));
                }
                inner.check_dims(seen.len())
            }
        }
    }

    /// `k(x, z)` for two points.
    pub fn value(&self, x: &[f64], z: &[f64]) -> Result<f64> {
        let (a, b) = (Inputs::from_rows(&[x])?, Inputs::from_rows(&[z])?);
        Ok(self.gram(&a, &b)?[(0, 0)])
    }

    /// Gram matrix `K[i, j] = k(x_i, z_j)`, `x.len() × z.len()`. Errors: shapes, parameters
    /// that are not usable, entries that overflow.
    pub fn gram(&self, x: &Inputs, z: &Inputs) -> Result<Mat<f64>> {
        self.check_pair(x, z)?;
        let bound = Bound::new(self, x, z);
        let mut out = Mat::zeros(x.len(), z.len());
        let mut tile = [0.0; TILE];
        for j in 0..z.len() {
            for start in (0..x.len()).step_by(TILE) {
                let len = TILE.min(x.len() - start);
                bound.values(j, start, &mut tile[..len]);
                for (i, v) in tile[..len].iter().enumerate() {
                    out[(start + i, j)] = *v;
                }
                finite("column of the Gram matrix", &tile[..len])?;
            }
        }
        Ok(out)
    }

    /// `Σ_ij W[i, j] ∂k(x_i, z_j)/∂η` for every parameter `η`, in the order of
    /// [`Kernel::params`]; `W` is `x.len() × z.len()`.
    pub fn gradient(&self, x: &Inputs, z: &Inputs, weights: &Mat<f64>) -> Result<Vec<f64>> {
        self.check_pair(x, z)?;
        if weights.nrows() != x.len() || weights.ncols() != z.len() {
            return Err(shape(
                "gradient weights",
                format!("{} × {}", x.len(), z.len()),
                format!("{} × {}", weights.nrows(), weights.ncols()),
            ));
        }
        let bound = Bound::new(self, x, z);
        let mut grad = vec![0.0; self.n_params()];
        let mut tile = [0.0; TILE];
        for j in 0..z.len() {
            for start in (0..x.len()).step_by(TILE) {
                let len = TILE.min(x.len() - start);
                for (i, w) in tile[..len].iter_mut().enumerate() {
                    *w = weights[(start + i, j)];
                }
                bound.accumulate(j, start, &tile[..len], &mut grad);
            }
        }
        finite("kernel gradient", &grad)?;
        Ok(grad)
    }

    fn check_pair(&self, x: &Inputs, z: &Inputs) -> Result<()> {
        if x.dims() != z.dims() {
            return Err(shape(
                "input dimensions of the two sets",
                x.dims(),
                z.dims(),
            ));
        }
        self.check(x.dims())
    }
}
