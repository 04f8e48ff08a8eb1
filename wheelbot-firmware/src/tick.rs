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

/// What the next tick needs of this one, beside the counts of the encoders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory<T> {
    /// Roll and pitch as estimated, rad.
    pub tilt: [T; 2],
    /// Rates of roll, pitch and yaw, rad/s.
    pub rates: Vector<T>,
    /// Of the reaction wheel and of the rolling wheel: [`Wheel::memory`].
    pub wheels: [[T; 2]; 2],
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

    /// One that goes on from a tick that another has made.
    #[must_use]
    pub fn remembering(self, memory: Memory<T>) -> Self {
        let [reaction, rolling] = memory.wheels.map(Wheel::remembering);
        Self {
            estimator: self.estimator.remembering(memory.tilt, memory.rates),
            reaction,
            rolling,
            ..self
        }
    }

    /// What it has to remember.
    pub fn memory(&self) -> Memory<T> {
        let tilt = self.estimator.tilt();
        Memory {
            tilt: tilt.fused,
            rates: tilt.rates,
            wheels: [self.reaction.memory(), self.rolling.memory()],
        }
    }

    /// Reads everything once: the estimate, and the currents of the reaction wheel and of the rolling
    /// wheel, A. `ahead` are torques to be added to those of the feedback, N·m.
    pub fn tick(&mut self, readings: &Readings<T>, ahead: [T; 2]) -> (Tilt<T>, [T; 2]) {
        let turned = [
            self.reaction.counted(readings.reaction),
            self.rolling.counted(readings.rolling),
        ];
        self.tick_turned(readings, turned, ahead)
    }

    /// The same for wheels whose counts the caller has taken ([`Wheel::counted`]; the reaction wheel
    /// first), all of a tick that is arithmetic. Those of `readings` are not looked at.
    pub fn tick_turned(
        &mut self,
        readings: &Readings<T>,
        turned: [[T; 2]; 2],
        ahead: [T; 2],
    ) -> (Tilt<T>, [T; 2]) {
        self.reaction.turn(turned[0], self.interval);
        self.rolling.turn(turned[1], self.interval);
        let tilt = self.estimator.update(readings, &self.rolling);
        let wheels = [&self.reaction, &self.rolling].map(|wheel| (wheel.angle, wheel.rate));
        let [roll_rate, pitch_rate, _] = tilt.rates;
        let rates = [roll_rate, pitch_rate];
        let currents = self.balance.currents(tilt.fused, rates, wheels, ahead);
        (tilt, currents)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gains, Settings};

    fn readings(tick: i32) -> Readings<f32> {
        let wave = |k: i32| (0.37 * (tick * 31 + k) as f32).sin();
        let vectors = |size: f32, up: f32| {
            core::array::from_fn(|imu| {
                core::array::from_fn(|axis| {
                    let gravity = if axis == 1 { up } else { 0.0 };
                    let side = if imu < 2 { -1.0 } else { 1.0 };
                    side * gravity + size * wave((imu * 3 + axis) as i32)
                })
            })
        };
        Readings {
            gyroscopes: vectors(0.3, 0.0),
            accelerometers: vectors(1.0, 9.81),
            reaction: 900 + tick * tick,
            rolling: -70 * tick,
        }
    }

    /// Who takes over from another's memory computes what that one would have.
    #[test]
    fn memory_is_all_that_goes_on() {
        let balance = Balance {
            gains: Gains::PUBLISHED.cast(),
            bias: [0.01, -0.02],
        };
        let fresh = || {
            let estimator = Estimator::new(Settings::published(), [0.1, -0.1]);
            Firmware::<f32>::new(estimator, balance)
        };
        let mut whole = fresh();
        let mut counters = [Wheel::<f32>::new(), Wheel::new()];
        for tick in 0..50 {
            let readings = readings(tick);
            let turned = [
                counters[0].counted(readings.reaction),
                counters[1].counted(readings.rolling),
            ];
            let mut next = fresh().remembering(whole.memory());
            let expected = whole.tick(&readings, [0.2, 0.0]);
            assert_eq!(next.tick_turned(&readings, turned, [0.2, 0.0]), expected);
            assert_eq!(next.memory(), whole.memory());
        }
    }
}
