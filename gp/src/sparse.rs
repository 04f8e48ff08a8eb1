//! Many points: inducing latent functions by the variational bound.
//!
//! The latent functions at `M` inducing inputs `Z` stand for the data (Titsias
//! 2009), here for any linear functionals of a matrix-valued process. With
//! `K_uu = K(Z, Z)`, `K_uf = K(Z, X) H^T`, noise `D`, `r = y - m`:
//! `A = L_u⁻¹ K_uf D^{-1/2}`, `B = I + A A^T`, `c = L_B⁻¹ A D^{-1/2} r`,
//! `ELBO = -½ [R ln 2π + ln|B| + ln|D| + r^T D⁻¹ r - c^T c + Σ_r (k_rr - q_rr)/D_r]`.
//! Cost `O(R q²)` with `q = M n` latent values, memory `O(q²)`; the bound tells
//! from below how much evidence the approximation keeps, and `B ⪰ I` never
//! fails to factorise.

use crate::error::{GpError, Result, finite, shape};
use crate::evidence::checked;
use crate::functional::Functionals;
use crate::gram::{Stack, assemble, variances};
use crate::inputs::Inputs;
use crate::linalg::{Square, cholesky, solve_lower, solve_upper};
use crate::model::Model;
use crate::posterior::{Prediction, apply, checked_matrix, latent_mean, stack_for};
use crate::simd::{axpy, dispatch, dot};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Points per block of data.
pub(crate) const CHUNK: usize = 128;
/// Blocks are dealt to a fixed number of groups: one order of summation everywhere.
const GROUPS: usize = 4;

/// A model conditioned on many measurements through inducing latent functions.
///
/// Means are `m + H f̂`, so constraints hold to round-off as in the exact model.
pub struct SparsePosterior {
    model: Model,
    pub(crate) inducing: Stack,
    pub(crate) factor_u: Square,
    pub(crate) factor_b: Square,
    /// `w = (K_uu + K_uf D⁻¹ K_fu)⁻¹ K_uf D⁻¹ r`.
    pub(crate) weights: Vec<f64>,
    columns: Vec<Vec<f64>>,
    bound: f64,
    jitter: f64,
    /// Jitter over the mean of the diagonal of `K_uu`.
    relative: f64,
}

/// The results of conditioning, all that prediction needs.
pub(crate) struct Solved {
    pub(crate) factor_u: Square,
    pub(crate) factor_b: Square,
    pub(crate) weights: Vec<f64>,
    pub(crate) bound: f64,
    pub(crate) jitter: f64,
    pub(crate) relative: f64,
}

/// `K_uu` is smooth and noise-free: it always needs a little jitter.
const JITTERS: [f64; 3] = [1e-8, 1e-7, 1e-6];

/// Sums over all blocks of data.
struct Sums {
    gram: Square,
    moment: Vec<f64>,
    /// `Σ r²/D + ln D + (k - q)/D`.
    rest: f64,
}

impl SparsePosterior {
    /// Condition `model` on measurements `y` of `data` through inducing inputs
    /// (for example [`crate::farthest_points`] of the data).
    ///
    /// Errors: as [`crate::Posterior::new`]; inducing inputs of another dimension, or none.
    pub fn new(model: &Model, data: &Functionals, y: &[f64], inducing: &Inputs) -> Result<Self> {
        if inducing.is_empty() || inducing.dims() != data.dims() {
            return Err(shape(
                "inducing inputs",
                format!("at least one, {} coordinates", data.dims()),
                format!("{} with {} coordinates", inducing.len(), inducing.dims()),
            ));
        }
        if data.n_rows() != y.len() {
            return Err(shape("measurements y", data.n_rows(), y.len()));
        }
        checked(model, data, y)?;
        let noise = model.noise_of(data)?;
        let identity = Functionals::identity(inducing, model.prior.n_latent());
        let inducing = Stack::new(&identity, &model.prior);
        let (factor_u, jitter, relative) = factor_inducing(model, &inducing)?;
        let sums = accumulate(model, data, y, &noise, &inducing, &factor_u);
        let mut factor_b = sums.gram;
        factor_b.add_diagonal(&vec![1.0; inducing.rows]);
        cholesky(&mut factor_b).map_err(|row| unfactored(row, &inducing, 0.0))?;
        let mut c = sums.moment;
        let q = inducing.rows;
        solve_columns(&factor_b, &mut c);
        let fit: f64 = c.iter().map(|v| v * v).sum();
        let log_det: f64 = 2.0 * factor_b.diagonal().map(f64::ln).sum::<f64>();
        let constant = data.n_rows() as f64 * (2.0 * std::f64::consts::PI).ln();
        let bound = -0.5 * (constant + log_det + sums.rest - fit);
        finite("variational bound", &[bound])?;
        solve_upper(
            factor_b.view(),
            MatMut::from_column_major_slice_mut(&mut c, q, 1),
        );
        solve_upper(
            factor_u.view(),
            MatMut::from_column_major_slice_mut(&mut c, q, 1),
        );
        let solved = Solved {
            factor_u,
            factor_b,
            weights: c,
            bound,
            jitter,
            relative,
        };
        Ok(Self::with(model.clone(), inducing, solved))
    }

