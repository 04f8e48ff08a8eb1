//! Sums and products of fixed-size matrices (vectors are one-column matrices).

use nalgebra::{SMatrix, SVector};

use crate::Scalar;

/// `a + b`.
#[inline]
pub fn add<T: Scalar, const R: usize, const C: usize>(
    a: &SMatrix<T, R, C>,
    b: &SMatrix<T, R, C>,
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| a[(i, j)] + b[(i, j)])
}

/// `a − b`.
#[inline]
pub fn sub<T: Scalar, const R: usize, const C: usize>(
    a: &SMatrix<T, R, C>,
    b: &SMatrix<T, R, C>,
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| a[(i, j)] - b[(i, j)])
}

/// `s a`.
#[inline]
pub fn scale<T: Scalar, const R: usize, const C: usize>(
    s: T,
    a: &SMatrix<T, R, C>,
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| s * a[(i, j)])
}

/// `a b`.
#[inline]
pub fn mul<T: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, R, K>,
    b: &SMatrix<T, K, C>,
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| sum(K, |k| (a[(i, k)], b[(k, j)])))
}

/// `aᵀ b`.
#[inline]
pub fn transpose_mul<T: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, K, R>,
    b: &SMatrix<T, K, C>,
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| sum(K, |k| (a[(k, i)], b[(k, j)])))
}

/// `a bᵀ`.
#[inline]
pub fn mul_transpose<T: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, R, K>,
    b: &SMatrix<T, C, K>,
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| sum(K, |k| (a[(i, k)], b[(j, k)])))
}

/// `aᵀ diag(d) a`, symmetric to the last bit.
#[inline]
pub fn gram<T: Scalar, const K: usize, const C: usize>(
    a: &SMatrix<T, K, C>,
    d: &[T; K],
) -> SMatrix<T, C, C> {
    let mut result = SMatrix::from_fn(|_, _| T::zero());
    for j in 0..C {
        let scaled: [T; K] = core::array::from_fn(|k| a[(k, j)] * d[k]);
        for i in j..C {
            let element = sum(K, |k| (scaled[k], a[(k, i)]));
            result[(i, j)] = element;
            result[(j, i)] = element;
        }
    }
    result
}

/// `xᵀ y`.
#[inline]
pub fn dot<T: Scalar, const N: usize>(x: &SVector<T, N>, y: &SVector<T, N>) -> T {
    sum(N, |k| (x[k], y[k]))
}

/// Sum of the squares of all elements.
#[inline]
pub fn norm_squared<T: Scalar, const R: usize, const C: usize>(a: &SMatrix<T, R, C>) -> T {
    let mut total = T::zero();
    for j in 0..C {
        for i in 0..R {
            total = a[(i, j)].mul_add(a[(i, j)], total);
        }
    }
    total
}

/// `Σ_k x_k y_k` for `k < n`.
#[inline]
fn sum<T: Scalar>(n: usize, term: impl Fn(usize) -> (T, T)) -> T {
    let mut total = T::zero();
    for k in 0..n {
        let (x, y) = term(k);
        total = x.mul_add(y, total);
    }
    total
}
