//! Singular value decomposition by one-sided Jacobi rotations.

use nalgebra::{SMatrix, SVector};

use super::{dot, identity};
use crate::Real;

/// Sweeps after which the iteration stops at the latest; 6 to 10 are usual.
const MAX_SWEEPS: usize = 60;

/// `B = U Σ Vᵀ` of an n×m matrix, singular values in descending order.
///
/// Hestenes' method (Demmel & Veselić 1992): columns are rotated in pairs until all
/// are orthogonal. Small singular values keep their relative accuracy under any
/// scaling of the columns, which is why the rank of a constraint Jacobian is decided
/// here. For m > n at least m − n singular values vanish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Svd<T, const N: usize, const M: usize> {
    /// Columns of unit length, orthogonal to each other; column k is zero where
    /// `sigma[k]` is.
    pub u: SMatrix<T, N, M>,
    /// Singular values, descending.
    pub sigma: [T; M],
    /// Orthogonal, columns in the order of `sigma`.
    pub v: SMatrix<T, M, M>,
}

impl<T: Real, const N: usize, const M: usize> Svd<T, N, M> {
    /// Decomposes `b`, which must be finite; a NaN stays a NaN in `sigma`.
    pub fn new(b: &SMatrix<T, N, M>) -> Self {
        // Scaled to largest element 1, so that squares cannot overflow.
        let largest = b.iter().fold(T::zero(), |m, e| m.max(e.abs()));
        let unit = if largest > T::zero() {
            largest
        } else {
            T::one()
        };
        let mut u = b.map(|e| e / unit);
        let mut v = identity::<T, M>();
        for _ in 0..MAX_SWEEPS {
            if !sweep(&mut u, &mut v) {
                break;
            }
        }
        let mut sigma = [T::zero(); M];
        for k in 0..M {
            let column = column(&u, k);
            let length = length(&column);
            if length > T::zero() {
                for i in 0..N {
                    u[(i, k)] /= length;
                }
            }
            sigma[k] = unit * length;
        }
        let mut svd = Self { u, sigma, v };
        svd.sort();
        svd
    }

    /// Number of singular values above `tolerance` times the largest.
    pub fn rank(&self, tolerance: T) -> usize {
        let Some(&largest) = self.sigma.first() else {
            return 0;
        };
        self.sigma
            .iter()
            .take_while(|&&s| s > T::zero() && s > tolerance * largest)
            .count()
    }

    /// Selection sort by descending singular value.
    fn sort(&mut self) {
        for k in 0..M {
            let mut largest = k;
            for j in k + 1..M {
                if self.sigma[j] > self.sigma[largest] {
                    largest = j;
                }
            }
            if largest != k {
                self.sigma.swap(k, largest);
                self.u.swap_columns(k, largest);
                self.v.swap_columns(k, largest);
            }
        }
    }
}

/// Rotates every pair of columns once; `true` if a rotation was still needed.
fn sweep<T: Real, const N: usize, const M: usize>(
    u: &mut SMatrix<T, N, M>,
    v: &mut SMatrix<T, M, M>,
) -> bool {
    let mut rotated = false;
    for p in 0..M {
        for q in p + 1..M {
            let x = column(u, p);
            let y = column(u, q);
            let (alpha, beta, gamma) = (dot(&x, &x), dot(&y, &y), dot(&x, &y));
            // Orthogonal to the round-off of the product: |γ| ≤ n ε √(αβ). Underflown
            // columns and NaN fail the comparison and are left alone.
            let round_off = T::epsilon() * T::from_f64(N as f64);
            if gamma.abs() > round_off * alpha.sqrt() * beta.sqrt() {
                let (c, s) = rotation(alpha, beta, gamma);
                rotate(u, p, q, c, s);
                rotate(v, p, q, c, s);
                rotated = true;
            }
        }
    }
    rotated
}

/// Column k. (nalgebra's `into_owned` goes through an iterator whose length it asserts.)
#[inline]
fn column<T: Real, const N: usize, const M: usize>(
    u: &SMatrix<T, N, M>,
    k: usize,
) -> SVector<T, N> {
    SVector::from_fn(|i, _| u[(i, k)])
}

/// Cosine and sine of the rotation that makes columns with squared lengths α, β and
/// product γ orthogonal (the smaller of the two angles).
fn rotation<T: Real>(alpha: T, beta: T, gamma: T) -> (T, T) {
    let zeta = (beta - alpha) / (gamma + gamma);
    let sign = if zeta < T::zero() {
        -T::one()
    } else {
        T::one()
    };
    let t = sign / (zeta.abs() + (T::one() + zeta * zeta).sqrt());
    let c = (T::one() + t * t).sqrt().recip();
    (c, c * t)
}

/// Columns p, q become `c p − s q`, `s p + c q`.
fn rotate<T: Real, const N: usize, const M: usize>(
    m: &mut SMatrix<T, N, M>,
    p: usize,
    q: usize,
    c: T,
    s: T,
) {
    for i in 0..N {
        let (x, y) = (m[(i, p)], m[(i, q)]);
        m[(i, p)] = c * x - s * y;
        m[(i, q)] = s * x + c * y;
    }
}

/// Euclidean length, scaled so that squares neither overflow nor underflow.
fn length<T: Real, const N: usize>(x: &SVector<T, N>) -> T {
    let largest = x.iter().fold(T::zero(), |m, e| m.max(e.abs()));
    if largest > T::zero() && largest.is_finite() {
        let sum = x.iter().fold(T::zero(), |total, &e| {
            let ratio = e / largest;
            total + ratio * ratio
        });
        largest * sum.sqrt()
    } else {
        largest
    }
}
