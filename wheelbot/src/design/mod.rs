//! Balancing designed from the model: linearised upright, decoupled, by a discrete regulator.

pub mod plane;
pub mod poles;
pub mod riccati;
pub mod weights;

pub use plane::{DesignError, Plane, planes};
pub use weights::designed;
