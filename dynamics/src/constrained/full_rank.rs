//! Positive definite `M`, full row rank `A`: no decisions, any scalar.

use nalgebra::{SMatrix, SVector};

use super::{Projectors, Solution};
use crate::linalg::{Ldlt, add, gram, identity, mul, mul_transpose, sub, transpose_mul};
use crate::{Real, Scalar};

/// Factorised `K = [[M, Aᵀ], [A, 0]]` for positive definite `M` and `A` of full row rank.
///
/// `M = L D Lᵀ`, `W = L⁻¹ Aᵀ`, `G = A M⁻¹ Aᵀ = Wᵀ D⁻¹ W`, again by `L D Lᵀ`. Straight
/// line, without a comparison. A row of `A` that is zero, with its entry of `b`, is a
/// constraint that is switched off. Outside its demands the results are infinite or NaN
/// (or inaccurate close by); use [`RankRevealing`](super::RankRevealing) there.
#[derive(Clone, Copy, Debug)]
pub struct FullRank<T, const N: usize, const M: usize> {
    constraint: SMatrix<T, M, N>,
    mass: Ldlt<T, N>,
    /// `W = L⁻¹ Aᵀ`.
    w: SMatrix<T, N, M>,
    gram: SMatrix<T, M, M>,
    gram_factor: Ldlt<T, M>,
}

impl<T: Scalar, const N: usize, const M: usize> FullRank<T, N, M> {
    /// Factorises. `mass` is `M` (lower triangle read), `a` is `A`.
    pub fn new(mass: &SMatrix<T, N, N>, a: &SMatrix<T, M, N>) -> Self {
        let mass = Ldlt::new(mass);
        let w = mass.solve_lower(&SMatrix::from_fn(|i, j| a[(j, i)]));
        let mut gram = gram(&w, mass.inverse_pivots());
        // A row of zeros is a constraint that is switched off: its multiplier is 0.
        for row in 0..M {
            let size = (0..N).fold(T::zero(), |sum, column| sum + a[(row, column)].abs());
            let there = size.sign();
            gram[(row, row)] += T::one() - there;
        }
        Self {
            constraint: *a,
            mass,
            w,
            gram,
            gram_factor: Ldlt::new(&gram),
        }
    }

    /// `a` and `λ` of `M a = Qbar + Aᵀ λ`, `A a = b`.
    #[inline]
    pub fn solve(&self, force: &SVector<T, N>, b: &SVector<T, M>) -> Solution<T, N, M> {
        let (a, lambda) = self.solve_kkt(force, b);
        Solution::new(&self.constraint, a, lambda)
    }

    /// `(x, y)` of `M x − Aᵀ y = r`, `A x = s`, for `C` right-hand sides at once.
    #[inline]
    pub fn solve_kkt<const C: usize>(
        &self,
        r: &SMatrix<T, N, C>,
        s: &SMatrix<T, M, C>,
    ) -> (SMatrix<T, N, C>, SMatrix<T, M, C>) {
        let half = self.mass.solve_lower(r);
        let inverse_pivots = self.mass.inverse_pivots();
        let scaled = SMatrix::<T, N, C>::from_fn(|i, c| inverse_pivots[i] * half[(i, c)]);
        let unconstrained = transpose_mul(&self.w, &scaled);
        let y = self.gram_factor.solve(&sub(s, &unconstrained));
        let x = self.mass.solve_upper(&add(&half, &mul(&self.w, &y)));
        (x, y)
    }

    /// Derivatives `(∂a, ∂λ)` with respect to `C` variables from the residuals'
    /// derivatives at fixed `a`, `λ`: `dr = ∂(M a − Qbar − Aᵀ λ)`, `ds = ∂(A a − b)`
    /// (implicit differentiation of `K [a; −λ] = [Qbar; b]`).
    pub fn derivatives<const C: usize>(
        &self,
        dr: &SMatrix<T, N, C>,
        ds: &SMatrix<T, M, C>,
    ) -> (SMatrix<T, N, C>, SMatrix<T, M, C>) {
        self.solve_kkt(&dr.map(|e| -e), &ds.map(|e| -e))
    }

    /// The maps `L, T, P, S, G⁻¹`.
    pub fn projectors(&self) -> Projectors<T, N, M> {
        let y = self.mass.solve_upper(&self.w);
        let g_pinv = self.gram_factor.solve(&identity::<T, M>());
        let l = mul(&y, &g_pinv);
        let t = sub(&identity(), &mul(&l, &self.constraint));
        let inverse_mass = self.mass.solve(&identity::<T, N>());
        let p = symmetric(&sub(&inverse_mass, &mul_transpose(&l, &y)));
        Projectors {
            l,
            t,
            p,
            s: t.transpose(),
            g_pinv: symmetric(&g_pinv),
        }
    }
}

impl<T: Real, const N: usize, const M: usize> FullRank<T, N, M> {
    /// Whether the pivots of `M` (which must be the factorised one) and of `G` are
    /// above ε^(3/8) of their diagonal elements (1.3e-6 for `f64`, 2.5e-3 for `f32`), so
    /// that this path loses at most about a third of the digits to each; and whether no row
    /// of `A` is zero, which may be a contradiction.
    pub fn is_well_conditioned(&self, mass: &SMatrix<T, N, N>) -> bool {
        // ε^(1/4) ε^(1/8): square roots only, `powf` would cost more than the solve.
        let quarter = T::epsilon().sqrt().sqrt();
        let threshold = quarter * quarter.sqrt();
        let empty = |row: usize| (0..N).all(|column| self.constraint[(row, column)] == T::zero());
        !(0..M).any(empty)
            && self.mass.is_positive_definite(mass, threshold)
            && self.gram_factor.is_positive_definite(&self.gram, threshold)
    }
}

/// `(m + mᵀ)/2`.
pub(super) fn symmetric<T: Scalar, const K: usize>(m: &SMatrix<T, K, K>) -> SMatrix<T, K, K> {
    let half = T::from_f64(0.5);
    SMatrix::from_fn(|i, j| half * (m[(i, j)] + m[(j, i)]))
}
