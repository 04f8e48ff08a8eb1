//! A force of a known course along a log: what it does to the machine, and what the log says of it.

use super::error_dynamics::ErrorDynamics;
use super::whitener::{Mix, Whitener};
use nalgebra::DVector;

impl ErrorDynamics {
    /// The velocities that a unit of force on coordinate `i` makes through interval `k`. To the first order in the
    /// step the transition holds them, of a force that decays.
    fn pushed(&self, k: usize, i: usize) -> DVector<f64> {
        let n = self.coordinate_count();
        let decayed = (self.t[k + 1] - self.t[k]) / self.correlation[i];
        let made = self.transition[k].view((n, 2 * n + i), (n, 1));
        made.column(0) * (decayed / -(-decayed).exp_m1())
    }

    /// The same beside a force on coordinate `i`, in its unit, that is constant through each interval.
    pub fn with_force(&self, i: usize, force: &[f64]) -> Self {
        let n = self.coordinate_count();
        let mut with = self.clone();
        for (k, &force) in force.iter().enumerate() {
            let h = self.t[k + 1] - self.t[k];
            let velocities = self.pushed(k, i) * force;
            let mut forcing = with.forcing[k].column_mut(0);
            for (row, v) in velocities.iter().enumerate() {
                forcing[n + row] += v;
                forcing[row] += 0.5 * h * v;
            }
            let accelerations = self.slope[k].column(2 * n + i) * force;
            let mut acceleration = with.acceleration[k].column_mut(0);
            acceleration += accelerations;
        }
        with
    }
}

impl Whitener<'_> {
    /// How the likelihood depends on a force on a coordinate that is constant through an interval, `∂ ln L/∂F`:
    /// per interval, by coordinate, and nothing across a gap.
    pub fn pushes(&self) -> Vec<DVector<f64>> {
        let n = self.dynamics.coordinate_count();
        let rows = self.whiten(&Mix::Sum(&DVector::from_element(1, 1.0)));
        let mut pushes = vec![DVector::zeros(n); self.dynamics.transition.len()];
        self.backward(&rows, false, |sample, adjoint, _| {
            if sample == 0 || self.gaps[sample - 1] {
                return;
            }
            let h = self.dynamics.t[sample] - self.dynamics.t[sample - 1];
            let of_velocity = adjoint.vector.rows(n, n) + adjoint.vector.rows(0, n) * (0.5 * h);
            for i in 0..n {
                let velocities = self.dynamics.pushed(sample - 1, i);
                pushes[sample - 1][i] = -of_velocity.dot(&velocities);
            }
        });
        pushes
    }
}
