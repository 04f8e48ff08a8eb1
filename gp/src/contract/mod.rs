//! Traces of the evidence gradient without any (nN)² matrix per parameter.
//!
//! `½ tr(W ∂Σ)` with `W = Σ⁻¹ - α α^T`. For a term `B_t k_t` the N×N weights
//! `w_t[i, j] = tr(H_i^T W_ij H_j B_t)` suffice for every parameter of `k_t`;
//! for the parameters of `B_t` the `n × n` matrix `Σ_ij k_t(i, j) H_i^T W_ij H_j`
//! does, and for model parameters `M_i = Σ_j W_ij H_j K(x_j, x_i)`.

mod factor;
mod inverse;

pub(crate) use factor::{factor_suffices, with_factor};
pub(crate) use inverse::with_inverse;

use crate::gram::Stack;
use crate::latent::LatentPrior;
use crate::simd::axpy;
use faer::Mat;

/// Gradient parts of `½ tr(W ∂Σ)`.
pub(crate) struct Contraction {
    /// Per term, the kernel's parameters.
    pub(crate) kernels: Vec<Vec<f64>>,
    /// Per term, `D` with `d(½ tr W Σ) = Σ D_cd dB_cd` on the term's dimensions.
    pub(crate) mixings: Vec<Mat<f64>>,
    /// `M`, column-major `R × n_latent`, when asked for.
    pub(crate) maps: Option<Vec<f64>>,
}

impl Contraction {
    pub(crate) fn zero(prior: &LatentPrior, maps: Option<usize>) -> Self {
        Self {
            kernels: prior
                .terms()
                .iter()
                .map(|t| vec![0.0; t.kernel.n_params()])
                .collect(),
            mixings: prior
                .terms()
                .iter()
                .map(|t| Mat::zeros(t.mixing.dims().len(), t.mixing.dims().len()))
                .collect(),
            maps: maps.map(|n| vec![0.0; n]),
        }
    }

    pub(crate) fn add(mut self, other: Self) -> Self {
        for (a, b) in self.kernels.iter_mut().zip(&other.kernels) {
            axpy(1.0, b, a);
        }
        for (a, b) in self.mixings.iter_mut().zip(&other.mixings) {
            *a += b;
        }
        if let (Some(a), Some(b)) = (&mut self.maps, &other.maps) {
            axpy(1.0, b, a);
        }
        self
    }
}

/// Everything a contraction reads.
pub(crate) struct Sources<'a> {
    pub(crate) prior: &'a LatentPrior,
    pub(crate) stack: &'a Stack,
    /// `α = Σ⁻¹ (y - m)`, length `R`.
    pub(crate) alpha: &'a [f64],
}

impl Sources<'_> {
    /// `β_i = H_i^T α_i`, `n_latent` numbers per point.
    pub(crate) fn beta(&self) -> Vec<f64> {
        let n = self.stack.n_latent;
        let mut out = vec![0.0; self.stack.n_points() * n];
        for i in 0..self.stack.n_points() {
            for r in self.stack.rows_of(i..i + 1) {
                for d in 0..n {
                    out[i * n + d] += self.stack.h(d, r..r + 1)[0] * self.alpha[r];
                }
            }
        }
        out
    }
}

/// Columns are dealt to a fixed number of groups, so sums have one order on
/// every machine.
const GROUPS: usize = 16;
