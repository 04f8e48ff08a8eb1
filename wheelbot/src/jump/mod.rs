//! Jumping up from the floor (6.4.2): the robot free in space, with contacts in place of rolling.
//!
//! ```text
//! floor ──▶ sensing ──▶ wheelbot-firmware (jump) ──▶ motors ──▶ floor      run: once around, 1 kHz
//!   └── pose: roll, pitch and yaw of where it is
//! ```

pub mod draw;
pub mod floor;
pub mod plans;
pub mod pose;
pub mod ready;
pub mod run;

pub use floor::{Conditions, Floor, Way};
pub use ready::Ready;
pub use run::{Jumped, Jumper};
