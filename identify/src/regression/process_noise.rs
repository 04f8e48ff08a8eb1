//! How large the forces are that nothing explains.

use nalgebra::DVector;

/// The size of forces that nothing explains: `f` of [`ErrorDynamics`](super::ErrorDynamics).
#[derive(Debug, Clone, PartialEq)]
pub struct ProcessNoise {
    /// Standard deviation per coordinate, in the coordinate's force unit.
    pub force_sd: DVector<f64>,
    /// The least that it may be. One for all explanations of a log that move the same inertia,
    /// since one that brings larger forces with it must not have to bear larger unexplained ones.
    pub smallest: DVector<f64>,
    /// What a unit of each force accelerates its coordinate by, in the machine that both are for.
    pub mobility: DVector<f64>,
    /// White forces per coordinate, in its force unit times √s: what shakes a machine faster than
    /// the log shows, as the noise of a torque that was measured and never felt.
    pub jitter: DVector<f64>,
    /// The least that it may be.
    pub smallest_jitter: DVector<f64>,
    /// What inputs do between samples beside what is drawn there, as a share of how much they bend; one for
    /// all, no unit.
    pub unseen: f64,
    /// How far each holonomic constraint is missed, in its unit: lengths that nothing corrects.
    pub closure_sd: DVector<f64>,
    /// The least that it may be.
    pub smallest_closure: DVector<f64>,
}

impl ProcessNoise {
    /// The same accelerations, of a machine that is moved in another way. Were it the same forces,
    /// they would move a machine the less the heavier it is, and the log would speak for a load
    /// where the drive is weak.
    pub fn suit(&mut self, mobility: &DVector<f64>) {
        for (i, (&new, old)) in mobility.iter().zip(self.mobility.iter_mut()).enumerate() {
            // What constraints hold fast is moved by nothing.
            if new > 0.0 && *old > 0.0 {
                let factor = *old / new;
                self.force_sd[i] *= factor;
                self.smallest[i] *= factor;
                self.jitter[i] *= factor;
                self.smallest_jitter[i] *= factor;
                *old = new;
            }
        }
    }

    /// A multiple of the forces, not below the smallest.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self {
            force_sd: (&self.force_sd * factor).sup(&self.smallest),
            jitter: (&self.jitter * factor).sup(&self.smallest_jitter),
            ..self.clone()
        }
    }

    /// White forces as small as they may be.
    #[must_use]
    pub fn at_smallest_jitter(&self) -> Self {
        Self {
            jitter: self.smallest_jitter.clone(),
            ..self.clone()
        }
    }

    /// The smallest forces.
    #[must_use]
    pub fn at_smallest(&self) -> Self {
        Self {
            force_sd: self.smallest.clone(),
            ..self.clone()
        }
    }
}
