//! Traces of the evidence gradient without any (nN)² matrix per parameter.
//!
//! `½ tr(W ∂Σ)` with `W = Σ⁻¹ - α α^T`. For a term `B_t k_t` the N×N weights
//! `w_t[i, j] = tr(H_i^T W_ij H_j B_t)` suffice for every parameter of `k_t`;
//! for the parameters of `B_t` the `n × n` matrix `Σ_ij k_t(i, j) H_i^T W_ij H_j`
//! does, and for model parameters `M_i = Σ_j W_ij H_j K(x_j, x_i)`.

use crate::gram::{Stack, Tile, bind};
use crate::kernel::Bound;
use crate::latent::{LatentPrior, Mixing};
use crate::linalg::Square;
use crate::simd::{TILE, axpy, dispatch, dot, fused};
use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::ops::Range;

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
            kernels: prior.terms().iter().map(|t| vec![0.0; t.kernel.n_params()]).collect(),
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

/// Contract with the full inverse; `inverse` holds `Σ⁻¹` in its lower triangle.
pub(crate) fn with_inverse(src: &Sources<'_>, inverse: &mut Square, want_maps: bool) -> Contraction {
    mirror_blocks(src.stack, inverse);
    let inverse = &*inverse;
    let kernels = bind(src.prior, &src.stack.inputs, &src.stack.inputs);
    let beta = src.beta();
    let size = want_maps.then_some(src.stack.rows * src.stack.n_latent);
    let parts: Vec<Contraction> = (0..GROUPS.min(src.stack.n_points()))
        .into_par_iter()
        .map(|group| {
            let mut worker = Worker::new(src, inverse, &kernels, &beta, Contraction::zero(src.prior, size));
            for i in (group..src.stack.n_points()).step_by(GROUPS) {
                worker.column(i);
            }
            worker.sum
        })
        .collect();
    parts.into_iter().fold(Contraction::zero(src.prior, size), Contraction::add)
}

/// The diagonal blocks of `Σ⁻¹` are needed whole.
fn mirror_blocks(stack: &Stack, a: &mut Square) {
    let stride = a.stride();
    let data = a.data_mut();
    for i in 0..stack.n_points() {
        let rows = stack.rows_of(i..i + 1);
        for c in rows.clone() {
            for r in rows.start..c {
                data[c * stride + r] = data[r * stride + c];
            }
        }
    }
}

struct Worker<'a> {
    src: &'a Sources<'a>,
    inverse: &'a Square,
    kernels: &'a [Bound<'a>],
    beta: &'a [f64],
    tile: Tile,
    /// `R_d = (W H_i)[:, d]` for the rows of the tile.
    right: Vec<f64>,
    product: Vec<f64>,
    sum: Contraction,
}

