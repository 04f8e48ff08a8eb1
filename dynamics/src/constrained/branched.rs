//! Positive definite `M` with the zeros of a tree, full row rank `A`: for many coordinates.

use crate::Scalar;
use crate::linalg::{Ldlt, Ltdl, from_rows, to_rows};

/// Factorised `K = [[M, Aᵀ], [A, 0]]` of a machine whose coordinates carry each other as in a
/// tree; what generated code of many coordinates solves with.
///
/// `M = Lᵀ D L` by [`Ltdl`], `Y = M⁻¹ Aᵀ`, `G = A Y = A M⁻¹ Aᵀ`. Demands are those of
/// [`FullRank`](super::FullRank), and as there nothing is checked; matrices are arrays of rows.
///
/// ```
/// use dynamics::constrained::Branched;
/// use dynamics::linalg::ancestors;
///
/// // A mass of 2 kg under 6 N, held.
/// static CARRIES: [[bool; 1]; 1] = ancestors([0]);
/// let factors = Branched::new(&[[2.0]], &[[1.0]], &CARRIES);
/// assert_eq!(factors.motion(&[6.0], &[0.0]), ([0.0], [-6.0]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branched<T: 'static, const N: usize, const M: usize> {
    mass: Ltdl<T, N>,
    /// `A`
    rows: [[T; N]; M],
    /// `Y = M⁻¹ Aᵀ`
    response: [[T; M]; N],
    gram: Ldlt<T, M>,
}

impl<T: Scalar, const N: usize, const M: usize> Branched<T, N, M> {
    /// Factorises. `mass` is `M` (lower triangle read), `rows` is `A`, `ancestors` says
    /// [who carries whom](crate::linalg::ancestors).
    pub fn new(mass: &[[T; N]; N], rows: &[[T; N]; M], ancestors: &'static [[bool; N]; N]) -> Self {
        let mass = Ltdl::new(mass, ancestors);
        let mut response = core::array::from_fn(|i| core::array::from_fn(|r| rows[r][i]));
        mass.solve(&mut response);
        Self {
            mass,
            rows: *rows,
            response,
            gram: Ldlt::new(&from_rows(&times(rows, &response))),
        }
    }

    /// `a` and `λ` of `M a = Qbar + Aᵀ λ`, `A a = b`.
    pub fn motion(&self, force: &[T; N], b: &[T; M]) -> ([T; N], [T; M]) {
        let (a, lambda) = self.solve(force.map(|x| [x]), b.map(|x| [x]));
        (a.map(|[x]| x), lambda.map(|[x]| x))
    }

    /// Derivatives `(∂a, ∂λ)` with respect to `C` variables from the residuals' derivatives at
    /// fixed `a`, `λ`: `dr = ∂(M a − Qbar − Aᵀ λ)`, `ds = ∂(A a − b)`.
    pub fn derivatives<const C: usize>(
        &self,
        dr: &[[T; C]; N],
        ds: &[[T; C]; M],
    ) -> ([[T; C]; N], [[T; C]; M]) {
        self.solve(dr.map(|row| row.map(|x| -x)), ds.map(|row| row.map(|x| -x)))
    }

    /// `(x, y)` of `M x − Aᵀ y = r`, `A x = s`.
    fn solve<const C: usize>(&self, r: [[T; C]; N], s: [[T; C]; M]) -> ([[T; C]; N], [[T; C]; M]) {
        let mut x = r;
        self.mass.solve(&mut x);
        let free = times(&self.rows, &x);
        let missing: [[T; C]; M] =
            core::array::from_fn(|i| core::array::from_fn(|c| s[i][c] - free[i][c]));
        let y = to_rows(&self.gram.solve(&from_rows(&missing)));
        let pushed = times(&self.response, &y);
        for (x, pushed) in x.iter_mut().zip(&pushed) {
            for (x, &pushed) in x.iter_mut().zip(pushed) {
                *x += pushed;
            }
        }
        (x, y)
    }
}

/// `A X`
fn times<T: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &[[T; K]; R],
    x: &[[T; C]; K],
) -> [[T; C]; R] {
    let mut product = [[T::zero(); C]; R];
    for (row, sum) in a.iter().zip(&mut product) {
        for (&factor, x) in row.iter().zip(x) {
            for (sum, &x) in sum.iter_mut().zip(x) {
                *sum = factor.mul_add(x, *sum);
            }
        }
    }
    product
}
