//! Small models written by hand, shared by the test files.
#![allow(dead_code, reason = "no test file uses everything")]

use dynamics::{Constraint, Point, Scalar, System};
use nalgebra::{SMatrix, SVector};

/// Gravity, m/s².
pub const GRAVITY: f64 = 9.81;

/// Point mass 1 kg at (x, y) on a rod of length 1 m; `R` copies of the rod constraint.
pub struct CartesianPendulum<const R: usize>;

impl<T: Scalar, const R: usize> System<T, 2, 0, R, 0> for CartesianPendulum<R> {
    fn mass_matrix(&self, _: &Point<T, 2, 0, 0>) -> SMatrix<T, 2, 2> {
        let (one, zero) = (T::one(), T::zero());
        SMatrix::from([[one, zero], [zero, one]])
    }
    fn force(&self, _: &Point<T, 2, 0, 0>) -> SVector<T, 2> {
        SVector::from([T::zero(), T::from_f64(-GRAVITY)])
    }
    fn constraint(&self, p: &Point<T, 2, 0, 0>) -> Constraint<T, 2, R> {
        let ([x, y], [vx, vy]) = (p.q, p.v);
        let half = T::from_f64(0.5);
        Constraint {
            a: SMatrix::from_fn(|_, j| p.q[j]),
            b: SVector::from_fn(|_, _| -(vx * vx + vy * vy)),
            c: SVector::from_fn(|_, _| half * (x * x + y * y - T::one())),
            c_dot: SVector::from_fn(|_, _| x * vx + y * vy),
            holonomic: [true; R],
        }
    }
    fn state_rate(&self, _: &Point<T, 2, 0, 0>) -> [T; 0] {
        []
    }
}

/// A mass of 1 kg that moves up and down: its weight and `U` inputs act on it.
pub struct Lift<const U: usize>;

impl<T: Scalar, const U: usize> System<T, 1, U, 0, 0> for Lift<U> {
    fn mass_matrix(&self, _: &Point<T, 1, U, 0>) -> SMatrix<T, 1, 1> {
        SMatrix::from([[T::one()]])
    }
    fn force(&self, p: &Point<T, 1, U, 0>) -> SVector<T, 1> {
        let weight = T::from_f64(-GRAVITY);
        SVector::from([p.u.iter().fold(weight, |sum, &u| sum + u)])
    }
    fn constraint(&self, _: &Point<T, 1, U, 0>) -> Constraint<T, 1, 0> {
        Constraint {
            a: SMatrix::from_fn(|_, _| T::zero()),
            b: SVector::from_fn(|_, _| T::zero()),
            c: SVector::from_fn(|_, _| T::zero()),
            c_dot: SVector::from_fn(|_, _| T::zero()),
            holonomic: [],
        }
    }
    fn state_rate(&self, _: &Point<T, 1, U, 0>) -> [T; 0] {
        []
    }
}

/// Unicycle (x, y, ψ), mass 1 kg, inertia 0.2 kg m², inputs thrust and torque; no
/// sideways motion: `−ẋ sin ψ + ẏ cos ψ = 0`. The thrust lags by 0.1 s.
pub struct Unicycle;

impl<T: Scalar> System<T, 3, 2, 1, 1> for Unicycle {
    fn mass_matrix(&self, _: &Point<T, 3, 2, 1>) -> SMatrix<T, 3, 3> {
        let diagonal = [1.0, 1.0, 0.2];
        SMatrix::from_fn(|i, j| T::from_f64(if i == j { diagonal[i] } else { 0.0 }))
    }
    fn force(&self, p: &Point<T, 3, 2, 1>) -> SVector<T, 3> {
        let (s, c) = p.q[2].sin_cos();
        SVector::from([p.z[0] * c, p.z[0] * s, p.u[1]])
    }
    fn constraint(&self, p: &Point<T, 3, 2, 1>) -> Constraint<T, 3, 1> {
        let (s, c) = p.q[2].sin_cos();
        let [vx, vy, w] = p.v;
        Constraint {
            a: SMatrix::from([[-s], [c], [T::zero()]]),
            b: SVector::from([(vx * c + vy * s) * w]),
            c: SVector::from([vy * c - vx * s]),
            c_dot: SVector::from([T::zero()]),
            holonomic: [false],
        }
    }
    fn state_rate(&self, p: &Point<T, 3, 2, 1>) -> [T; 1] {
        [(p.u[0] - p.z[0]) * T::from_f64(10.0)]
    }
}
