//! Regression on prediction errors: which terms, added to the equation of
//! motion, would have predicted the log?
//!
//! The log's states `x̂` are a curve; the model predicts how the true state
//! departs from it. To first order the departure `δ` obeys a linear equation,
//! driven by what the model gets wrong along the curve and by every candidate
//! term ([`ErrorDynamics`]). What no term explains is a force of its own, a process
//! whose size the log decides: the more of it there is, the less may be concluded. A Kalman filter on it turns sensor readings into
//! innovations that are white if the model is right, for the data and, with the
//! same gains, for each candidate ([`Whitener`]). What remains is ordinary least
//! squares ([`Gram`]) with the sensors' own noise: no differentiated signals, no
//! acceleration needed, constraint forces never enter.

mod adjoint;
mod auxiliary;
mod band;
mod closed;
mod error_dynamics;
mod force;
mod gram;
mod in_time;
mod innovations;
mod local;
mod moments;
mod mover;
mod observation;
mod process_noise;
mod readings;
mod sensed;
mod shooting;
mod shown;
mod small;
mod smoothing;
mod telling;
mod trails;
mod transition;
mod unseen;
mod whitener;

pub use adjoint::NoiseEvidence;
pub use auxiliary::Auxiliary;
pub(crate) use band::Band;
pub use error_dynamics::{CORRELATION, ErrorDynamics, Hold};
pub use gram::{BLOCKS, Fit, Gram, INVISIBLE};
pub use innovations::ChannelErrors;
pub use moments::Moments;
pub use mover::{Columns, Mover};
pub use process_noise::ProcessNoise;
pub use readings::Readings;
pub(crate) use sensed::{derivative, divided};
pub use smoothing::Smoothing;
pub(crate) use telling::{Told, Uncertainty, narrowing, said_of_band};
pub use whitener::Whitener;
