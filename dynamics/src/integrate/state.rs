//! What an integrator integrates.

use crate::Scalar;

/// A vector of numbers that an integrator can combine and measure.
pub trait StateVector<T: Scalar>: Copy {
    /// Number of components.
    const LEN: usize;

    /// Applies `f` to every pair of components.
    #[must_use]
    fn zip_map(&self, other: &Self, f: impl FnMut(T, T) -> T) -> Self;

    /// Runs over the pairs of components in order, carrying a value.
    fn zip_fold<A>(&self, other: &Self, initial: A, f: impl FnMut(A, T, T) -> A) -> A;

    /// `self + s · direction`.
    #[inline]
    #[must_use]
    fn add_scaled(&self, s: T, direction: &Self) -> Self {
        self.zip_map(direction, |y, d| d.mul_add(s, y))
    }

    /// `s · self`.
    #[inline]
    #[must_use]
    fn scaled(&self, s: T) -> Self {
        self.zip_map(self, |y, _| s * y)
    }
}

impl<T: Scalar, const K: usize> StateVector<T> for [T; K] {
    const LEN: usize = K;

    #[inline]
    fn zip_map(&self, other: &Self, mut f: impl FnMut(T, T) -> T) -> Self {
        core::array::from_fn(|k| f(self[k], other[k]))
    }

    #[inline]
    fn zip_fold<A>(&self, other: &Self, initial: A, mut f: impl FnMut(A, T, T) -> A) -> A {
        self.iter()
            .zip(other)
            .fold(initial, |acc, (&x, &y)| f(acc, x, y))
    }
}

/// State of a mechanical system, or its rate `(dq/dt, a, dz/dt)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T, const N: usize, const Z: usize, const Q: usize = N> {
    /// Positions `q`.
    pub q: [T; Q],
    /// Velocities `v`.
    pub v: [T; N],
    /// Internal states `z`.
    pub z: [T; Z],
}

impl<T: Scalar, const N: usize, const Z: usize, const Q: usize> StateVector<T>
    for State<T, N, Z, Q>
{
    const LEN: usize = Q + N + Z;

    #[inline]
    fn zip_map(&self, other: &Self, mut f: impl FnMut(T, T) -> T) -> Self {
        Self {
            q: self.q.zip_map(&other.q, &mut f),
            v: self.v.zip_map(&other.v, &mut f),
            z: self.z.zip_map(&other.z, &mut f),
        }
    }

    #[inline]
    fn zip_fold<A>(&self, other: &Self, initial: A, mut f: impl FnMut(A, T, T) -> A) -> A {
        let acc = self.q.zip_fold(&other.q, initial, &mut f);
        let acc = self.v.zip_fold(&other.v, acc, &mut f);
        self.z.zip_fold(&other.z, acc, &mut f)
    }
}
