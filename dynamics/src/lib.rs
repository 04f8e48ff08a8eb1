//! Runtime of generated robot dynamics.
//!
//! What generated code and its users share: the number type ([`Scalar`], with dual
//! numbers in [`Dual`] and SIMD lanes behind the feature `simd`), the trait a model
//! implements ([`System`]), the constrained equation of motion ([`constrained`]),
//! integrators ([`integrate`]) and both together ([`Simulation`]), also under sampled feedback
//! ([`Control`]).
//!
//! `no_std`, no allocation, no unsafe code; every failure is a value. SI units and
//! radians; `q, v, a` are coordinates, velocities, accelerations.
//!
//! # Example
//!
//! A pendulum in Cartesian coordinates: a point mass at `(x, y)` and a rod that keeps
//! `(x² + y² − l²)/2 = 0`.
//!
//! ```
//! use dynamics::constrained::Baumgarte;
//! use dynamics::integrate::{DormandPrince, State};
//! use dynamics::{Constraint, Point, Scalar, Simulation, System};
//! use nalgebra::{SMatrix, SVector};
//!
//! struct Pendulum {
//!     mass: f64,    // kg
//!     length: f64,  // m
//!     gravity: f64, // m/s²
//! }
//!
//! // Two coordinates, no input, one constraint, no internal state.
//! impl<T: Scalar> System<T, 2, 0, 1, 0> for Pendulum {
//!     fn mass_matrix(&self, _: &Point<T, 2, 0, 0>) -> SMatrix<T, 2, 2> {
//!         let (m, o) = (T::from_f64(self.mass), T::zero());
//!         SMatrix::from([[m, o], [o, m]])
//!     }
//!     fn force(&self, _: &Point<T, 2, 0, 0>) -> SVector<T, 2> {
//!         SVector::from([T::zero(), T::from_f64(-self.mass * self.gravity)])
//!     }
//!     fn constraint(&self, p: &Point<T, 2, 0, 0>) -> Constraint<T, 2, 1> {
//!         let ([x, y], [vx, vy]) = (p.q, p.v);
//!         let (half, l) = (T::from_f64(0.5), T::from_f64(self.length));
//!         Constraint {
//!             a: SMatrix::from([[x], [y]]),
//!             b: SVector::from([-(vx * vx + vy * vy)]),
//!             c: SVector::from([half * (x * x + y * y - l * l)]),
//!             c_dot: SVector::from([x * vx + y * vy]),
//!             holonomic: [true],
//!         }
//!     }
//!     fn state_rate(&self, _: &Point<T, 2, 0, 0>) -> [T; 0] {
//!         []
//!     }
//! }
//!
//! let pendulum = Pendulum { mass: 1.0, length: 1.0, gravity: 9.81 };
//! let energy = |s: &State<f64, 2, 0>| 0.5 * (s.v[0].powi(2) + s.v[1].powi(2)) + 9.81 * s.q[1];
//!
//! let simulation = Simulation::new(&pendulum).with_baumgarte(Baumgarte::critical(10.0));
//! let solver = DormandPrince { relative: 1e-11, absolute: 1e-11, ..Default::default() };
//! let start = State { q: [1.0, 0.0], v: [0.0, 0.0], z: [] };
//!
//! let (end, _) = simulation
//!     .sample(&solver, (0.0, &start), (2.0, 0.1), |_, _| [], |_t, s| {
//!         let [x, y] = s.q;
//!         assert!((f64::hypot(x, y) - 1.0).abs() < 1e-9); // the rod holds
//!     })
//!     .unwrap();
//! assert!((energy(&end) - energy(&start)).abs() < 1e-8);
//!
//! // In the hanging position the rod carries the weight: λ y = m g.
//! let hanging = State { q: [0.0, -1.0], v: [0.0, 0.0], z: [] };
//! let x = simulation.acceleration(0.0, &hanging, []).unwrap();
//! assert!((x.constraint_force[1] - 9.81).abs() < 1e-12);
//! ```
//!
//! # Features
//!
//! * `std`: elementary functions and fused multiply-add of the standard library
//!   instead of `libm`; faster on hosts. Off by default.
//! * `simd`: [`Scalar`] for `wide`'s `f64x4`, `f64x8`, `f32x8`, `f32x16`, and the module
//!   `batch` for arrays of states. Compile with `-C target-cpu=native` to use more than the
//!   baseline instructions.
//! * `derive`: `#[derive(Dynamics)]`, which makes a struct a [`System`] from the text of
//!   a model.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "simd")]
pub mod batch;
pub mod constrained;
mod control;
mod dual;
mod entries;
pub mod integrate;
pub mod linalg;
mod pose;
mod scalar;
mod sensitivity;
mod simulate;
mod system;

pub use control::Control;
pub use dual::Dual;
#[cfg(feature = "derive")]
pub use dynamics_macros::Dynamics;
pub use entries::Entries;
pub use pose::{Pose, moved, position_rate};
pub use scalar::{Real, Scalar};
pub use sensitivity::{
    Differentiable, MotionDerivatives, ParameterDerivatives, ResidualDerivatives,
    motion_by_parameters, motion_derivatives, motion_derivatives_full_rank,
};
pub use simulate::{Simulation, acceleration, acceleration_full_rank};
pub use system::{Constraint, Equation, Point, System};

/// The linear algebra types in [`System`]'s signatures.
pub use nalgebra;

#[cfg(test)]
extern crate std;

/// Property tests draw the same cases every time.
#[cfg(test)]
fn property_tests() -> proptest::test_runner::Config {
    use proptest::test_runner::{Config, RngSeed};
    Config {
        rng_seed: RngSeed::Fixed(2024),
        failure_persistence: None,
        ..Config::default()
    }
}
