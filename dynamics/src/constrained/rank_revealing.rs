//! Any rank of `A`, singular `M`: decisions with a documented tolerance.

use nalgebra::{SMatrix, SVector};

use super::error::finite;
use super::full_rank::symmetric;
use super::{Projectors, Quantity, Solution, SolveError, Tolerance};
use crate::Real;
use crate::linalg::{Ldlt, Svd, add, gram, identity, mul, mul_transpose, sub, transpose_mul};

/// Factorised `K = [[M, Aᵀ], [A, 0]]` for any rank `r` of `A` and positive
/// semidefinite `M` with `rank [M; A] = n` (thesis 3.49–3.54).
///
/// From the singular value decomposition `A = C F` with `F` (r×n) of orthonormal rows:
/// `A a = b` is `F a = C⁺ b`, a problem of full row rank and no worse conditioned than
/// `M`. It is solved with `M` or, where `M` is singular, with `M + α² Fᵀ F`
/// (`α² = tr M / n`; `a` does not depend on it). Then `λ = (C⁺)ᵀ μ` is the shortest of
/// all multipliers with the same constraint force, the one the Moore–Penrose inverse
/// gives.
///
/// Rows of `F` beyond the rank are zero and decoupled by a unit on the diagonal of
/// their Gram matrix, so that sizes stay fixed.
#[derive(Clone, Copy, Debug)]
pub struct RankRevealing<T, const N: usize, const M: usize> {
    constraint: SMatrix<T, M, N>,
    rank: usize,
    /// `C⁺ = Σ_r⁻¹ V_rᵀ`, rows beyond the rank zero.
    c_pinv: SMatrix<T, M, M>,
    /// `V_r`, columns beyond the rank zero: spans `R(A)`.
    range: SMatrix<T, M, M>,
    /// `F`.
    f: SMatrix<T, M, N>,
    /// `M + α² Fᵀ F`.
    mass: Ldlt<T, N>,
    alpha_squared: T,
    /// `W = L⁻¹ Fᵀ`.
    w: SMatrix<T, N, M>,
    gram: Ldlt<T, M>,
    consistency: T,
}

impl<T: Real, const N: usize, const M: usize> RankRevealing<T, N, M> {
    /// Factorises. `mass` is `M`, `a` is `A`.
    ///
    /// # Errors
    ///
    /// [`SolveError::NotFinite`], [`SolveError::UnsymmetricMass`],
    /// [`SolveError::IndefiniteMass`], and [`SolveError::Undetermined`] where
    /// `rank [M; A] < n`.
    pub fn new(
        mass: &SMatrix<T, N, N>,
        a: &SMatrix<T, M, N>,
        tolerance: &Tolerance<T>,
    ) -> Result<Self, SolveError> {
        check_symmetric(mass, tolerance)?;
        check_semidefinite(mass, tolerance)?;
        finite(Quantity::Constraint, a)?;
        let svd = Svd::new(&a.transpose());
        let rank = rank(a, tolerance.rank);
        let active = |k: usize| k < rank && svd.sigma[k] > T::zero();
        let range = SMatrix::from_fn(|i, k| if active(k) { svd.v[(i, k)] } else { T::zero() });
        let c_pinv = SMatrix::from_fn(|k, i| {
            if active(k) {
                svd.v[(i, k)] / svd.sigma[k]
            } else {
                T::zero()
            }
        });
        let f = SMatrix::from_fn(|k, j| if active(k) { svd.u[(j, k)] } else { T::zero() });
        let (factor, alpha_squared) = factor_mass(mass, &f, tolerance)?;
        let w = factor.solve_lower(&f.transpose());
        let mut gram = gram(&w, factor.inverse_pivots());
        for k in (0..M).filter(|&k| !active(k)) {
            gram[(k, k)] = T::one();
        }
        let gram = Ldlt::new(&gram);
        let (constraint, consistency, mass) = (*a, tolerance.consistency, factor);
        Ok(Self {
            constraint,
            rank,
            c_pinv,
            range,
            f,
            mass,
            alpha_squared,
            w,
            gram,
            consistency,
        })
    }

    /// Numerical rank of `A`.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Whether `M` was singular, so that [3.49] was used.
    pub fn mass_is_singular(&self) -> bool {
        self.alpha_squared > T::zero()
    }

