//! Small row-major matrices: a few coordinates and constraints, thousands of times.

use std::ops::{Add, Mul, Sub};

/// `rows × cols`, row-major.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dense {
    pub(crate) rows: usize,
    pub(crate) cols: usize,
    pub(crate) v: Vec<f64>,
}

impl Dense {
    /// From row-major entries; the length was checked by the caller.
    pub(crate) fn new(rows: usize, cols: usize, v: &[f64]) -> Self {
        debug_assert_eq!(v.len(), rows * cols);
        Self {
            rows,
            cols,
            v: v.to_vec(),
        }
    }

    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        Self {
            rows,
            cols,
            v: vec![0.0; rows * cols],
        }
    }

    pub(crate) fn identity(n: usize) -> Self {
        let mut out = Self::zeros(n, n);
        (0..n).for_each(|i| out.v[i * n + i] = 1.0);
        out
    }

    pub(crate) fn column(v: &[f64]) -> Self {
        Self::new(v.len(), 1, v)
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.v[i * self.cols + j]
    }

    pub(crate) fn t(&self) -> Self {
        let mut out = Self::zeros(self.cols, self.rows);
        for i in 0..self.rows {
            for j in 0..self.cols {
                out.v[j * self.rows + i] = self.at(i, j);
            }
        }
        out
    }

    pub(crate) fn scaled(mut self, s: f64) -> Self {
        self.v.iter_mut().for_each(|v| *v *= s);
        self
    }

    /// `self + s (M + M^T)`, `M` square.
    pub(crate) fn plus_symmetric(mut self, s: f64, m: &Self) -> Self {
        for i in 0..self.rows {
            for j in 0..self.cols {
                self.v[i * self.cols + j] += s * (m.at(i, j) + m.at(j, i));
            }
        }
        self
    }

    pub(crate) fn beside(&self, right: &Self) -> Self {
        let mut v = Vec::with_capacity(self.rows * (self.cols + right.cols));
        for i in 0..self.rows {
            v.extend_from_slice(&self.v[i * self.cols..(i + 1) * self.cols]);
            v.extend_from_slice(&right.v[i * right.cols..(i + 1) * right.cols]);
        }
        Self {
            rows: self.rows,
            cols: self.cols + right.cols,
            v,
        }
    }

    pub(crate) fn trace(&self) -> f64 {
        (0..self.rows).map(|i| self.at(i, i)).sum()
    }

    pub(crate) fn norm(&self) -> f64 {
        self.v.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    /// Inverse of a symmetric positive definite matrix by Cholesky; `None` when
    /// a pivot falls to `tolerance` times its diagonal entry or below.
    pub(crate) fn inverse_spd(&self, tolerance: f64) -> Option<Self> {
        let n = self.rows;
        let mut l = Self::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                let known: f64 = (0..j).map(|k| l.at(i, k) * l.at(j, k)).sum();
                let rest = self.at(i, j) - known;
                if i > j {
                    l.v[i * n + j] = rest / l.at(j, j);
                } else if rest > tolerance * self.at(j, j).abs() && rest > 0.0 {
                    l.v[j * n + j] = rest.sqrt();
                } else {
                    return None;
                }
            }
        }
        let mut inv = Self::zeros(n, n);
        for c in 0..n {
            for i in c..n {
                let known: f64 = (c..i).map(|k| l.at(i, k) * inv.at(k, c)).sum();
                let unit = if i == c { 1.0 } else { 0.0 };
                inv.v[i * n + c] = (unit - known) / l.at(i, i);
            }
        }
        let mut out = Self::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                let v: f64 = (i..n).map(|k| inv.at(k, i) * inv.at(k, j)).sum();
                out.v[i * n + j] = v;
                out.v[j * n + i] = v;
            }
        }
        Some(out)
    }
}

impl Mul for &Dense {
    type Output = Dense;
    fn mul(self, other: &Dense) -> Dense {
        let mut out = Dense::zeros(self.rows, other.cols);
        for i in 0..self.rows {
            let row = &mut out.v[i * other.cols..(i + 1) * other.cols];
            for k in 0..self.cols {
                let a = self.v[i * self.cols + k];
                for (o, b) in row
                    .iter_mut()
                    .zip(&other.v[k * other.cols..(k + 1) * other.cols])
                {
                    *o += a * b;
                }
            }
        }
        out
    }
}

impl Add<&Dense> for Dense {
    type Output = Dense;
    fn add(mut self, other: &Dense) -> Dense {
        self.v.iter_mut().zip(&other.v).for_each(|(a, b)| *a += b);
        self
    }
}

impl Sub<&Dense> for Dense {
    type Output = Dense;
    fn sub(mut self, other: &Dense) -> Dense {
        self.v.iter_mut().zip(&other.v).for_each(|(a, b)| *a -= b);
        self
    }
}
