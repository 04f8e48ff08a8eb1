//! What runs on the Wheelbot's controller a hundred times a second: the tilt estimator of section 6.3
//! of the thesis and the balancing controllers of section 6.4.
//!
//! ```text
//! encoders ──▶ wheel ──────────▶ pivot ──┐
//! IMUs ──▶ imu ──▶ euler_rates ─────────▶ estimator ──▶ balance ──▶ currents
//!               └─▶ gravity, sphere ─────┘
//! ```
//!
//! [`Firmware::tick`] is the whole of it; [`Jump::tick`] is that of a robot that gets up from the floor first. No standard library, no allocation, no panic; generic over
//! the number type, so that the simulation in `f32` computes what the robot does.
//!
//! Body axes: x forward, y left, z up. Roll `q₁` and pitch `q₂` are zero when the robot stands
//! upright.

#![no_std]
#![forbid(unsafe_code)]

pub mod balance;
pub mod estimator;
pub mod euler_rates;
pub mod gravity;
pub mod imu;
pub mod jump;
pub mod pivot;
pub mod sphere;
pub mod tick;
pub mod vector;
pub mod wheel;

pub use balance::{Balance, Gains};
pub use estimator::{Accelerometers, Estimator, Settings, Tilt};
pub use jump::{Jump, Plan};
pub use tick::{Firmware, Memory, Readings};

/// Seconds from one tick to the next.
pub const INTERVAL: f64 = 0.01;

#[cfg(test)]
extern crate std;