impl<'a> Worker<'a> {
    fn new(
        src: &'a Sources<'a>,
        inverse: &'a Square,
        kernels: &'a [Bound<'a>],
        beta: &'a [f64],
        sum: Contraction,
    ) -> Self {
        let stack = src.stack;
        Self {
            src,
            inverse,
            kernels,
            beta,
            tile: Tile::new(stack),
            right: vec![0.0; stack.widest * stack.n_latent],
            product: vec![0.0; stack.widest],
            sum,
        }
    }

    fn column(&mut self, i: usize) {
        let n = self.src.stack.n_points();
        for start in (i..n).step_by(TILE) {
            let points = start..(start + TILE).min(n);
            self.form_right(i, points.clone());
            for t in 0..self.kernels.len() {
                self.term(t, i, points.clone());
            }
            if self.sum.maps.is_some() {
                self.maps(i, points);
            }
        }
    }

    fn right(&self, d: usize, len: usize) -> &[f64] {
        &self.right[d * self.tile.width..d * self.tile.width + len]
    }

    /// `right[:, d] = Σ_s Σ⁻¹[rows, s] H[s, d] - α[rows] β_i[d]`.
    fn form_right(&mut self, i: usize, points: Range<usize>) {
        let stack = self.src.stack;
        let rows = stack.rows_of(points);
        let (width, right) = (self.tile.width, &mut self.right);
        dispatch(|| {
            for d in 0..stack.n_latent {
                let out = &mut right[d * width..d * width + rows.len()];
                out.fill(0.0);
                for s in stack.rows_of(i..i + 1) {
                    let h = stack.h(d, s..s + 1)[0];
                    if h != 0.0 {
                        axpy(h, &self.inverse.col(s)[rows.clone()], out);
                    }
                }
                axpy(-self.beta[i * stack.n_latent + d], &self.src.alpha[rows.clone()], out);
            }
        });
    }

    fn term(&mut self, t: usize, i: usize, points: Range<usize>) {
        let stack = self.src.stack;
        let rows = stack.rows_of(points.clone());
        let len = rows.len();
        let dims = self.src.prior.terms()[t].mixing.dims();
        let product = &mut self.product[..len];
        dispatch(|| {
            product.fill(0.0);
            for &d in dims {
                let right = &self.right[d * self.tile.width..d * self.tile.width + len];
                fused(stack.hb(t, d, rows.clone()), right, product);
            }
        });
        let mut weights = [0.0; TILE];
        let weights = &mut weights[..points.len()];
        for (p, w) in points.clone().zip(&mut *weights) {
            let r = stack.rows_of(p..p + 1);
            *w = product[r.start - rows.start..r.end - rows.start].iter().sum();
            if p == i {
                *w *= 0.5;
            }
        }
        self.kernels[t].accumulate(i, points.start, weights, &mut self.sum.kernels[t]);
        if matches!(self.src.prior.terms()[t].mixing, Mixing::Coregion { .. }) {
            self.mixing(t, i, points);
        }
    }

    /// `D_cd += ½ Σ k (V_cd + V_dc)` (once on the diagonal), `V = H_j^T W_ji H_i`.
    fn mixing(&mut self, t: usize, i: usize, points: Range<usize>) {
        let stack = self.src.stack;
        let rows = stack.rows_of(points.clone());
        let len = rows.len();
        let mut k = [0.0; TILE];
        let k = &mut k[..points.len()];
        self.kernels[t].values(i, points.start, k);
        if points.start == i {
            k[0] *= 0.5;
        }
        stack.spread(points, k, &mut self.tile.spread[..len]);
        let dims = self.src.prior.terms()[t].mixing.dims();
        for (a, &c) in dims.iter().enumerate() {
            self.product[..len].fill(0.0);
            fused(&self.tile.spread[..len], stack.h(c, rows.clone()), &mut self.product[..len]);
            for (b, &d) in dims.iter().enumerate() {
                let v = 0.5 * dispatch(|| dot(&self.product[..len], self.right(d, len)));
                self.sum.mixings[t][(a, b)] += v;
                self.sum.mixings[t][(b, a)] += v;
            }
        }
    }

    /// Rows `j` and `i` of `M` from the pair `(j, i)`.
    fn maps(&mut self, i: usize, points: Range<usize>) {
        let stack = self.src.stack;
        let rows = stack.rows_of(points.clone());
        let len = rows.len();
        self.add_below(i, points.clone());
        // Row i: the transposed pairs, without the diagonal block.
        self.tile.fill(stack, self.src.prior, self.kernels, i, points.clone());
        let skip = if points.start == i { stack.rows_of(i..i + 1).len() } else { 0 };
        let Some(maps) = &mut self.sum.maps else { return };
        for s in stack.rows_of(i..i + 1) {
            let column = &self.inverse.col(s)[rows.start + skip..rows.end];
            let alpha = &self.src.alpha[rows.start + skip..rows.end];
            for d in 0..stack.n_latent {
                let left = &self.tile.left(d, len)[skip..];
                let v = dispatch(|| dot(column, left) - self.src.alpha[s] * dot(alpha, left));
                maps[d * stack.rows + s] += v;
            }
        }
    }

    /// `M_j += W_ji H_i K(x_i, x_j)` for the tile's points `j`.
    fn add_below(&mut self, i: usize, points: Range<usize>) {
        let stack = self.src.stack;
        let rows = stack.rows_of(points.clone());
        let len = rows.len();
        let mut k = [0.0; TILE];
        let k = &mut k[..points.len()];
        for (t, term) in self.src.prior.terms().iter().enumerate() {
            self.kernels[t].values(i, points.start, k);
            stack.spread(points.clone(), k, &mut self.tile.spread[..len]);
            let b = term.mixing.matrix();
            let Some(maps) = &mut self.sum.maps else { return };
            for (q, &d) in term.mixing.dims().iter().enumerate() {
                let out = &mut maps[d * stack.rows + rows.start..d * stack.rows + rows.end];
                for (p, &c) in term.mixing.dims().iter().enumerate() {
                    let weight = b[(p, q)];
                    if weight != 0.0 {
                        let right = &self.right[c * self.tile.width..c * self.tile.width + len];
                        for ((o, s), r) in out.iter_mut().zip(&self.tile.spread[..len]).zip(right) {
                            *o += weight * s * r;
                        }
                    }
                }
            }
        }
    }
}

