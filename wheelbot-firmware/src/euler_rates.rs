//! From the body's angular velocity to the rates of roll, pitch and yaw.

use crate::vector::{Attitude, Vector};
use dynamics::Real;

/// `cos q₁` at least, in what is divided by it: 87° of roll. A robot that lies on its side keeps a
/// finite yaw rate.
const LEAST_COSINE: f64 = 0.05;

/// `(q̇₁, q̇₂, q̇₃)` from `ω`, rad/s, in body axes: solved from
///
/// ```text
/// ω = R₂ᵀ e₁ q̇₁ + e₂ q̇₂ + R₂ᵀ R₁ᵀ e₃ q̇₃
/// ```
///
/// [6.3] of the thesis has the transpose of this map in place of its inverse (`docs/errata.md`).
pub fn euler_rates<T: Real>(attitude: &Attitude<T>, omega: Vector<T>) -> Vector<T> {
    let ((s1, c1), (s2, c2)) = (attitude.roll, attitude.pitch);
    let roll = c2 * omega[0] + s2 * omega[2];
    let yaw = (c2 * omega[2] - s2 * omega[0]) / c1.max(T::from_f64(LEAST_COSINE));
    [roll, omega[1] - s1 * yaw, yaw]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rates_are_those_that_make_the_angular_velocity(
            angles in [-1.4..1.4, -3.0..3.0],
            rates in [-9.0..9.0, -9.0..9.0, -9.0..9.0],
        ) {
            let attitude = Attitude::new(angles[0], angles[1]);
            let yawing = attitude.to_body([0.0, 0.0, rates[2]]);
            let (s2, c2) = attitude.pitch;
            let rolling = [c2 * rates[0], 0.0, s2 * rates[0]];
            let omega = [
                rolling[0] + yawing[0],
                rates[1] + yawing[1],
                rolling[2] + yawing[2],
            ];
            let found: [f64; 3] = euler_rates(&attitude, omega);
            for (found, rate) in found.iter().zip(rates) {
                prop_assert!((found - rate).abs() < 1e-12, "{found} {rate}");
            }
        }
    }
}
