//! `Lᵀ D L` factorisation that keeps the zeros of a tree.

use crate::Scalar;

/// `M = Lᵀ D L` with `L` unit lower triangular and `D` diagonal, eliminated from the last row
/// to the first.
///
/// Where coordinates are numbered from the root of a tree of bodies to its leaves, `M[i][j]` is
/// zero unless one of `i` and `j` carries the other, and so is `L[i][j]`: what is zero is
/// passed over (Featherstone, *Efficient factorization of the joint-space inertia matrix for
/// branched kinematic trees*, 2005). Demands and dangers are those of [`Ldlt`](super::Ldlt).
///
/// Matrices are arrays of rows; a right-hand side of `C` columns is worked on by whole rows.
///
/// ```
/// use dynamics::linalg::{Ltdl, ancestors};
///
/// // Two leaves on one root.
/// const CARRIES: [[bool; 3]; 3] = ancestors([0, 0, 0]);
/// let m = [[4.0, 1.0, 1.0], [1.0, 2.0, 0.0], [1.0, 0.0, 2.0]];
/// let mut x = [[6.0], [3.0], [3.0]];
/// Ltdl::new(&m, &CARRIES).solve(&mut x);
/// assert_eq!(x, [[1.0], [1.0], [1.0]]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ltdl<T: 'static, const N: usize> {
    /// Strictly lower part of `L`; the rest is not used.
    lower: [[T; N]; N],
    /// `D⁻¹`.
    inverse_pivots: [T; N],
    ancestors: &'static [[bool; N]; N],
}

/// Who carries whom: entry `[k][i]` says whether `i` lies on the way from `k` to its root.
/// `parents[k]`, below `k`, is the next one on this way, and `k` itself at a root.
///
/// ```
/// let carries = dynamics::linalg::ancestors([0, 0, 1]);
/// assert_eq!(carries[2], [true, true, false]);
/// ```
pub const fn ancestors<const N: usize>(parents: [usize; N]) -> [[bool; N]; N] {
    let mut carries = [[false; N]; N];
    let mut k = 0;
    while k < N {
        let parent = parents[k];
        if parent < k {
            carries[k] = carries[parent];
            carries[k][parent] = true;
        }
        k += 1;
    }
    carries
}

// Loops run over all of `0..N` and pass over what is not meant, so that it is plain to the
// compiler, for any size, that no index is out of bounds.
impl<T: Scalar, const N: usize> Ltdl<T, N> {
    /// Factorises `m`; only its lower triangle is read, and of it what `ancestors` allow.
    pub fn new(m: &[[T; N]; N], ancestors: &'static [[bool; N]; N]) -> Self {
        let mut lower = *m;
        let mut inverse_pivots = [T::zero(); N];
        for k in (0..N).rev() {
            let inverse = lower[k][k].recip();
            inverse_pivots[k] = inverse;
            let row = lower[k];
            for i in 0..N {
                if !ancestors[k][i] {
                    continue;
                }
                let factor = row[i] * inverse;
                for j in 0..N {
                    if j > i {
                        break;
                    }
                    lower[i][j] = (-factor).mul_add(row[j], lower[i][j]);
                }
                lower[k][i] = factor;
            }
        }
        Self {
            lower,
            inverse_pivots,
            ancestors,
        }
    }

    /// `M⁻¹ X` in place of `X`.
    pub fn solve<const C: usize>(&self, x: &mut [[T; C]; N]) {
        for k in (0..N).rev() {
            let row = x[k];
            for i in 0..N {
                if self.ancestors[k][i] {
                    subtract(&mut x[i], self.lower[k][i], &row);
                }
            }
        }
        for k in 0..N {
            let mut row = x[k].map(|element| element * self.inverse_pivots[k]);
            for i in 0..N {
                if self.ancestors[k][i] {
                    subtract(&mut row, self.lower[k][i], &x[i]);
                }
            }
            x[k] = row;
        }
    }
}

/// `x − factor y` in place of `x`.
#[inline]
fn subtract<T: Scalar, const C: usize>(x: &mut [T; C], factor: T, y: &[T; C]) {
    for (x, &y) in x.iter_mut().zip(y) {
        *x = (-factor).mul_add(y, *x);
    }
}
