//! The machine that a curve is thought to be the motion of, and what its acceleration is derived by.

use crate::machine::{Instruments, Machine, SensitivityTape, Sensors};

/// The machine that a curve is thought to be the motion of.
#[derive(Clone, Copy)]
pub struct Mover<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Its derivatives by positions and velocities, in this order.
    pub slopes: &'a SensitivityTape,
    /// The model's sensors with derivatives by the same; `None` if a log has none of them.
    pub instruments: Option<&'a Instruments>,
    /// Its parameters.
    pub parameters: &'a [f64],
}

impl Mover<'_> {
    /// The same, with no look at its sensors: these are read at samples, not on the way.
    pub(super) fn unseen(self) -> Self {
        Self {
            instruments: None,
            ..self
        }
    }
}

/// Which derivatives of the acceleration are wanted as columns.
pub struct Columns<'a> {
    /// The machine that the derivatives are of: that of the curve, or one that moves as
    /// it does and has further effects whose strength is null.
    pub machine: &'a Machine,
    /// Derivatives by some parameters.
    pub tape: &'a SensitivityTape,
    /// The machine's sensors, with derivatives by the same parameters; `None` if no reading
    /// depends on them.
    pub sensors: Option<&'a Sensors>,
    /// The model's sensors with derivatives by the same parameters; `None` if a log has none of
    /// them.
    pub instruments: Option<&'a Instruments>,
    /// Where to take them. These parameters may differ from those of the curve's
    /// machine only in what does not change its motion.
    pub parameters: &'a [f64],
}