    /// `a` and `λ` of `M a = Qbar + Aᵀ λ`, `A a = b`.
    ///
    /// # Errors
    ///
    /// [`SolveError::NotFinite`], and [`SolveError::Inconsistent`] where `b` is outside
    /// the range of `A`.
    pub fn solve(
        &self,
        force: &SVector<T, N>,
        b: &SVector<T, M>,
    ) -> Result<Solution<T, N, M>, SolveError> {
        finite(Quantity::Force, force)?;
        finite(Quantity::ConstraintRate, b)?;
        self.check_consistent(b)?;
        let (a, lambda) = self.solve_kkt(force, b);
        finite(Quantity::Acceleration, &a)?;
        finite(Quantity::Multiplier, &lambda)?;
        Ok(Solution::new(&self.constraint, a, lambda))
    }

    /// `(x, y)` of `M x − Aᵀ y = r`, `A x = s` for `C` right-hand sides at once; of `s`
    /// only the part in `R(A)` counts, and `y` is the shortest.
    pub fn solve_kkt<const C: usize>(
        &self,
        r: &SMatrix<T, N, C>,
        s: &SMatrix<T, M, C>,
    ) -> (SMatrix<T, N, C>, SMatrix<T, M, C>) {
        let beta = mul(&self.c_pinv, s);
        let half = self.mass.solve_lower(r);
        let inverse_pivots = self.mass.inverse_pivots();
        let scaled = SMatrix::<T, N, C>::from_fn(|i, c| inverse_pivots[i] * half[(i, c)]);
        let mu = self
            .gram
            .solve(&sub(&beta, &transpose_mul(&self.w, &scaled)));
        let x = self.mass.solve_upper(&add(&half, &mul(&self.w, &mu)));
        // (M + α² Fᵀ F) x = r + Fᵀ μ and F x = β give M x = r + Fᵀ (μ − α² β).
        let mu = SMatrix::from_fn(|k, c| mu[(k, c)] - self.alpha_squared * beta[(k, c)]);
        (x, transpose_mul(&self.c_pinv, &mu))
    }

    /// Derivatives `(∂a, ∂λ)`, as [`FullRank::derivatives`](super::FullRank::derivatives). With redundant rows they
    /// are those along which the rank stays: of `ds` only the part in `R(A)` counts,
    /// `∂a` and `∂(Aᵀλ)` are exact and `∂λ` is the shortest of those that fit.
    pub fn derivatives<const C: usize>(
        &self,
        dr: &SMatrix<T, N, C>,
        ds: &SMatrix<T, M, C>,
    ) -> (SMatrix<T, N, C>, SMatrix<T, M, C>) {
        self.solve_kkt(&dr.map(|e| -e), &ds.map(|e| -e))
    }

    /// The maps `L, T, P, S, G⁺`.
    pub fn projectors(&self) -> Projectors<T, N, M> {
        let y = self.mass.solve_upper(&self.w);
        let gram_inverse = self.gram.solve(&identity::<T, M>());
        let l_f = mul(&y, &gram_inverse);
        let l = mul(&l_f, &self.c_pinv);
        let t = sub(&identity(), &mul(&l_f, &self.f));
        let inverse_mass = self.mass.solve(&identity::<T, N>());
        let p = symmetric(&sub(&inverse_mass, &mul_transpose(&l_f, &y)));
        let block = SMatrix::<T, M, M>::from_fn(|i, j| {
            gram_inverse[(i, j)]
                - if i == j {
                    self.alpha_squared
                } else {
                    T::zero()
                }
        });
        let g_pinv = symmetric(&transpose_mul(&self.c_pinv, &mul(&block, &self.c_pinv)));
        Projectors {
            l,
            t,
            p,
            s: t.transpose(),
            g_pinv,
        }
    }

    /// `|b − A A⁺ b| ≤ consistency (1 + |b|)`.
    fn check_consistent(&self, b: &SVector<T, M>) -> Result<(), SolveError> {
        let inside = mul(&self.range, &transpose_mul(&self.range, b));
        let outside = sub(b, &inside);
        let limit = self.consistency * (T::one() + length(b));
        if length(&outside) <= limit {
            return Ok(());
        }
        let mut row = 0;
        let mut residual = T::zero();
        for i in 0..M {
            if outside[i].abs() > residual {
                (row, residual) = (i, outside[i].abs());
            }
        }
        let residual = residual.to_f64();
        Err(SolveError::Inconsistent {
            row,
            residual,
            rank: self.rank,
            rows: M,
        })
    }
}