/// Contract without forming `Σ⁻¹`: `V_d = U_d^T U_d` with `U_d = C⁻¹ H_{:,d}`,
/// which costs `1/n` of the missing half of the inverse.
///
/// Only for diagonal mixings, without model parameters, and with at least as
/// many rows as latent functions per point on average. `c_inv` holds `C⁻¹` in its lower triangle;
/// `scratch` is overwritten.
pub(crate) fn with_factor(
    src: &Sources<'_>,
    c_inv: &Square,
    scratch: &mut Square,
    weights: &mut Square,
) -> Contraction {
    let stack = src.stack;
    let (n, points) = (stack.n_latent, stack.n_points());
    let block = (points / 8).clamp(16, 128);
    half_solves(stack, c_inv, scratch, block);
    let beta = src.beta();
    let kernels = bind(src.prior, &stack.inputs, &stack.inputs);
    let mut out = Contraction::zero(src.prior, None);
    weights.resize(points);
    for (t, term) in src.prior.terms().iter().enumerate() {
        for (at, &d) in term.mixing.dims().iter().enumerate() {
            let u = MatRef::from_column_major_slice_with_stride(
                &scratch.data()[d * scratch.stride()..],
                stack.rows,
                points,
                n * scratch.stride(),
            );
            products(stack, u, block, at == 0, weights.view_mut());
        }
        let weights = &*weights;
        let parts: Vec<Vec<f64>> = (0..GROUPS.min(points))
            .into_par_iter()
            .map(|group| {
                let mut grad = vec![0.0; out.kernels[t].len()];
                for i in (group..points).step_by(GROUPS) {
                    column_of(src, weights, &beta, term.mixing.dims(), &kernels[t], i, &mut grad);
                }
                grad
            })
            .collect();
        parts.iter().for_each(|p| axpy(1.0, p, &mut out.kernels[t]));
    }
    out
}

/// True when [`with_factor`] applies.
pub(crate) fn factor_suffices(prior: &LatentPrior, stack: &Stack) -> bool {
    stack.n_points() * stack.n_latent <= stack.rows
        && prior.terms().iter().all(|t| matches!(t.mixing, Mixing::Each(_)))
        && prior.terms().iter().map(|t| t.mixing.dims().len()).sum::<usize>() <= 2 * stack.n_latent
}

/// Column `j n + d` of `out` becomes `U_d[:, j] = Σ_{r in j} C⁻¹[:, r] H[r, d]`,
/// with zeros above it back to the start of its block of points.
fn half_solves(stack: &Stack, c_inv: &Square, out: &mut Square, block: usize) {
    let n = stack.n_latent;
    let (stride, rows) = (out.stride(), stack.rows);
    out.data_mut()[..]
        .par_chunks_mut(n * stride)
        .take(stack.n_points())
        .enumerate()
        .for_each(|(j, columns)| {
            let own = stack.rows_of(j..j + 1);
            let clear = stack.starts[j / block * block];
            dispatch(|| {
                for d in 0..n {
                    let out = &mut columns[d * stride..d * stride + rows];
                    out[clear..].fill(0.0);
                    for r in own.clone() {
                        let h = stack.h(d, r..r + 1)[0];
                        if h != 0.0 {
                            axpy(h, &c_inv.col(r)[r..], &mut out[r..]);
                        }
                    }
                }
            });
        });
}

/// Lower block triangle of `V (+)= U^T U`, blocks of `block` points, skipping the zeros of `U`.
fn products(stack: &Stack, u: MatRef<'_, f64>, block: usize, first: bool, mut v: MatMut<'_, f64>) {
    let points = stack.n_points();
    let accum = if first { Accum::Replace } else { Accum::Add };
    for j in (0..points).step_by(block) {
        let nj = block.min(points - j);
        for i in (j..points).step_by(block) {
            let ni = block.min(points - i);
            let from = stack.starts[i];
            let tall = stack.rows - from;
            matmul(
                v.rb_mut().submatrix_mut(i, j, ni, nj),
                accum,
                u.submatrix(from, i, tall, ni).transpose(),
                u.submatrix(from, j, tall, nj),
                1.0,
                Par::Seq,
            );
        }
    }
}

/// Kernel gradient of column `i` from the N×N weights.
fn column_of(
    src: &Sources<'_>,
    weights: &Square,
    beta: &[f64],
    dims: &[usize],
    kernel: &Bound<'_>,
    i: usize,
    grad: &mut [f64],
) {
    let (n, points) = (src.stack.n_latent, src.stack.n_points());
    let mut w = [0.0; TILE];
    for start in (i..points).step_by(TILE) {
        let len = TILE.min(points - start);
        let w = &mut w[..len];
        w.copy_from_slice(&weights.col(i)[start..start + len]);
        for &d in dims {
            let b = beta[i * n + d];
            for (k, w) in w.iter_mut().enumerate() {
                *w -= b * beta[(start + k) * n + d];
            }
        }
        if start == i {
            w[0] *= 0.5;
        }
        kernel.accumulate(i, start, w, grad);
    }
}
