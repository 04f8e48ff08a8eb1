//! Integration of `dy/dt = f(t, y)` without allocation.
//!
//! | method | order | step | for |
//! |---|---|---|---|
//! | [`rk4_step`] | 4 | fixed | real-time loops; any [`Scalar`](crate::Scalar), also dual numbers and SIMD lanes |
//! | [`symplectic_euler_step`] | 1 | fixed | long, cheap simulation of mechanical systems |
//! | [`DormandPrince`] | 5(4) | adaptive | accuracy to a tolerance, dense output |
//!
//! Where a function of the state crosses zero ([`Events`]), [`DormandPrince`] stops and goes on
//! with what the event makes of the state.
//!
//! A state is anything that is a [`StateVector`]: `[T; K]`, or [`State`] of a
//! mechanical system. The right-hand side may fail; its error is handed on.

mod control;
mod dense;
mod dormand_prince;
mod error;
mod events;
mod fixed;
mod state;

pub use dense::Segment;
pub use dormand_prince::{DormandPrince, Statistics};
pub use error::IntegrationError;
pub use events::{Direction, Events};
pub use fixed::{rk4_step, symplectic_euler_step};
pub use state::{State, StateVector};

#[cfg(test)]
mod tests;
