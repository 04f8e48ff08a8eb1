//! Small dense linear algebra over any [`Scalar`], sizes known at compile time.
//!
//! Storage is nalgebra's `SMatrix`; the operations are own, because nalgebra's need
//! number traits that dual numbers and SIMD lanes do not have. Everything lives on
//! the stack.

mod ldlt;
mod ltdl;
mod product;
mod svd;

pub use ldlt::Ldlt;
pub use ltdl::{Ltdl, ancestors};
pub use product::{add, dot, gram, mul, mul_transpose, norm_squared, scale, sub, transpose_mul};
pub use svd::Svd;

use nalgebra::SMatrix;

use crate::Scalar;

/// Matrix of the given rows: `rows[i][j]` becomes element (i, j).
///
/// ```
/// let m = dynamics::linalg::from_rows(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
/// assert_eq!(m[(1, 0)], 4.0);
/// ```
#[inline]
pub fn from_rows<T: Scalar, const R: usize, const C: usize>(
    rows: &[[T; C]; R],
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| rows[i][j])
}

/// Rows of a matrix as plain arrays.
#[inline]
pub fn to_rows<T: Scalar, const R: usize, const C: usize>(m: &SMatrix<T, R, C>) -> [[T; C]; R] {
    core::array::from_fn(|i| core::array::from_fn(|j| m[(i, j)]))
}

/// Matrix of zeros.
#[inline]
pub fn zeros<T: Scalar, const R: usize, const C: usize>() -> SMatrix<T, R, C> {
    SMatrix::from_fn(|_, _| T::zero())
}

/// Identity matrix.
#[inline]
pub fn identity<T: Scalar, const N: usize>() -> SMatrix<T, N, N> {
    SMatrix::from_fn(|i, j| if i == j { T::one() } else { T::zero() })
}

#[cfg(test)]
mod tests;
