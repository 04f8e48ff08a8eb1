//! Roll, pitch and yaw as the robot has them, of a body that is free in space.

use super::floor::COORDINATES;
use crate::robot::{PITCH, REACTION, ROLL, State, WHEEL, X, Y, YAW};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// `r_w`, m.
pub const WHEEL_RADIUS: f64 = 0.053;
/// Cosine of the roll below which yaw and pitch are one angle.
const SIDEWAYS: f64 = 1e-3;

/// A robot in the angles of MATH.md and (6.1): yaw, then roll, then pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The state as a robot that rolls would have it. The contact point is where the wheel's lowest point would
    /// touch a floor under it.
    pub state: State,
    /// Of the wheel's lowest point above the floor, m.
    pub lift: f64,
}

impl Pose {
    /// From coordinates and rates of `on_floor.model`, with its `aim`.
    pub fn new(q: &[f64; COORDINATES], v: &[f64; COORDINATES], aim: f64, radius: f64) -> Self {
        let [x, y, z, turn, lean, tip, wheel, reaction] = *q;
        let axis = |angle, axis| Rotation3::from_axis_angle(&axis, angle);
        let [ex, ey, ez] = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
        let turned = axis(turn, ez);
        let leaning = turned * axis(lean, ex);
        let body = (leaning * axis(tip, ey) * axis(aim, ez)).into_inner();
        let omega = ez.into_inner() * v[3]
            + turned * ex.into_inner() * v[4]
            + leaning * ey.into_inner() * v[5];
        let [roll, pitch, yaw] = angles(&body);
        let [roll_rate, pitch_rate, yaw_rate] = rates([roll, yaw], &omega);
        let down =
            Rotation3::from_axis_angle(&ez, yaw) * axis(roll, ex) * Vector3::new(0.0, 0.0, radius);
        let mut state = State {
            q: [0.0; 7],
            v: [0.0; 7],
            z: [],
        };
        for (place, value, rate) in [
            (X, x - down.x, v[0]),
            (Y, y - down.y, v[1]),
            (ROLL, roll, roll_rate),
            (PITCH, pitch, pitch_rate),
            (YAW, yaw, yaw_rate),
            (WHEEL, wheel + pitch, v[6] + pitch_rate),
            (REACTION, reaction, v[7]),
        ] {
            (state.q[place], state.v[place]) = (value, rate);
        }
        Self {
            state,
            lift: z - down.z,
        }
    }

    /// The larger of roll and pitch, rad.
    pub fn tilt(&self) -> f64 {
        self.state.q[ROLL].abs().max(self.state.q[PITCH].abs())
    }
}

/// Roll, pitch and yaw of `R₃ R₁ R₂`.
fn angles(r: &Matrix3<f64>) -> [f64; 3] {
    let level = r.m33.hypot(r.m31);
    if level < SIDEWAYS {
        return [r.m32.atan2(level), 0.0, r.m21.atan2(r.m11)];
    }
    let (roll, pitch) = (r.m32.atan2(level), (-r.m31).atan2(r.m33));
    [roll, pitch, (-r.m12).atan2(r.m22)]
}

/// Rates of roll, pitch and yaw from the angular velocity along the world's axes.
fn rates([roll, yaw]: [f64; 2], omega: &Vector3<f64>) -> [f64; 3] {
    let ((sin, cos), (s, c)) = (yaw.sin_cos(), roll.sin_cos());
    let [ahead, left] = [cos * omega.x + sin * omega.y, cos * omega.y - sin * omega.x];
    let pitch = if c < SIDEWAYS { 0.0 } else { left / c };
    [ahead, pitch, omega.z - pitch * s]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// Angles come back, and their rates are their differences over a short time.
    #[test]
    fn rates_are_those_of_the_angles() {
        for aim in [0.0, FRAC_PI_2] {
            let q = [0.1, 0.2, 0.3, 0.4, 0.5, -0.6, 0.7, 0.8];
            let v = [1.0, 2.0, 3.0, 0.9, -1.1, 1.3, 2.0, 3.0];
            let h = 1e-6;
            let later = std::array::from_fn(|k| q[k] + h * v[k]);
            let [now, then] = [q, later].map(|q| Pose::new(&q, &v, aim, WHEEL_RADIUS).state);
            for k in [ROLL, PITCH, YAW, WHEEL, REACTION] {
                let rate = (then.q[k] - now.q[k]) / h;
                assert!((rate - now.v[k]).abs() < 1e-4, "{k}: {rate} {}", now.v[k]);
            }
        }
    }

    /// `R₃ R₁ R₂` of the angles is the body's turn.
    #[test]
    fn angles_are_those_of_the_rolling_model() {
        let axis = |angle, axis| Rotation3::from_axis_angle(&axis, angle);
        let [roll, pitch, yaw] = [0.3, -1.2, 2.0];
        let turn = axis(yaw, Vector3::z_axis()) * axis(roll, Vector3::x_axis());
        let found = angles(&(turn * axis(pitch, Vector3::y_axis())).into_inner());
        for (found, given) in found.iter().zip([roll, pitch, yaw]) {
            assert!((found - given).abs() < 1e-12);
        }
        let side = angles(&axis(FRAC_PI_2, Vector3::x_axis()).into_inner());
        assert!((side[0] - FRAC_PI_2).abs() < 1e-6 && side[1] == 0.0);
    }
}
