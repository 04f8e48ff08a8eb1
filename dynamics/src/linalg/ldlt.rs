//! `L D Lᵀ` factorisation of a symmetric matrix, without pivoting and without branches.

use nalgebra::{SMatrix, SVector};

use crate::{Real, Scalar};

/// `M = L D Lᵀ` with `L` unit lower triangular and `D` diagonal.
///
/// Stable without pivoting for positive definite `M` (Golub & Van Loan, section 4.1),
/// the only use made of it here. No square root and no comparison, so it works for
/// dual numbers and SIMD lanes. A zero pivot makes the later results infinite or NaN;
/// [`Ldlt::is_positive_definite`] tells, for real numbers, before they are used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ldlt<T, const N: usize> {
    /// Strictly lower part of `L`; the rest is not used.
    lower: SMatrix<T, N, N>,
    /// `D`.
    pivots: [T; N],
    /// `D⁻¹`.
    inverse_pivots: [T; N],
}

impl<T: Scalar, const N: usize> Ldlt<T, N> {
    /// Factorises `m`; only its lower triangle is read.
    pub fn new(m: &SMatrix<T, N, N>) -> Self {
        let mut lower = *m;
        let mut pivots = [T::zero(); N];
        let mut inverse_pivots = [T::zero(); N];
        // Loops run over all of `0..N`, and leave or pass over what is not meant: so it is
        // plain to the compiler, for any size, that no index is out of bounds, and nothing is
        // left that could panic.
        for j in 0..N {
            // Row j so far holds L_jk D_k (k < j); divide it out while summing D_j.
            let mut pivot = lower[(j, j)];
            for k in 0..N {
                if k == j {
                    break;
                }
                let scaled = lower[(j, k)];
                let factor = scaled * inverse_pivots[k];
                pivot = (-scaled).mul_add(factor, pivot);
                lower[(j, k)] = factor;
            }
            pivots[j] = pivot;
            inverse_pivots[j] = pivot.recip();
            for i in 0..N {
                if i <= j {
                    continue;
                }
                let mut element = lower[(i, j)];
                for k in 0..N {
                    if k == j {
                        break;
                    }
                    element = (-lower[(i, k)]).mul_add(lower[(j, k)], element);
                }
                lower[(i, j)] = element;
            }
        }
        Self {
            lower,
            pivots,
            inverse_pivots,
        }
    }

    /// `D`, the pivots.
    #[inline]
    pub fn pivots(&self) -> &[T; N] {
        &self.pivots
    }

    /// `D⁻¹`, the reciprocal pivots.
    #[inline]
    pub fn inverse_pivots(&self) -> &[T; N] {
        &self.inverse_pivots
    }

    /// `L⁻¹ B`.
    #[inline]
    pub fn solve_lower<const C: usize>(&self, b: &SMatrix<T, N, C>) -> SMatrix<T, N, C> {
        let mut x = *b;
        for c in 0..C {
            for i in 0..N {
                let mut element = x[(i, c)];
                for k in 0..i {
                    element = (-self.lower[(i, k)]).mul_add(x[(k, c)], element);
                }
                x[(i, c)] = element;
            }
        }
        x
    }

    /// `L⁻ᵀ D⁻¹ B`.
    #[inline]
    pub fn solve_upper<const C: usize>(&self, b: &SMatrix<T, N, C>) -> SMatrix<T, N, C> {
        let mut x = *b;
        for c in 0..C {
            for i in (0..N).rev() {
                let mut element = x[(i, c)] * self.inverse_pivots[i];
                for k in i + 1..N {
                    element = (-self.lower[(k, i)]).mul_add(x[(k, c)], element);
                }
                x[(i, c)] = element;
            }
        }
        x
    }

    /// `M⁻¹ B`.
    #[inline]
    pub fn solve<const C: usize>(&self, b: &SMatrix<T, N, C>) -> SMatrix<T, N, C> {
        self.solve_upper(&self.solve_lower(b))
    }

    /// `M⁻¹ b` for one vector.
    #[inline]
    pub fn solve_vector(&self, b: &SVector<T, N>) -> SVector<T, N> {
        self.solve(b)
    }
}

impl<T: Real, const N: usize> Ldlt<T, N> {
    /// Whether every pivot exceeds `tolerance` times the diagonal element of `m` it
    /// came from. The ratio `D_k / M_kk` does not depend on the units of the
    /// coordinates; it is the share of the k-th direction not explained by those
    /// before it. NaN anywhere gives `false`.
    pub fn is_positive_definite(&self, m: &SMatrix<T, N, N>, tolerance: T) -> bool {
        (0..N).all(|k| {
            let pivot = self.pivots[k];
            pivot.is_finite() && pivot > T::zero() && pivot > tolerance * m[(k, k)]
        })
    }
}
