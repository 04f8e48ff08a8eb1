//! The balancing controllers (6.4.1): a linear law each for roll and for pitch.

use dynamics::Real;

/// Torque per unit of tilt, tilt rate, wheel angle and wheel rate: N·m per rad and rad/s.
pub type Gain<T> = [T; 4];

/// The gains of both wheels; torque is `+K x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains<T> {
    /// `K₁`: the reaction wheel, from roll.
    pub roll: Gain<T>,
    /// `K₂`: the rolling wheel, from pitch.
    pub pitch: Gain<T>,
}

impl Gains<f64> {
    /// Those that the robot balances with, (6.22).
    pub const PUBLISHED: Self = Self {
        roll: [4.5, 0.25, 0.0003, 0.0018],
        pitch: [1.6, 0.14, 0.04, 0.0344],
    };

    /// In another type of numbers.
    pub fn cast<T: Real>(&self) -> Gains<T> {
        Gains {
            roll: self.roll.map(T::from_f64),
            pitch: self.pitch.map(T::from_f64),
        }
    }
}

/// Torque per current of the motors, N·m/A.
pub const TORQUE_PER_CURRENT: f64 = 0.075;
/// Current that the balancing controllers allow themselves, A.
pub const MOST_CURRENT: f64 = 15.0;

/// Both controllers.
#[derive(Clone, Copy, Debug)]
pub struct Balance<T> {
    /// The gains.
    pub gains: Gains<T>,
    /// `q̄₁, q̄₂` of (6.22): what the estimator shows where the robot is in balance, rad.
    pub bias: [T; 2],
}

impl<T: Real> Balance<T> {
    /// Currents of the reaction wheel and of the rolling wheel, A. `tilt` and `rates` are roll and
    /// pitch; `wheels` are the angles and rates of the reaction wheel and of the rolling wheel against
    /// the body; `ahead` are torques to be added, N·m.
    pub fn currents(
        &self,
        tilt: [T; 2],
        rates: [T; 2],
        wheels: [(T, T); 2],
        ahead: [T; 2],
    ) -> [T; 2] {
        let gains = [&self.gains.roll, &self.gains.pitch];
        let most = T::from_f64(MOST_CURRENT);
        core::array::from_fn(|k| {
            let [tilt_gain, rate_gain, angle_gain, speed_gain] = *gains[k];
            let (angle, speed) = wheels[k];
            let leaning = tilt_gain * (tilt[k] - self.bias[k]) + rate_gain * rates[k];
            let torque = leaning + angle_gain * angle + speed_gain * speed + ahead[k];
            (torque / T::from_f64(TORQUE_PER_CURRENT))
                .min(most)
                .max(-most)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_drives_the_wheel_under_the_fall_within_the_limit() {
        let balance = Balance {
            gains: Gains::PUBLISHED,
            bias: [0.01, 0.0],
        };
        let still = [(0.0, 0.0); 2];
        let [roll, pitch] = balance.currents([0.03, -0.1], [0.0; 2], still, [0.0; 2]);
        assert!((roll - 4.5 * 0.02 / TORQUE_PER_CURRENT).abs() < 1e-12);
        assert!((pitch + 1.6 * 0.1 / TORQUE_PER_CURRENT).abs() < 1e-12);
        let fallen = balance.currents([1.0, -3.0], [0.0; 2], still, [0.0; 2]);
        assert_eq!(fallen, [MOST_CURRENT, -MOST_CURRENT]);
    }
}
