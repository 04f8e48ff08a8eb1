//! Matrix-valued kernels: the prior of the latent forces or accelerations.

use crate::error::{GpError, Result, finite, shape};
use crate::kernel::Kernel;
use faer::Mat;
use serde::{Deserialize, Serialize};

/// How a scalar kernel spreads over the latent dimensions: the matrix `B` in `B k(x, x')`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mixing {
    /// `B = Σ_d e_d e_d^T`: the listed latent dimensions are independent and
    /// share the kernel's parameters. No parameters of its own.
    Each(Vec<usize>),
    /// `B = W W^T + diag(κ)` on the listed latent dimensions (Alvarez, Rosasco
    /// and Lawrence 2012; thesis 5.23). Parameters: `W` row by row in natural
    /// scale, then `ln κ`.
    Coregion {
        /// The latent dimensions that are coupled.
        dims: Vec<usize>,
        /// `W`, one row of equal length per coupled dimension.
        weights: Vec<Vec<f64>>,
        /// `ln κ`, one per coupled dimension.
        log_kappa: Vec<f64>,
    },
}

impl Mixing {
    /// The latent dimensions this mixing touches.
    pub fn dims(&self) -> &[usize] {
        match self {
            Self::Each(dims) | Self::Coregion { dims, .. } => dims,
        }
    }

    /// `B` restricted to [`Mixing::dims`].
    pub(crate) fn matrix(&self) -> Mat<f64> {
        let n = self.dims().len();
        match self {
            Self::Each(_) => Mat::identity(n, n),
            Self::Coregion {
                weights, log_kappa, ..
            } => Mat::from_fn(n, n, |i, j| {
                let w: f64 = weights[i].iter().zip(&weights[j]).map(|(a, b)| a * b).sum();
                if i == j { w + log_kappa[i].exp() } else { w }
            }),
        }
    }

    fn n_params(&self) -> usize {
        match self {
            Self::Each(_) => 0,
            Self::Coregion {
                weights, log_kappa, ..
            } => weights.iter().map(Vec::len).sum::<usize>() + log_kappa.len(),
        }
    }

    /// Gradient in the parameters, given the symmetric `D` with `dF = Σ_cd D_cd dB_cd`.
    fn gradient(&self, d: &Mat<f64>, out: &mut Vec<f64>) {
        if let Self::Coregion {
            weights, log_kappa, ..
        } = self
        {
            let n = weights.len();
            for i in 0..n {
                for r in 0..weights[i].len() {
                    out.push(2.0 * (0..n).map(|j| d[(i, j)] * weights[j][r]).sum::<f64>());
                }
            }
            out.extend((0..n).map(|i| d[(i, i)] * log_kappa[i].exp()));
        }
    }

    fn check(&self, n_latent: usize) -> Result<()> {
        let dims = self.dims();
        if dims.is_empty() {
            return Err(shape("latent dimensions of a term", "at least 1", 0));
        }
        for (i, &d) in dims.iter().enumerate() {
            if d >= n_latent || dims[..i].contains(&d) {
                return Err(shape(
                    "latent dimensions of a term",
                    format!("distinct numbers below {n_latent}"),
                    format!("{dims:?}"),
                ));
            }
        }
        if let Self::Coregion {
            weights, log_kappa, ..
        } = self
        {
            let rank = weights.first().map_or(0, Vec::len);
            if weights.len() != dims.len()
                || log_kappa.len() != dims.len()
                || weights.iter().any(|w| w.len() != rank)
            {
                return Err(shape(
                    "coregionalisation",
                    format!("{} equally long rows and {0} kappas", dims.len()),
                    format!("{} rows and {} kappas", weights.len(), log_kappa.len()),
                ));
            }
            finite("coregionalisation weights", &weights.concat())?;
            finite("coregionalisation log kappa", log_kappa)?;
        }
        Ok(())
    }
}

/// One summand `B k(x, x')` of a matrix-valued kernel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// The scalar kernel `k`.
    pub kernel: Kernel,
    /// The matrix `B`.
    pub mixing: Mixing,
}

/// Zero-mean Gaussian process over `n` latent functions with covariance
/// `Σ_t B_t k_t(x, x')` (`n × n`).
///
/// ```
/// use gp::{Kernel, LatentPrior};
/// let k = Kernel::squared_exponential(&[1.0], 2.0);
/// let forces = LatentPrior::independent(vec![k.clone(), k.clone()]);
/// let coupled = LatentPrior::intrinsic(k, vec![vec![1.0], vec![-0.5]], &[0.1, 0.1]);
/// assert_eq!(forces.n_params(), 4);
/// assert_eq!(coupled.n_params(), 6);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatentPrior {
    n_latent: usize,
    terms: Vec<Term>,
}

impl LatentPrior {
    /// Any sum of terms over `n_latent` functions. Errors: a term that names a
    /// latent dimension twice or one that does not exist, ragged weights.
    pub fn new(n_latent: usize, terms: Vec<Term>) -> Result<Self> {
        let prior = Self { n_latent, terms };
        prior.check_mixing()?;
        Ok(prior)
    }

    /// Diagonal: latent function `d` has its own kernel `kernels[d]`.
    pub fn independent(kernels: Vec<Kernel>) -> Self {
        let n_latent = kernels.len();
        let terms = kernels
            .into_iter()
            .enumerate()
            .map(|(d, kernel)| Term {
                kernel,
                mixing: Mixing::Each(vec![d]),
            })
            .collect();
        Self { n_latent, terms }
    }

    /// Diagonal with one kernel whose parameters all latent functions share.
    pub fn shared(n_latent: usize, kernel: Kernel) -> Self {
        let mixing = Mixing::Each((0..n_latent).collect());
        Self {
            n_latent,
            terms: vec![Term { kernel, mixing }],
        }
    }

