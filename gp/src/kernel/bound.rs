//! A kernel resolved against two sets of points, ready for its inner loops.

use super::Kernel;
use super::forms::{Form, Leaf};
use crate::inputs::Inputs;
use crate::simd::TILE;

/// A kernel with its input columns looked up: rows from one set of points,
/// columns from another.
pub(crate) enum Bound<'a> {
    Leaf(Leaf<'a>),
    Sum(Vec<Bound<'a>>),
    Product(Vec<Bound<'a>>),
    Scaled {
        factor: f64,
        inner: Box<Bound<'a>>,
        at: usize,
    },
}

impl<'a> Bound<'a> {
    /// Resolve `kernel` for `k(rows_i, cols_j)`. The shapes were checked before.
    pub(crate) fn new(kernel: &Kernel, rows: &'a Inputs, cols: &'a Inputs) -> Self {
        let all: Vec<usize> = (0..rows.dims()).collect();
        let mut at = 0;
        Self::build(kernel, rows, cols, &all, &mut at)
    }

    fn build(
        kernel: &Kernel,
        rows: &'a Inputs,
        cols: &'a Inputs,
        dims: &[usize],
        at: &mut usize,
    ) -> Self {
        let first = *at;
        let mut leaf = |form: Form, count: usize| {
            *at += count;
            Self::Leaf(Leaf {
                form,
                rows: dims.iter().map(|&d| rows.dim(d)).collect(),
                cols: dims.iter().map(|&d| cols.dim(d)).collect(),
                at: first,
            })
        };
        let exp = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| v.exp()).collect() };
        let inv = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| (-v).exp()).collect() };
        match kernel {
            Kernel::SquaredExponential(a) => leaf(
                Form::SquaredExponential {
                    inverse_lengths: inv(&a.log_lengths),
                    variance: a.log_variance.exp(),
                },
                a.log_lengths.len() + 1,
            ),
            Kernel::Matern32(a) => leaf(
                Form::Matern32 {
                    inverse_lengths: inv(&a.log_lengths),
                    variance: a.log_variance.exp(),
                },
                a.log_lengths.len() + 1,
            ),
            Kernel::Matern52(a) => leaf(
                Form::Matern52 {
                    inverse_lengths: inv(&a.log_lengths),
                    variance: a.log_variance.exp(),
                },
                a.log_lengths.len() + 1,
            ),
            Kernel::Linear { log_variances } => leaf(
                Form::Linear {
                    variances: exp(log_variances),
                },
                log_variances.len(),
            ),
            Kernel::Bias { log_variance } => leaf(
                Form::Bias {
                    variance: log_variance.exp(),
                },
                1,
            ),
            Kernel::White { log_variance } => leaf(
                Form::White {
                    variance: log_variance.exp(),
                },
                1,
            ),
            Kernel::Periodic(c) => leaf(
                Form::Periodic {
                    frequencies: inv(&c.log_periods)
                        .iter()
                        .map(|f| f * std::f64::consts::PI)
                        .collect(),
                    inverse_lengths: inv(&c.log_lengths),
                    variance: c.log_variance.exp(),
                },
                2 * c.log_periods.len() + 1,
            ),
            Kernel::Sum(parts) => Self::Sum(
                parts
                    .iter()
                    .map(|p| Self::build(p, rows, cols, dims, at))
                    .collect(),
            ),
            Kernel::Product(parts) => Self::Product(
                parts
                    .iter()
                    .map(|p| Self::build(p, rows, cols, dims, at))
                    .collect(),
            ),
            Kernel::Scaled { log_factor, inner } => {
                *at += 1;
                let inner = Box::new(Self::build(inner, rows, cols, dims, at));
                Self::Scaled {
                    factor: log_factor.exp(),
                    inner,
                    at: first,
                }
            }
            Kernel::On { dims: seen, inner } => {
                let dims: Vec<usize> = seen.iter().map(|&d| dims[d]).collect();
                Self::build(inner, rows, cols, &dims, at)
            }
        }
    }

    /// `out[i] = k(rows[start + i], cols[col])`, at most [`TILE`] entries.
    pub(crate) fn values(&self, col: usize, start: usize, out: &mut [f64]) {
        match self {
            Self::Leaf(leaf) => leaf.values(col, start, out),
            Self::Sum(parts) => {
                self.combine(parts, col, start, out, |o, t| *o += t);
            }
            Self::Product(parts) => {
                self.combine(parts, col, start, out, |o, t| *o *= t);
            }
            Self::Scaled { factor, inner, .. } => {
                inner.values(col, start, out);
                out.iter_mut().for_each(|o| *o *= factor);
            }
        }
    }

    fn combine(
        &self,
        parts: &[Bound<'a>],
        col: usize,
        start: usize,
        out: &mut [f64],
        join: impl Fn(&mut f64, f64),
    ) {
        let mut tile = [0.0; TILE];
        for (n, part) in parts.iter().enumerate() {
            if n == 0 {
                part.values(col, start, out);
                continue;
            }
            let tile = &mut tile[..out.len()];
            part.values(col, start, tile);
            out.iter_mut().zip(&*tile).for_each(|(o, &t)| join(o, t));
        }
    }

    /// `grad[η] += Σ_i w[i] ∂k(rows[start + i], cols[col])/∂η`.
    pub(crate) fn accumulate(&self, col: usize, start: usize, w: &[f64], grad: &mut [f64]) {
        match self {
            Self::Leaf(leaf) => leaf.accumulate(col, start, w, grad),
            Self::Sum(parts) => parts.iter().for_each(|p| p.accumulate(col, start, w, grad)),
            Self::Product(parts) => {
                for (n, part) in parts.iter().enumerate() {
                    let (mut weight, mut tile) = ([0.0; TILE], [0.0; TILE]);
                    let (weight, tile) = (&mut weight[..w.len()], &mut tile[..w.len()]);
                    weight.copy_from_slice(w);
                    for (m, other) in parts.iter().enumerate() {
                        if m != n {
                            other.values(col, start, tile);
                            weight.iter_mut().zip(&*tile).for_each(|(w, t)| *w *= t);
                        }
                    }
                    part.accumulate(col, start, weight, grad);
                }
            }
            Self::Scaled { factor, inner, at } => {
                let (mut weight, mut tile) = ([0.0; TILE], [0.0; TILE]);
                let (weight, tile) = (&mut weight[..w.len()], &mut tile[..w.len()]);
                inner.values(col, start, tile);
                for (i, w) in w.iter().enumerate() {
                    weight[i] = w * factor;
                    grad[*at] += weight[i] * tile[i];
                }
                inner.accumulate(col, start, weight, grad);
            }
        }
    }
}
