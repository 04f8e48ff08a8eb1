//! Assembly of covariance matrices between stacked functionals, block by block.
//!
//! `Σ_ij = Σ_t k_t(x_i, x_j) H_i B_t H_j^T`. Work is laid out so that every
//! inner loop runs down a contiguous column: for one column point, a tile of
//! kernel values is spread over the rows of `H B_t` once, and the rows of the
//! column point then combine the result.

use crate::functional::Functionals;
use crate::inputs::Inputs;
use crate::kernel::Bound;
use crate::latent::{LatentPrior, Mixing};
use crate::simd::{TILE, axpy, dispatch, fused};
use rayon::prelude::*;
use std::ops::Range;

/// Functionals laid out for the inner loops.
pub(crate) struct Stack {
    pub(crate) inputs: Inputs,
    pub(crate) starts: Vec<usize>,
    pub(crate) rows: usize,
    pub(crate) n_latent: usize,
    /// `H`, column-major.
    h: Vec<f64>,
    /// `H B_t` per term, column-major; `None` where it equals `H` on the term's dimensions.
    mixed: Vec<Option<Vec<f64>>>,
    /// Most rows any run of [`TILE`] points can have.
    pub(crate) widest: usize,
}

impl Stack {
    pub(crate) fn new(f: &Functionals, prior: &LatentPrior) -> Self {
        let (rows, n_latent) = (f.n_rows(), f.n_latent());
        let h = f.columns();
        let mixed = prior
            .terms()
            .iter()
            .map(|t| mix(&t.mixing, &h, rows, n_latent))
            .collect();
        let most = (0..f.n_points())
            .map(|i| f.rows_of(i).len())
            .max()
            .unwrap_or(0);
        Self {
            inputs: f.inputs(),
            starts: f.starts().to_vec(),
            rows,
            n_latent,
            h,
            mixed,
            widest: most * TILE,
        }
    }

    pub(crate) fn n_points(&self) -> usize {
        self.starts.len() - 1
    }

    pub(crate) fn rows_of(&self, points: Range<usize>) -> Range<usize> {
        self.starts[points.start]..self.starts[points.end]
    }

    /// `H[rows, d]`.
    #[inline(always)]
    pub(crate) fn h(&self, d: usize, rows: Range<usize>) -> &[f64] {
        &self.h[d * self.rows + rows.start..d * self.rows + rows.end]
    }

    /// `(H B_t)[rows, d]`.
    #[inline(always)]
    pub(crate) fn hb(&self, t: usize, d: usize, rows: Range<usize>) -> &[f64] {
        match &self.mixed[t] {
            None => self.h(d, rows),
            Some(m) => &m[d * self.rows + rows.start..d * self.rows + rows.end],
        }
    }

    /// Repeat `values[p]` (one per point of `points`) over the rows of its point.
    #[inline(always)]
    pub(crate) fn spread(&self, points: Range<usize>, values: &[f64], out: &mut [f64]) {
        let r0 = self.starts[points.start];
        for (p, v) in points.zip(values) {
            out[self.starts[p] - r0..self.starts[p + 1] - r0].fill(*v);
        }
    }
}

fn mix(mixing: &Mixing, h: &[f64], rows: usize, n_latent: usize) -> Option<Vec<f64>> {
    let Mixing::Coregion { dims, .. } = mixing else {
        return None;
    };
    let b = mixing.matrix();
    let mut out = vec![0.0; rows * n_latent];
    for (j, &d) in dims.iter().enumerate() {
        for (i, &c) in dims.iter().enumerate() {
            let column = &h[c * rows..(c + 1) * rows];
            axpy(b[(i, j)], column, &mut out[d * rows..(d + 1) * rows]);
        }
    }
    Some(out)
}

/// Scratch for one tile: `left[d]` holds `(H_j K(x_j, x_i))[:, d]` for the tile's rows.
pub(crate) struct Tile {
    pub(crate) left: Vec<f64>,
    pub(crate) spread: Vec<f64>,
    pub(crate) width: usize,
}

impl Tile {
    pub(crate) fn new(stack: &Stack) -> Self {
        Self {
            left: vec![0.0; stack.widest * stack.n_latent],
            spread: vec![0.0; stack.widest],
            width: stack.widest,
        }
    }

