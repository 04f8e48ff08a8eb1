//! Balancing designed from the model: linearised upright, decoupled, by a discrete regulator.

pub mod plane;
pub mod poles;
pub mod riccati;
pub mod standing;
pub mod weights;

pub use plane::{DesignError, Plane, planes, planes_of};
pub use standing::Standing;
pub use weights::{designed, designed_for};
