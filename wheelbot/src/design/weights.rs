//! The regulator of the robot's author: weights, and the gains that they give.

use super::plane::{DesignError, Plane, planes_of};
use super::riccati;
use super::standing::Standing;
use crate::robot;
use nalgebra::{Matrix4, Vector4};
use wheelbot_firmware::{Gains, INTERVAL};

/// `Q`'s diagonal and `R` of a plane.
#[derive(Debug, Clone, Copy)]
pub struct Weights {
    /// For tilt, tilt rate, wheel angle and wheel rate.
    pub state: [f64; 4],
    /// For the torque.
    pub torque: f64,
}

/// Roll and pitch, as the robot's author has them (wheelbot-v2.5, e8aebc5).
pub const WEIGHTS: [Weights; 2] = [
    Weights {
        state: [100.0, 0.01, 0.1, 0.1],
        torque: 1000.0,
    },
    Weights {
        state: [100.0, 1e-10, 1e-5, 10.0],
        torque: 10_000.0,
    },
];

/// The gains of the regulator for the model, sampled at the controller's rate; `u = +K x`, as the
/// robot has it.
///
/// # Errors
/// [`DesignError`].
pub fn designed() -> Result<Gains<f64>, DesignError> {
    designed_for(&Standing::of(robot::compiled()?)?)
}

/// The same for a model where it stands.
///
/// # Errors
/// [`DesignError`].
pub fn designed_for(standing: &Standing) -> Result<Gains<f64>, DesignError> {
    let [roll, pitch] = planes_of(standing, Some(INTERVAL))?;
    Ok(Gains {
        roll: gain("roll", &roll, &WEIGHTS[0])?,
        pitch: gain("pitch", &pitch, &WEIGHTS[1])?,
    })
}

fn gain(name: &'static str, plane: &Plane, weights: &Weights) -> Result<[f64; 4], DesignError> {
    let q = Matrix4::from_diagonal(&Vector4::from(weights.state));
    let p = riccati::solve(&plane.a, &plane.b, &q, weights.torque)
        .ok_or(DesignError::NoRegulator(name))?;
    Ok(riccati::gain(&plane.a, &plane.b, &p, weights.torque).map(|k| -k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{planes, poles::poles};

    /// Against gains and poles that were computed without this project's code.
    #[test]
    fn gains_and_poles_are_the_known_ones() {
        let gains = designed().unwrap();
        let known = [
            ([9.248, 1.091, 0.0083, 0.0107], gains.roll),
            ([1.255, 0.1552, 0.0, 0.0247], gains.pitch),
        ];
        for (known, found) in known {
            for (known, found) in known.iter().zip(found) {
                assert!(
                    (known - found.abs()).abs() < 6e-4 * f64::max(1.0, *known),
                    "{found}"
                );
            }
        }
        let [roll, pitch] = planes(Some(INTERVAL)).unwrap();
        let known = [
            (
                [0.9900, 0.9232, 0.9151, 0.8153],
                poles(&roll, &gains.roll, 0),
            ),
            ([1.0, 0.9594, 0.924, 0.688], poles(&pitch, &gains.pitch, 0)),
        ];
        for (known, found) in known {
            for (known, found) in known.iter().zip(&found) {
                assert!((known - found.norm()).abs() < 6e-4, "{found}");
            }
        }
    }

    #[test]
    fn published_gains_balance_the_model() {
        let [roll, pitch] = planes(Some(INTERVAL)).unwrap();
        let largest = |plane: &Plane, gain: &[f64; 4], delay| poles(plane, gain, delay)[0].norm();
        let gains = Gains::PUBLISHED;
        for (delay, roll_pair, pitch_pair) in [(0, 0.968, 0.985), (1, 0.978, 0.986)] {
            let found: Vec<f64> = poles(&roll, &gains.roll, delay)
                .iter()
                .map(|pole| pole.norm())
                .collect();
            assert!(
                found.iter().any(|p| (p - roll_pair).abs() < 6e-4),
                "{found:?}"
            );
            assert!((largest(&roll, &gains.roll, delay) - 0.998).abs() < 6e-4);
            assert!((largest(&pitch, &gains.pitch, delay) - pitch_pair).abs() < 6e-4);
        }
    }
}
