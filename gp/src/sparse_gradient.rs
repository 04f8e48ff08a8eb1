//! Gradient of the variational bound in kernel, noise and model parameters.
//!
//! With `Λ = D⁻¹`, `w` the weights of the sparse posterior,
//! `Σ_B = K_uu + K_uf Λ K_fu` and `S = K_uu⁻¹ - Σ_B⁻¹ - w w^T`:
//! `∂F/∂K_uf = S K_uf Λ + w (Λ r)^T`,
//! `∂F/∂K_uu = -½ (Σ_B⁻¹ - 2 K_uu⁻¹ + w w^T + K_uu⁻¹ Σ_B K_uu⁻¹)`,
//! `∂F/∂k_rr = -½ Λ_r`, `∂F/∂m = Λ (r - K_fu w)`. The data pass by in blocks.

use crate::contract::Contraction;
use crate::error::Result;
use crate::evidence::{Evidence, along, check_tangents};
use crate::functional::Functionals;
use crate::gram::{Stack, assemble, bind};
use crate::inputs::Inputs;
use crate::kernel::Bound;
use crate::latent::{LatentPrior, Mixing};
use crate::linalg::{Square, inverse_from_factor, invert_lower, solve_lower};
use crate::model::{Model, Tangent};
use crate::simd::{TILE, axpy, dispatch, dot};
use crate::sparse::{CHUNK, SparsePosterior};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

const GROUPS: usize = 4;

/// Negative variational bound of the log evidence through `inducing` inputs,
/// with its gradient in every parameter of the model and of `tangents`.
///
/// [`Evidence::nll`] is an upper bound of the exact value; `jitter` is the one
/// on `K_uu`, and the gradient accounts for it.
pub fn sparse_evidence(
    model: &Model,
    f: &Functionals,
    y: &[f64],
    inducing: &Inputs,
    tangents: &[Tangent],
) -> Result<Evidence> {
    check_tangents(f, tangents)?;
    let posterior = SparsePosterior::new(model, f, y, inducing)?;
    let noise = model.noise_of(f)?;
    let (slope, own) = slopes(&posterior);
    let pass = Pass {
        model,
        f,
        y,
        noise: &noise,
        posterior: &posterior,
        slope: &slope,
    };
    let points: Vec<usize> = (0..f.n_points()).collect();
    let blocks: Vec<&[usize]> = points.chunks(CHUNK).collect();
    let groups: Vec<Sums> = (0..GROUPS.min(blocks.len()))
        .into_par_iter()
        .map(|g| {
            let mut sums = Sums::new(model, f);
            blocks
                .iter()
                .skip(g)
                .step_by(GROUPS)
                .for_each(|b| pass.block(b, &mut sums));
            sums
        })
        .collect();
    let mut total = groups.into_iter().fold(Sums::new(model, f), Sums::add);
    inducing_part(&model.prior, &posterior.inducing, &own, &mut total.parts);
    let negative = |v: Vec<f64>| -> Vec<f64> { v.into_iter().map(|v| -v).collect() };
    let mut gradient = negative(
        model
            .prior
            .assemble_gradient(&total.parts.kernels, &total.parts.mixings),
    );
    gradient.extend(negative(total.noise));
    // `along` is Σ<∂H, M> - α^T ∂m; here both are derivatives of F, so α enters negated.
    let alpha = negative(total.alpha);
    let theta = tangents
        .iter()
        .map(|t| -along(t, &total.parts, &alpha, f.n_latent()))
        .collect();
    Ok(Evidence {
        nll: -posterior.bound(),
        gradient,
        theta,
        jitter: posterior.jitter(),
        coincident: Vec::new(),
    })
}

