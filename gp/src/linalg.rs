//! The few dense factorisations the evidence needs, in place, through `faer`.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{self, LltError};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::{triangular_inverse, triangular_solve};
use faer::{Accum, Auto, MatMut, MatRef, Par, Spec};

/// A square column-major buffer whose columns are kept off power-of-two strides.
#[derive(Default)]
pub(crate) struct Square {
    n: usize,
    stride: usize,
    data: Vec<f64>,
}

impl Square {
    /// Make this buffer `n × n`; the contents are arbitrary afterwards.
    pub(crate) fn resize(&mut self, n: usize) {
        self.n = n;
        self.stride = n.next_multiple_of(8);
        if self.stride.is_multiple_of(256) {
            self.stride += 8;
        }
        let len = self.stride * n;
        if self.data.len() < len {
            self.data = vec![0.0; len];
        }
    }

    pub(crate) fn n(&self) -> usize {
        self.n
    }

    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    pub(crate) fn data(&self) -> &[f64] {
        &self.data[..self.stride * self.n]
    }

    pub(crate) fn data_mut(&mut self) -> &mut [f64] {
        &mut self.data[..self.stride * self.n]
    }

    pub(crate) fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice_with_stride(self.data(), self.n, self.n, self.stride)
    }

    pub(crate) fn view_mut(&mut self) -> MatMut<'_, f64> {
        let (n, stride) = (self.n, self.stride);
        MatMut::from_column_major_slice_with_stride_mut(&mut self.data[..stride * n], n, n, stride)
    }

    /// Column `j`, all `n` rows.
    pub(crate) fn col(&self, j: usize) -> &[f64] {
        &self.data[j * self.stride..j * self.stride + self.n]
    }

    /// Lower triangle, column by column.
    pub(crate) fn lower(&self) -> Vec<f64> {
        (0..self.n)
            .flat_map(|j| &self.col(j)[j..])
            .copied()
            .collect()
    }

    /// From a lower triangle of `n (n + 1)/2` entries, column by column; zeros above.
    pub(crate) fn from_lower(n: usize, lower: &[f64]) -> Self {
        let mut out = Self::default();
        out.resize(n);
        let mut at = 0;
        for j in 0..n {
            let start = j * out.stride;
            out.data[start + j..start + n].copy_from_slice(&lower[at..at + n - j]);
            at += n - j;
        }
        out
    }

    /// Add `values[j]` to entry `(j, j)`.
    pub(crate) fn add_diagonal(&mut self, values: &[f64]) {
        for (j, v) in values.iter().enumerate() {
            self.data[j * self.stride + j] += v;
        }
    }

    /// Entry `(j, j)` for all `j`.
    pub(crate) fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.n).map(|j| self.data[j * self.stride + j])
    }
}

/// Overwrite the lower triangle of `a` by its Cholesky factor; on failure the
/// index of the offending pivot.
pub(crate) fn cholesky(a: &mut Square) -> Result<(), usize> {
    let n = a.n();
    let params: Spec<factor::LltParams, f64> = Spec::new(Auto::<f64>::auto());
    let mut memory = MemBuffer::new(factor::cholesky_in_place_scratch::<f64>(
        n,
        Par::Seq,
        params,
    ));
    let stack = MemStack::new(&mut memory);
    match factor::cholesky_in_place(a.view_mut(), Default::default(), Par::Seq, stack, params) {
        Ok(_) if a.diagonal().all(|v| v.is_finite() && v > 0.0) => Ok(()),
        Ok(_) => Err(a
            .diagonal()
            .position(|v| !(v.is_finite() && v > 0.0))
            .unwrap_or(0)),
        Err(LltError::NonPositivePivot { index }) => Err(index),
    }
}

/// `b ← C⁻¹ b` for the lower factor `C`.
pub(crate) fn solve_lower(c: MatRef<'_, f64>, b: MatMut<'_, f64>) {
    triangular_solve::solve_lower_triangular_in_place(c, b, Par::Seq);
}

/// `b ← C⁻ᵀ b` for the lower factor `C`.
pub(crate) fn solve_upper(c: MatRef<'_, f64>, b: MatMut<'_, f64>) {
    triangular_solve::solve_upper_triangular_in_place(c.transpose(), b, Par::Seq);
}

/// `b ← (C Cᵀ)⁻¹ b`.
pub(crate) fn solve_vector(c: MatRef<'_, f64>, b: &mut [f64]) {
    let n = b.len();
    solve_lower(c, MatMut::from_column_major_slice_mut(b, n, 1));
    solve_upper(c, MatMut::from_column_major_slice_mut(b, n, 1));
}

/// Lower triangle of `out` becomes `C⁻¹`; its upper triangle is left alone.
pub(crate) fn invert_lower(out: &mut Square, c: &Square) {
    triangular_inverse::invert_lower_triangular(out.view_mut(), c.view(), Par::Seq);
}

/// Lower triangle of `out` becomes `C⁻ᵀ C⁻¹ = Σ⁻¹`, given `C⁻¹`.
pub(crate) fn inverse_from_factor(out: &mut Square, c_inv: &Square) {
    matmul(
        out.view_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        c_inv.view().transpose(),
        BlockStructure::TriangularUpper,
        c_inv.view(),
        BlockStructure::TriangularLower,
        1.0,
        Par::Seq,
    );
}
