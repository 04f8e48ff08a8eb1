//! Contraction from the inverse factor alone: diagonal mixings, no model parameters.

use super::{Contraction, GROUPS, Sources};
use crate::gram::{Stack, bind};
use crate::kernel::Bound;
use crate::latent::{LatentPrior, Mixing};
use crate::linalg::Square;
use crate::simd::{TILE, axpy, dispatch};
use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

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
                    column_of(
                        src,
                        weights,
                        &beta,
                        term.mixing.dims(),
                        &kernels[t],
                        i,
                        &mut grad,
                    );
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
        && prior
            .terms()
            .iter()
            .all(|t| matches!(t.mixing, Mixing::Each(_)))
        && prior
            .terms()
            .iter()
            .map(|t| t.mixing.dims().len())
            .sum::<usize>()
            <= 2 * stack.n_latent
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
