//! The four IMUs: where they sit, how they are turned, and their readings in body axes.

use crate::vector::Vector;
use dynamics::Scalar;

/// How many there are.
pub const COUNT: usize = 4;

/// Where an IMU sits on the body.
#[derive(Clone, Copy, Debug)]
pub struct Mounting<T> {
    /// From the rolling wheel's centre, in body axes, m.
    pub position: Vector<T>,
    /// `R_Bi`, from the IMU's axes to those of the body, row by row.
    turned: [[T; 3]; 3],
}

impl<T: Scalar> Mounting<T> {
    /// At a place, its axes turned about z, then by a quarter about x, forward or back.
    fn new(position: [f64; 3], about_z: f64, forward: bool) -> Self {
        let (sin, cos) = T::from_f64(about_z.to_radians()).sin_cos();
        let (zero, quarter) = (T::zero(), T::from_f64(if forward { 1.0 } else { -1.0 }));
        Self {
            position: position.map(T::from_f64),
            turned: [
                [cos, zero, quarter * sin],
                [sin, zero, -(quarter * cos)],
                [zero, quarter, zero],
            ],
        }
    }

    /// `ᴮa = R_Bi ⁱa`.
    pub fn to_body(&self, a: Vector<T>) -> Vector<T> {
        self.turned
            .map(|row| row[0] * a[0] + row[1] * a[1] + row[2] * a[2])
    }
}

/// The Wheelbot's IMUs (wheelbot-v2.5, e8aebc5), m and degrees.
pub fn mountings<T: Scalar>() -> [Mounting<T>; COUNT] {
    [
        Mounting::new([-0.048, -0.048, 0.119], -135.0, false),
        Mounting::new([0.048, 0.048, 0.119], 45.0, false),
        Mounting::new([0.048, -0.048, -0.004], -45.0, true),
        Mounting::new([-0.048, 0.048, -0.004], 135.0, true),
    ]
}

/// What all IMUs read, each turned into body axes.
pub fn in_body_axes<T: Scalar>(
    mountings: &[Mounting<T>; COUNT],
    readings: &[Vector<T>; COUNT],
) -> [Vector<T>; COUNT] {
    core::array::from_fn(|i| mountings[i].to_body(readings[i]))
}

/// `Σ ᴮaᵢ / 4`.
pub fn mean<T: Scalar>(all: &[Vector<T>; COUNT]) -> Vector<T> {
    let quarter = T::from_f64(0.25);
    core::array::from_fn(|k| quarter * (all[0][k] + all[1][k] + (all[2][k] + all[3][k])))
}
