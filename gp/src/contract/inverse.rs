//! Contraction with the whole inverse: any mixing, model parameters.

use super::{Contraction, GROUPS, Sources};
use crate::gram::{Stack, Tile, bind};
use crate::kernel::Bound;
use crate::latent::Mixing;
use crate::linalg::Square;
use crate::simd::{TILE, axpy, dispatch, dot, fused};
use rayon::prelude::*;
use std::ops::Range;

/// Contract with the full inverse; `inverse` holds `Σ⁻¹` in its lower triangle.
pub(crate) fn with_inverse(
    src: &Sources<'_>,
    inverse: &mut Square,
    want_maps: bool,
) -> Contraction {
    mirror_blocks(src.stack, inverse);
    let inverse = &*inverse;
    let kernels = bind(src.prior, &src.stack.inputs, &src.stack.inputs);
    let beta = src.beta();
    let size = want_maps.then_some(src.stack.rows * src.stack.n_latent);
    let parts: Vec<Contraction> = (0..GROUPS.min(src.stack.n_points()))
        .into_par_iter()
        .map(|group| {
            let mut worker = Worker::new(
                src,
                inverse,
                &kernels,
                &beta,
                Contraction::zero(src.prior, size),
            );
            for i in (group..src.stack.n_points()).step_by(GROUPS) {
                worker.column(i);
            }
            worker.sum
        })
        .collect();
    parts
        .into_iter()
        .fold(Contraction::zero(src.prior, size), Contraction::add)
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
                axpy(
                    -self.beta[i * stack.n_latent + d],
                    &self.src.alpha[rows.clone()],
                    out,
                );
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
            *w = product[r.start - rows.start..r.end - rows.start]
                .iter()
                .sum();
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
            fused(
                &self.tile.spread[..len],
                stack.h(c, rows.clone()),
                &mut self.product[..len],
            );
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
        self.tile
            .fill(stack, self.src.prior, self.kernels, i, points.clone());
        let skip = if points.start == i {
            stack.rows_of(i..i + 1).len()
        } else {
            0
        };
        let Some(maps) = &mut self.sum.maps else {
            return;
        };
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
            let Some(maps) = &mut self.sum.maps else {
                return;
            };
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