/// Rank of `A` with its rows scaled to unit length.
fn rank<T: Real, const N: usize, const M: usize>(a: &SMatrix<T, M, N>, tolerance: T) -> usize {
    let unit_rows = SMatrix::<T, N, M>::from_fn(|j, i| {
        let largest = (0..N).fold(T::zero(), |m, k| m.max(a[(i, k)].abs()));
        if largest > T::zero() {
            let sum = (0..N).fold(T::zero(), |sum, k| {
                let ratio = a[(i, k)] / largest;
                sum + ratio * ratio
            });
            a[(i, j)] / largest / sum.sqrt()
        } else {
            T::zero()
        }
    });
    Svd::new(&unit_rows).rank(tolerance)
}

/// `M` or, where it is singular, `M + α² Fᵀ F`; and `α²`.
fn factor_mass<T: Real, const N: usize, const M: usize>(
    mass: &SMatrix<T, N, N>,
    f: &SMatrix<T, M, N>,
    tolerance: &Tolerance<T>,
) -> Result<(Ldlt<T, N>, T), SolveError> {
    let factor = Ldlt::new(mass);
    if factor.is_positive_definite(mass, tolerance.mass) {
        return Ok((factor, T::zero()));
    }
    let trace = (0..N).fold(T::zero(), |sum, k| sum + mass[(k, k)]);
    let mean = trace / T::from_f64(N as f64);
    let alpha_squared = if mean > T::zero() { mean } else { T::one() };
    let extended = add(mass, &gram(f, &[alpha_squared; M]));
    let factor = Ldlt::new(&extended);
    if factor.is_positive_definite(&extended, tolerance.mass) {
        return Ok((factor, alpha_squared));
    }
    let coordinate = first_bad_pivot(&factor, &extended, tolerance.mass);
    Err(SolveError::Undetermined { coordinate })
}

/// Finite and equal to its transpose.
pub(super) fn check_symmetric<T: Real, const N: usize>(
    mass: &SMatrix<T, N, N>,
    tolerance: &Tolerance<T>,
) -> Result<(), SolveError> {
    finite(Quantity::Mass, mass)?;
    let largest = mass.iter().fold(T::zero(), |m, e| m.max(e.abs()));
    let limit = tolerance.mass.sqrt() * largest;
    for column in 0..N {
        for row in column + 1..N {
            let difference = (mass[(row, column)] - mass[(column, row)]).abs();
            if difference > limit {
                let difference = difference.to_f64();
                return Err(SolveError::UnsymmetricMass {
                    row,
                    column,
                    difference,
                });
            }
        }
    }
    Ok(())
}

/// No negative eigenvalue, up to the tolerance.
fn check_semidefinite<T: Real, const N: usize>(
    mass: &SMatrix<T, N, N>,
    tolerance: &Tolerance<T>,
) -> Result<(), SolveError> {
    let largest = mass.iter().fold(T::zero(), |m, e| m.max(e.abs()));
    let mut shifted = *mass;
    for k in 0..N {
        shifted[(k, k)] += tolerance.mass * largest;
    }
    let factor = Ldlt::new(&shifted);
    if largest > T::zero() && !factor.is_positive_definite(&shifted, T::zero()) {
        let coordinate = first_bad_pivot(&factor, &shifted, T::zero());
        return Err(SolveError::IndefiniteMass { coordinate });
    }
    Ok(())
}

/// First coordinate whose pivot fails the test of `Ldlt::is_positive_definite`.
fn first_bad_pivot<T: Real, const N: usize>(
    factor: &Ldlt<T, N>,
    m: &SMatrix<T, N, N>,
    tolerance: T,
) -> usize {
    let good = |k: &usize| {
        let pivot = factor.pivots()[*k];
        pivot > T::zero() && pivot > tolerance * m[(*k, *k)]
    };
    (0..N).take_while(good).count()
}

/// Euclidean length.
fn length<T: Real, const K: usize>(x: &SVector<T, K>) -> T {
    let largest = x.iter().fold(T::zero(), |m, e| m.max(e.abs()));
    if largest > T::zero() {
        let ratios = x.map(|e| e / largest);
        largest * crate::linalg::norm_squared(&ratios).sqrt()
    } else {
        T::zero()
    }
}
