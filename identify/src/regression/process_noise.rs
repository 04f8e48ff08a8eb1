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

    /// The same accelerations and gaps, not below the least that `other` states. Hypotheses compare only
    /// where that is the same: under a constraint that is known one per cent better each sample of
    /// it is a hundredth of a nat likelier, whatever the hypothesis.
    #[must_use]
    pub fn at_least(&self, other: &Self) -> Self {
        let mut same = self.clone();
        same.suit(&other.mobility);
        Self {
            force_sd: same.force_sd.sup(&other.smallest),
            jitter: same.jitter.sup(&other.smallest_jitter),
            closure_sd: same.closure_sd.sup(&other.smallest_closure),
            unseen: same.unseen,
            ..other.clone()
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

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(force_sd: f64, smallest: f64, mobility: f64) -> ProcessNoise {
        let one = |x: f64| DVector::from_element(1, x);
        ProcessNoise {
            force_sd: one(force_sd),
            smallest: one(smallest),
            mobility: one(mobility),
            jitter: one(0.1 * force_sd),
            smallest_jitter: one(0.1 * smallest),
            unseen: 0.0,
            closure_sd: one(1e-3 * force_sd),
            smallest_closure: one(1e-3 * smallest),
        }
    }

    #[test]
    fn the_least_of_another_holds_and_accelerations_stay() {
        let least = noise(9.0, 0.2, 0.5);
        // Twice as mobile: half the acceleration in the other machine's force.
        let large = noise(4.0, 1.0, 1.0).at_least(&least);
        assert_eq!(large.force_sd[0] * 0.5, 4.0);
        assert_eq!((large.smallest[0], large.mobility[0]), (0.2, 0.5));
        assert_eq!(large.closure_sd[0], 4e-3);
        assert_eq!(large.smallest_closure, least.smallest_closure);
        let small = noise(0.01, 0.01, 1.0).at_least(&least);
        assert_eq!(small.force_sd, least.smallest);
        assert_eq!(small.jitter, least.smallest_jitter);
        assert_eq!(small.closure_sd, least.smallest_closure);
    }
}
