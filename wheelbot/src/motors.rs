//! The motors with their driver: torque of a current, as far as voltage and speed allow.

use wheelbot_firmware::balance::TORQUE_PER_CURRENT;

/// N·m at stall (Table 6.1).
pub const STALL_TORQUE: f64 = 1.3;
/// rad/s at which nothing is left of it, at the nominal voltage (Table 6.1).
pub const FREE_SPEED: f64 = 300.0;
/// V.
pub const NOMINAL_VOLTAGE: f64 = 24.5;

/// Both motors on one battery.
#[derive(Debug, Clone, Copy)]
pub struct Motors {
    /// Of the battery, V.
    pub voltage: f64,
}

impl Motors {
    /// Torque, N·m, of a commanded current, A, at a wheel's speed against the body, rad/s. The
    /// torque that is left falls along a line from stall to the free speed; both are in proportion
    /// to the voltage, but the current limit keeps the torque at [`STALL_TORQUE`] at most. Braking
    /// has all of it.
    pub fn torque(&self, current: f64, speed: f64) -> f64 {
        let share = self.voltage / NOMINAL_VOLTAGE;
        let driven = speed * current.signum() / FREE_SPEED;
        let most = STALL_TORQUE * (share - driven).clamp(0.0, 1.0);
        (TORQUE_PER_CURRENT * current).clamp(-most, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_falls_with_speed_and_voltage() {
        let motors = Motors {
            voltage: NOMINAL_VOLTAGE,
        };
        assert_eq!(motors.torque(4.0, 0.0), 4.0 * TORQUE_PER_CURRENT);
        assert_eq!(motors.torque(1000.0, 0.0), STALL_TORQUE);
        assert_eq!(motors.torque(-1000.0, -150.0), -STALL_TORQUE / 2.0);
        assert_eq!(motors.torque(1000.0, 310.0), 0.0);
        assert_eq!(motors.torque(-1000.0, 310.0), -STALL_TORQUE);
        let empty = Motors { voltage: 12.25 };
        assert_eq!(empty.torque(1000.0, 0.0), STALL_TORQUE / 2.0);
    }

    proptest::proptest! {
        /// Whatever is asked for, torque has the current's sign and none of its bounds is passed.
        #[test]
        fn torque_keeps_its_bounds(
            current in -50.0..50.0,
            speed in -400.0..400.0,
            voltage in 0.0..30.0,
        ) {
            let torque: f64 = Motors { voltage }.torque(current, speed);
            let asked: f64 = TORQUE_PER_CURRENT * current;
            proptest::prop_assert!(torque * asked >= 0.0);
            proptest::prop_assert!(torque.abs() <= asked.abs().min(STALL_TORQUE));
        }
    }
}
