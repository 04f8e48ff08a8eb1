//! Machines that planes push and never pull: contacts with friction and restitution.
//!
//! Every contact has a gap `g(q, t)` and a velocity `w = J v + ∂x/∂t` with two components along its
//! plane and one along the normal. Impulses `p` act on the velocities by `M⁻¹ Jᵀ p`; they press
//! (`pₙ ≥ 0`), only where the gap is closed, and friction holds or slows within Coulomb's cone
//! `|pₜ| ≤ μ pₙ`. [`Stepping`] moves a machine so.

mod associated;
mod cone;
mod impact;
mod lasting;
mod law;
mod located;
mod newton;
mod pressed;
mod projection;
mod resolved;
mod solve;
mod step;
mod sweeps;
mod terms;
mod view;

pub use located::Impact;
pub use pressed::Pressed;
pub use step::{Stepping, SteppingOptions};
pub use terms::ContactTerms;
pub(super) use terms::tape;