    /// Intrinsic coregionalisation `(W W^T + diag κ) k(x, x')`: one row of `weights` per output.
    pub fn intrinsic(kernel: Kernel, weights: Vec<Vec<f64>>, kappa: &[f64]) -> Self {
        Self::coregional(vec![(kernel, weights, kappa.to_vec())])
    }

    /// Linear coregionalisation `Σ_t (W_t W_t^T + diag κ_t) k_t(x, x')` (thesis 5.24).
    ///
    /// The number of latent functions is the number of rows of the first `W`.
    pub fn coregional(parts: Vec<(Kernel, Vec<Vec<f64>>, Vec<f64>)>) -> Self {
        let n_latent = parts.first().map_or(0, |p| p.1.len());
        let terms = parts
            .into_iter()
            .map(|(kernel, weights, kappa)| Term {
                kernel,
                mixing: Mixing::Coregion {
                    dims: (0..n_latent).collect(),
                    weights,
                    log_kappa: kappa.iter().map(|k| k.ln()).collect(),
                },
            })
            .collect();
        Self { n_latent, terms }
    }

    /// Two independent groups of latent functions, those of `other` after ours:
    /// separate priors on `Q` and `Q_z` (thesis 5.7), or an output kernel for
    /// adventitious error (the `k_A` of thesis 5.6).
    pub fn and(mut self, other: Self) -> Self {
        let shift = self.n_latent;
        self.terms.extend(other.terms.into_iter().map(|mut t| {
            match &mut t.mixing {
                Mixing::Each(dims) | Mixing::Coregion { dims, .. } => {
                    dims.iter_mut().for_each(|d| *d += shift)
                }
            }
            t
        }));
        self.n_latent += other.n_latent;
        self
    }

    /// Number of latent functions `n`.
    pub fn n_latent(&self) -> usize {
        self.n_latent
    }

    /// The summands.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// Number of parameters: of each term its kernel, then its mixing.
    pub fn n_params(&self) -> usize {
        self.terms
            .iter()
            .map(|t| t.kernel.n_params() + t.mixing.n_params())
            .sum()
    }

    /// All parameters, term by term: kernel, then mixing.
    pub fn params(&self) -> Vec<f64> {
        let mut out = Vec::new();
        for t in &self.terms {
            out.extend(t.kernel.params());
            if let Mixing::Coregion {
                weights, log_kappa, ..
            } = &t.mixing
            {
                out.extend(weights.iter().flatten());
                out.extend(log_kappa);
            }
        }
        out
    }

    /// Name of each parameter, for example `term[0].log_length[1]`.
    pub fn param_names(&self) -> Vec<String> {
        let mut out = Vec::new();
        for (i, t) in self.terms.iter().enumerate() {
            out.extend(
                t.kernel
                    .param_names()
                    .into_iter()
                    .map(|n| format!("term[{i}].{n}")),
            );
            if let Mixing::Coregion {
                weights, log_kappa, ..
            } = &t.mixing
            {
                for (r, row) in weights.iter().enumerate() {
                    out.extend((0..row.len()).map(|c| format!("term[{i}].weight[{r}][{c}]")));
                }
                out.extend((0..log_kappa.len()).map(|r| format!("term[{i}].log_kappa[{r}]")));
            }
        }
        out
    }

    /// Replace all parameters. Errors: wrong count, NaN or infinity.
    pub fn set_params(&mut self, values: &[f64]) -> Result<()> {
        if values.len() != self.n_params() {
            return Err(shape(
                "parameters of the latent prior",
                self.n_params(),
                values.len(),
            ));
        }
        finite("parameters of the latent prior", values)?;
        let mut at = 0;
        for t in &mut self.terms {
            let n = t.kernel.n_params();
            t.kernel.set_params(&values[at..at + n])?;
            at += n;
            if let Mixing::Coregion {
                weights, log_kappa, ..
            } = &mut t.mixing
            {
                for v in weights.iter_mut().flatten().chain(log_kappa) {
                    *v = values[at];
                    at += 1;
                }
            }
        }
        Ok(())
    }

    /// Check the prior against inputs of `dims` coordinates.
    pub(crate) fn check(&self, dims: usize) -> Result<()> {
        self.check_mixing()?;
        for (i, t) in self.terms.iter().enumerate() {
            t.kernel.check(dims).map_err(|e| match e {
                GpError::Parameter {
                    name,
                    value,
                    expected,
                } => GpError::Parameter {
                    name: format!("term[{i}].{name}"),
                    value,
                    expected,
                },
                GpError::Shape {
                    what,
                    expected,
                    found,
                } => GpError::Shape {
                    what: format!("term[{i}]: {what}"),
                    expected,
                    found,
                },
                other => other,
            })?;
        }
        Ok(())
    }

    fn check_mixing(&self) -> Result<()> {
        if self.n_latent == 0 || self.terms.is_empty() {
            return Err(shape(
                "latent prior",
                "at least one latent function and one term",
                format!("{} functions, {} terms", self.n_latent, self.terms.len()),
            ));
        }
        self.terms
            .iter()
            .try_for_each(|t| t.mixing.check(self.n_latent))
    }

    /// Put kernel gradients and the `D` matrices of each term in parameter order.
    pub(crate) fn assemble_gradient(&self, kernels: &[Vec<f64>], mixings: &[Mat<f64>]) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.n_params());
        for ((t, k), d) in self.terms.iter().zip(kernels).zip(mixings) {
            out.extend_from_slice(k);
            t.mixing.gradient(d, &mut out);
        }
        out
    }
}