/// `S` (dense) and `∂F/∂K_uu` with the share of the jitter on its diagonal.
fn slopes(p: &SparsePosterior) -> (Mat<f64>, Mat<f64>) {
    let q = p.inducing.rows;
    let lower = |s: &Square| Mat::from_fn(q, q, |i, j| if i >= j { s.col(j)[i] } else { 0.0 });
    let (mut inverse, mut whole) = (Square::default(), Square::default());
    inverse.resize(q);
    whole.resize(q);
    invert_lower(&mut inverse, &p.factor_u);
    inverse_from_factor(&mut whole, &inverse);
    let ku_inv = Mat::from_fn(q, q, |i, j| whole.col(i.min(j))[i.max(j)]);
    let lu_inv = lower(&inverse);
    let mut e = lu_inv.clone();
    solve_lower(p.factor_b.view(), e.as_mut());
    let sb_inv = e.transpose() * &e;
    let g = lower(&p.factor_b).transpose() * &lu_inv;
    let bent = g.transpose() * &g;
    let w = &p.weights;
    let s = Mat::from_fn(q, q, |i, j| ku_inv[(i, j)] - sb_inv[(i, j)] - w[i] * w[j]);
    let mut own = Mat::from_fn(q, q, |i, j| {
        -0.5 * (sb_inv[(i, j)] - 2.0 * ku_inv[(i, j)] + w[i] * w[j] + bent[(i, j)])
    });
    let share = p.relative_jitter() * (0..q).map(|i| own[(i, i)]).sum::<f64>() / q as f64;
    (0..q).for_each(|i| own[(i, i)] += share);
    (s, own)
}

struct Sums {
    parts: Contraction,
    noise: Vec<f64>,
    /// `∂F/∂m`.
    alpha: Vec<f64>,
}

impl Sums {
    fn new(model: &Model, f: &Functionals) -> Self {
        Self {
            parts: Contraction::zero(&model.prior, Some(f.n_rows() * f.n_latent())),
            noise: vec![0.0; model.log_noise.len()],
            alpha: vec![0.0; f.n_rows()],
        }
    }

    fn add(mut self, other: Self) -> Self {
        axpy(1.0, &other.noise, &mut self.noise);
        axpy(1.0, &other.alpha, &mut self.alpha);
        self.parts = self.parts.add(other.parts);
        self
    }
}

struct Pass<'a> {
    model: &'a Model,
    f: &'a Functionals,
    y: &'a [f64],
    noise: &'a [f64],
    posterior: &'a SparsePosterior,
    slope: &'a Mat<f64>,
}