    /// From what was computed before, its shapes checked by the caller.
    pub(crate) fn assembled(model: &Model, inducing: &Inputs, solved: Solved) -> Self {
        let identity = Functionals::identity(inducing, model.prior.n_latent());
        let stack = Stack::new(&identity, &model.prior);
        Self::with(model.clone(), stack, solved)
    }

    fn with(model: Model, inducing: Stack, solved: Solved) -> Self {
        let n = inducing.n_latent;
        let column = |d: usize| solved.weights.iter().skip(d).step_by(n).copied().collect();
        Self {
            columns: (0..n).map(column).collect(),
            model,
            inducing,
            factor_u: solved.factor_u,
            factor_b: solved.factor_b,
            weights: solved.weights,
            bound: solved.bound,
            jitter: solved.jitter,
            relative: solved.relative,
        }
    }

    /// The model that was conditioned.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The inducing inputs.
    pub fn inducing_inputs(&self) -> &Inputs {
        &self.inducing.inputs
    }

    /// Lower bound of `ln p(y)`, nats.
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// Jitter on `K_uu`, absolute.
    pub fn jitter(&self) -> f64 {
        self.jitter
    }

    pub(crate) fn relative_jitter(&self) -> f64 {
        self.relative
    }

    /// Posterior mean of the latent functions, point-major.
    pub fn latent_mean(&self, at: &Inputs) -> Result<Vec<f64>> {
        latent_mean(&self.model.prior, &self.inducing, &self.columns, at)
    }

    /// Posterior mean of the rows of `at`.
    pub fn mean(&self, at: &Functionals) -> Result<Vec<f64>> {
        stack_for(&self.model, at, self.inducing.inputs.dims())?;
        apply(at, &self.latent_mean(&at.inputs())?)
    }

    /// Posterior mean and variance of the rows of `at`.
    pub fn predict(&self, at: &Functionals) -> Result<Prediction> {
        let mean = self.mean(at)?;
        let indices: Vec<usize> = (0..at.n_points()).collect();
        let q = self.inducing.rows;
        let chunks: Vec<Vec<f64>> = indices
            .par_chunks(CHUNK)
            .map(|chunk| {
                let stack = Stack::new(&at.pick(chunk), &self.model.prior);
                let mut v = variances(&self.model.prior, &stack);
                let mut cross = self.cross(&stack);
                norms(&cross, q, &mut v, -1.0);
                solve_columns(&self.factor_b, &mut cross);
                norms(&cross, q, &mut v, 1.0);
                v
            })
            .collect();
        Prediction::checked(mean, chunks.concat())
    }

    /// `L_u⁻¹ K_u*`, column-major `q × rows`.
    fn cross(&self, stack: &Stack) -> Vec<f64> {
        let q = self.inducing.rows;
        let mut cross = vec![0.0; q * stack.rows];
        assemble(
            &self.model.prior,
            &self.inducing,
            stack,
            false,
            &mut cross,
            q,
        );
        solve_columns(&self.factor_u, &mut cross);
        cross
    }

    /// Posterior covariance of all rows of `at`, noise-free.
    pub fn covariance(&self, at: &Functionals) -> Result<Mat<f64>> {
        let stack = stack_for(&self.model, at, self.inducing.inputs.dims())?;
        let q = self.inducing.rows;
        let mut out = crate::posterior::prior_matrix(&self.model, &stack);
        let mut cross = self.cross(&stack);
        let v = MatRef::from_column_major_slice(&cross, q, stack.rows).to_owned();
        solve_columns(&self.factor_b, &mut cross);
        let w = MatRef::from_column_major_slice(&cross, q, stack.rows);
        out -= v.transpose() * &v;
        out += w.transpose() * w;
        checked_matrix(out)
    }
}

/// `L⁻¹` times column-major `columns` of the factor's size.
fn solve_columns(factor: &Square, columns: &mut [f64]) {
    let q = factor.view().nrows();
    let count = columns.len() / q;
    let columns = MatMut::from_column_major_slice_mut(columns, q, count);
    solve_lower(factor.view(), columns);
}