    pub(crate) fn left(&self, d: usize, len: usize) -> &[f64] {
        &self.left[d * self.width..d * self.width + len]
    }

    /// Fill `left` for column point `i` and the given row points.
    pub(crate) fn fill(
        &mut self,
        stack: &Stack,
        prior: &LatentPrior,
        kernels: &[Bound<'_>],
        i: usize,
        points: Range<usize>,
    ) {
        let rows = stack.rows_of(points.clone());
        let len = rows.len();
        for d in 0..stack.n_latent {
            self.left[d * self.width..d * self.width + len].fill(0.0);
        }
        let mut k = [0.0; TILE];
        let k = &mut k[..points.len()];
        for (t, (term, kernel)) in prior.terms().iter().zip(kernels).enumerate() {
            kernel.values(i, points.start, k);
            let spread = &mut self.spread[..len];
            dispatch(|| {
                stack.spread(points.clone(), k, spread);
                for &d in term.mixing.dims() {
                    let left = &mut self.left[d * self.width..d * self.width + len];
                    fused(spread, stack.hb(t, d, rows.clone()), left);
                }
            });
        }
    }
}

/// Kernels of all terms resolved for `rows` against `cols`.
pub(crate) fn bind<'a>(prior: &LatentPrior, rows: &'a Inputs, cols: &'a Inputs) -> Vec<Bound<'a>> {
    prior
        .terms()
        .iter()
        .map(|t| Bound::new(&t.kernel, rows, cols))
        .collect()
}

/// Covariance between `rows` and `cols` into column-major `out` with the given stride.
///
/// With `symmetric`, both stacks are the same and only the lower block triangle
/// (blocks of points `j >= i`) is written.
pub(crate) fn assemble(
    prior: &LatentPrior,
    rows: &Stack,
    cols: &Stack,
    symmetric: bool,
    out: &mut [f64],
    stride: usize,
) {
    let kernels = bind(prior, &rows.inputs, &cols.inputs);
    let mut columns = Vec::with_capacity(cols.n_points());
    let mut rest = out;
    for i in 0..cols.n_points() {
        let (head, tail) = rest.split_at_mut(stride * cols.rows_of(i..i + 1).len());
        columns.push(head);
        rest = tail;
    }
    columns.into_par_iter().enumerate().for_each_init(
        || Tile::new(rows),
        |tile, (i, out)| {
            let first = if symmetric { i } else { 0 };
            for start in (first..rows.n_points()).step_by(TILE) {
                let points = start..(start + TILE).min(rows.n_points());
                tile.fill(rows, prior, &kernels, i, points.clone());
                combine(tile, rows.rows_of(points), cols, i, out, stride);
            }
        },
    );
}

/// `out[rows, (i, b)] = Σ_d left[:, d] H_i[b, d]`.
fn combine(
    tile: &Tile,
    rows: Range<usize>,
    cols: &Stack,
    i: usize,
    out: &mut [f64],
    stride: usize,
) {
    dispatch(|| {
        for (b, s) in cols.rows_of(i..i + 1).enumerate() {
            let out = &mut out[b * stride + rows.start..b * stride + rows.end];
            out.fill(0.0);
            for d in 0..cols.n_latent {
                let h = cols.h(d, s..s + 1)[0];
                if h != 0.0 {
                    axpy(h, tile.left(d, rows.len()), out);
                }
            }
        }
    });
}

/// Prior variance of every row, `(H K(x, x) H^T)_rr`.
pub(crate) fn variances(prior: &LatentPrior, stack: &Stack) -> Vec<f64> {
    let kernels = bind(prior, &stack.inputs, &stack.inputs);
    let mut out = vec![0.0; stack.rows];
    for (t, (term, kernel)) in prior.terms().iter().zip(&kernels).enumerate() {
        for i in 0..stack.n_points() {
            let mut k = [0.0];
            kernel.values(i, i, &mut k);
            for r in stack.rows_of(i..i + 1) {
                let b: f64 = term
                    .mixing
                    .dims()
                    .iter()
                    .map(|&d| stack.hb(t, d, r..r + 1)[0] * stack.h(d, r..r + 1)[0])
                    .sum();
                out[r] += k[0] * b;
            }
        }
    }
    out
}