impl Pass<'_> {
    fn block(&self, chunk: &[usize], sums: &mut Sums) {
        let inducing = &self.posterior.inducing;
        let (q, w) = (inducing.rows, &self.posterior.weights);
        let first = self.f.rows_of(chunk[0]).start;
        let stack = Stack::new(&self.f.pick(chunk), &self.model.prior);
        let mut cross = vec![0.0; q * stack.rows];
        assemble(&self.model.prior, inducing, &stack, false, &mut cross, q);
        let view = MatRef::from_column_major_slice(&cross, q, stack.rows);
        // ∂F/∂K_uf, column-major like `cross`.
        let mut g = vec![0.0; q * stack.rows];
        matmul(
            MatMut::from_column_major_slice_mut(&mut g, q, stack.rows),
            Accum::Replace,
            self.slope,
            view,
            1.0,
            Par::Seq,
        );
        let prior = crate::gram::variances(&self.model.prior, &stack);
        let kernels = bind(&self.model.prior, &stack.inputs, &stack.inputs);
        for j in 0..stack.rows {
            let r = first + j;
            let (precision, residual) = (1.0 / self.noise[r], self.y[r] - self.f.mean()[r]);
            let k = &cross[j * q..(j + 1) * q];
            let column = &mut g[j * q..(j + 1) * q];
            let explained = dispatch(|| dot(k, w));
            let reduced = dispatch(|| dot(k, column)) + explained * explained;
            let left = residual - explained;
            let d = -0.5 * (left * left + prior[j] - reduced - self.noise[r]);
            sums.noise[self.f.channels()[r]] -= precision * d;
            sums.alpha[r] = precision * left;
            for (c, w) in column.iter_mut().zip(w) {
                *c = precision * (*c + residual * w);
            }
            self.own_variance(&stack, &kernels, j, first, &mut sums.parts);
        }
        self.terms(&stack, &g, first, &mut sums.parts);
    }

    /// The part of `∂F/∂H_r` and of the kernels that comes from the prior variance `k_rr`.
    fn own_variance(
        &self,
        stack: &Stack,
        kernels: &[Bound<'_>],
        j: usize,
        first: usize,
        parts: &mut Contraction,
    ) {
        let point = stack.starts.partition_point(|&s| s <= j) - 1;
        let precision = 1.0 / self.noise[first + j];
        for (t, term) in self.model.prior.terms().iter().enumerate() {
            let mut k = [0.0];
            kernels[t].values(point, point, &mut k);
            let dims = term.mixing.dims();
            let mut spread = 0.0;
            for (a, &c) in dims.iter().enumerate() {
                let (h, hb) = (stack.h(c, j..j + 1)[0], stack.hb(t, c, j..j + 1)[0]);
                spread += h * hb;
                if let Some(m) = &mut parts.maps {
                    m[c * self.f.n_rows() + first + j] -= precision * k[0] * hb;
                }
                for (b, &d) in dims.iter().enumerate() {
                    parts.mixings[t][(a, b)] -=
                        0.5 * precision * k[0] * h * stack.h(d, j..j + 1)[0];
                }
            }
            kernels[t].accumulate(
                point,
                point,
                &[-0.5 * precision * spread],
                &mut parts.kernels[t],
            );
        }
    }

    /// Everything that comes from `∂F/∂K_uf = G`.
    fn terms(&self, stack: &Stack, g: &[f64], first: usize, parts: &mut Contraction) {
        let inducing = &self.posterior.inducing;
        let kernels = bind(&self.model.prior, &inducing.inputs, &stack.inputs);
        let (n, q) = (stack.n_latent, inducing.rows);
        for (t, term) in self.model.prior.terms().iter().enumerate() {
            let (dims, b) = (term.mixing.dims(), term.mixing.matrix());
            let coupled = matches!(term.mixing, Mixing::Coregion { .. });
            for i in 0..stack.n_points() {
                for start in (0..inducing.n_points()).step_by(TILE) {
                    let len = TILE.min(inducing.n_points() - start);
                    let (mut weight, mut k) = ([0.0; TILE], [0.0; TILE]);
                    let (weight, k) = (&mut weight[..len], &mut k[..len]);
                    kernels[t].values(i, start, k);
                    for r in stack.rows_of(i..i + 1) {
                        // kg[c] = Σ_z k(z, x) G[(z, c), r].
                        let mut kg = vec![0.0; dims.len()];
                        for (a, &c) in dims.iter().enumerate() {
                            let hb = stack.hb(t, c, r..r + 1)[0];
                            for z in 0..len {
                                let slope = g[r * q + (start + z) * n + c];
                                weight[z] += slope * hb;
                                kg[a] += k[z] * slope;
                            }
                        }
                        self.spread(t, dims, &b, coupled, &kg, stack, r, first, parts);
                    }
                    kernels[t].accumulate(i, start, weight, &mut parts.kernels[t]);
                }
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn spread(
        &self,
        t: usize,
        dims: &[usize],
        b: &Mat<f64>,
        coupled: bool,
        kg: &[f64],
        stack: &Stack,
        r: usize,
        first: usize,
        parts: &mut Contraction,
    ) {
        for (j, &d) in dims.iter().enumerate() {
            if let Some(m) = &mut parts.maps {
                let v: f64 = kg.iter().enumerate().map(|(a, v)| v * b[(a, j)]).sum();
                m[d * self.f.n_rows() + first + r] += v;
            }
            if coupled {
                let h = stack.h(d, r..r + 1)[0];
                for (a, v) in kg.iter().enumerate() {
                    parts.mixings[t][(a, j)] += 0.5 * v * h;
                    parts.mixings[t][(j, a)] += 0.5 * v * h;
                }
            }
        }
    }
}

/// Everything that comes from `∂F/∂K_uu`.
fn inducing_part(prior: &LatentPrior, inducing: &Stack, own: &Mat<f64>, parts: &mut Contraction) {
    let kernels = bind(prior, &inducing.inputs, &inducing.inputs);
    let (n, points) = (inducing.n_latent, inducing.n_points());
    for (t, term) in prior.terms().iter().enumerate() {
        let (dims, b) = (term.mixing.dims(), term.mixing.matrix());
        for i in 0..points {
            for start in (0..points).step_by(TILE) {
                let len = TILE.min(points - start);
                let (mut weight, mut k) = ([0.0; TILE], [0.0; TILE]);
                kernels[t].values(i, start, &mut k[..len]);
                for z in 0..len {
                    for (a, &c) in dims.iter().enumerate() {
                        for (e, &d) in dims.iter().enumerate() {
                            let slope = own[((start + z) * n + c, i * n + d)];
                            weight[z] += slope * b[(a, e)];
                            parts.mixings[t][(a, e)] += k[z] * slope;
                        }
                    }
                }
                kernels[t].accumulate(i, start, &weight[..len], &mut parts.kernels[t]);
            }
        }
    }
}