fn norms(columns: &[f64], q: usize, out: &mut [f64], sign: f64) {
    for (column, v) in columns.chunks(q).zip(out) {
        *v += sign * dispatch(|| dot(column, column));
    }
}

fn unfactored(row: usize, stack: &Stack, jitter: f64) -> GpError {
    let point = stack.starts.partition_point(|&s| s <= row) - 1;
    GpError::NotPositiveDefinite {
        row,
        point,
        jitter,
        coincident: stack.inputs.coincident(),
    }
}

fn factor_inducing(model: &Model, inducing: &Stack) -> Result<(Square, f64, f64)> {
    let mut factor = Square::default();
    let (mut row, mut jitter) = (0, 0.0);
    for relative in JITTERS {
        factor.resize(inducing.rows);
        let stride = factor.stride();
        assemble(
            &model.prior,
            inducing,
            inducing,
            true,
            factor.data_mut(),
            stride,
        );
        finite(
            "prior variance of the inducing inputs",
            &factor.diagonal().collect::<Vec<_>>(),
        )?;
        jitter = relative * factor.diagonal().sum::<f64>() / inducing.rows as f64;
        factor.add_diagonal(&vec![jitter; inducing.rows]);
        match cholesky(&mut factor) {
            Ok(()) => return Ok((factor, jitter, relative)),
            Err(at) => row = at,
        }
    }
    Err(unfactored(row, inducing, jitter))
}

/// `A = L_u⁻¹ K_uf D^{-1/2}` for one block of data, column-major `q × rows`.
pub(crate) fn block(
    model: &Model,
    stack: &Stack,
    inducing: &Stack,
    factor_u: &Square,
    noise: &[f64],
) -> Vec<f64> {
    let q = inducing.rows;
    let mut a = vec![0.0; q * stack.rows];
    assemble(&model.prior, inducing, stack, false, &mut a, q);
    solve_lower(
        factor_u.view(),
        MatMut::from_column_major_slice_mut(&mut a, q, stack.rows),
    );
    for (column, d) in a.chunks_mut(q).zip(noise) {
        let s = 1.0 / d.sqrt();
        column.iter_mut().for_each(|v| *v *= s);
    }
    a
}

fn accumulate(
    model: &Model,
    data: &Functionals,
    y: &[f64],
    noise: &[f64],
    inducing: &Stack,
    factor_u: &Square,
) -> Sums {
    let q = inducing.rows;
    let points: Vec<usize> = (0..data.n_points()).collect();
    let blocks: Vec<&[usize]> = points.chunks(CHUNK).collect();
    let groups: Vec<Sums> = (0..GROUPS.min(blocks.len()))
        .into_par_iter()
        .map(|group| {
            let mut sums = Sums {
                gram: Square::default(),
                moment: vec![0.0; q],
                rest: 0.0,
            };
            sums.gram.resize(q);
            for chunk in blocks.iter().skip(group).step_by(GROUPS) {
                let rows = data.rows_of(chunk[0]).start..data.rows_of(chunk[chunk.len() - 1]).end;
                let stack = Stack::new(&data.pick(chunk), &model.prior);
                let noise = &noise[rows.clone()];
                let a = block(model, &stack, inducing, factor_u, noise);
                let prior = variances(&model.prior, &stack);
                for (j, r) in rows.enumerate() {
                    let column = &a[j * q..(j + 1) * q];
                    let residual = y[r] - data.mean()[r];
                    axpy(residual / noise[j].sqrt(), column, &mut sums.moment);
                    let explained = dispatch(|| dot(column, column));
                    sums.rest +=
                        residual * residual / noise[j] + noise[j].ln() + prior[j] / noise[j]
                            - explained;
                }
                let a = MatRef::from_column_major_slice(&a, q, stack.rows);
                matmul(
                    sums.gram.view_mut(),
                    BlockStructure::TriangularLower,
                    Accum::Add,
                    a,
                    BlockStructure::Rectangular,
                    a.transpose(),
                    BlockStructure::Rectangular,
                    1.0,
                    Par::Seq,
                );
            }
            sums
        })
        .collect();
    let mut groups = groups.into_iter();
    // `checked` refused empty data, so there is at least one group.
    let mut total = groups.next().unwrap_or(Sums {
        gram: Square::default(),
        moment: vec![0.0; q],
        rest: 0.0,
    });
    for g in groups {
        axpy(1.0, g.gram.data(), total.gram.data_mut());
        axpy(1.0, &g.moment, &mut total.moment);
        total.rest += g.rest;
    }
    total
}
