//! One tick of the controller, in the order of the robot's firmware.

use crate::balance::Balance;
use crate::estimator::{Estimator, Tilt};
use crate::imu::COUNT;
use crate::vector::Vector;
use crate::wheel::Wheel;
use dynamics::{Real, Scalar};

/// What the controller reads at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings<T> {
    /// Angular velocity by each IMU along its own axes, rad/s.
    pub gyroscopes: [Vector<T>; COUNT],
    /// Acceleration less gravity by each IMU along its own axes, m/s².
    pub accelerometers: [Vector<T>; COUNT],
    /// Encoder of the reaction wheel, counts.
    pub reaction: i32,
    /// Encoder of the rolling wheel, counts.
    pub rolling: i32,
}

/// Estimator and controllers with all that they remember.
#[derive(Clone, Copy, Debug)]
pub struct Firmware<T: Real> {
    estimator: Estimator<T>,
    balance: Balance<T>,
    reaction: Wheel<T>,
    rolling: Wheel<T>,
    interval: T,
}

impl<T: Real> Firmware<T> {
    /// Nothing read yet.
    pub fn new(estimator: Estimator<T>, balance: Balance<T>) -> Self {
        Self {
            estimator,
            balance,
            reaction: Wheel::new(),
            rolling: Wheel::new(),
            interval: <T as Scalar>::from_f64(crate::INTERVAL),
        }
    }

    /// Reads everything once: the estimate, and the currents of the reaction wheel and of the rolling
    /// wheel, A. `ahead` are torques to be added to those of the feedback, N·m.
    pub fn tick(&mut self, readings: &Readings<T>, ahead: [T; 2]) -> (Tilt<T>, [T; 2]) {
        self.reaction.read(readings.reaction, self.interval);
        self.rolling.read(readings.rolling, self.interval);
        let tilt = self.estimator.update(readings, &self.rolling);
        let wheels = [&self.reaction, &self.rolling].map(|wheel| (wheel.angle(), wheel.rate));
        let [roll_rate, pitch_rate, _] = tilt.rates;
        let rates = [roll_rate, pitch_rate];
        let currents = self.balance.currents(tilt.fused, rates, wheels, ahead);
        (tilt, currents)
    }
}
