//! Constraint stabilisation.

use nalgebra::SVector;

use crate::{Constraint, Scalar};

/// Baumgarte's stabilisation (thesis 5.28–5.32, signs corrected): the violation decays
/// like a damped oscillator instead of drifting.
///
/// `b̃ = b − 2 ζ ω ċ − ω² c` for a holonomic row, `b̃ = b − ω c` for a nonholonomic one.
/// Explicit integrators need a step below about `2/ω`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baumgarte<T> {
    /// Rate `ω` at which a violation decays, 1/s.
    pub omega: T,
    /// Damping ratio `ζ`; 1 is the fastest decay without overshoot.
    pub zeta: T,
}

impl<T: Scalar> Baumgarte<T> {
    /// Critically damped, `ζ = 1`.
    pub fn critical(omega: T) -> Self {
        Self {
            omega,
            zeta: T::one(),
        }
    }

    /// The stabilised right-hand side `b̃`.
    pub fn stabilise<const N: usize, const M: usize>(
        &self,
        constraint: &Constraint<T, N, M>,
    ) -> SVector<T, M> {
        let damping = (self.zeta + self.zeta) * self.omega;
        let stiffness = self.omega * self.omega;
        SVector::from_fn(|i, _| {
            if constraint.holonomic[i] {
                constraint.b[i] - damping * constraint.c_dot[i] - stiffness * constraint.c[i]
            } else {
                constraint.b[i] - self.omega * constraint.c[i]
            }
        })
    }
}
