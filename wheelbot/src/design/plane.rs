//! The linear model of balancing, [6.21]: roll with the reaction wheel, pitch with the rolling wheel.

use super::standing::Standing;
use crate::robot::{self, PITCH, REACTION, ROLL, WHEEL};
use dynamics_codegen::diagnostic::Report;
use identify::machine::{Linearisation, SolveError};
use nalgebra::{DMatrix, Matrix4, Vector4};

/// What couples the planes, or leaves them, counts as nothing below this share of the largest entry.
const NEGLIGIBLE: f64 = 1e-9;

/// Why there is no design.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The model's text is no model.
    #[error("{0}")]
    Model(#[from] Report),
    /// The robot cannot be linearised upright.
    #[error("the robot cannot be linearised upright: {0}")]
    Unsolvable(#[from] SolveError),
    /// Nothing near upright is a balance.
    #[error("the robot stands still nowhere near upright")]
    Nowhere,
    /// The inputs cannot be held that long.
    #[error("the linear model has no finite step of {0} s")]
    Hold(f64),
    /// Roll and pitch are not apart.
    #[error(
        "roll and pitch do not come apart upright: the motion of {plane} leaves its plane by {leak}"
    )]
    Coupled {
        /// Which.
        plane: &'static str,
        /// The largest entry that should be zero.
        leak: f64,
    },
    /// The Riccati equation has no stabilising solution.
    #[error("the Riccati equation of {0} has no solution: check weights and model")]
    NoRegulator(&'static str),
}

/// `ẋ = A x + B u` or `x₊ = A x + B u` of one plane, with `x` in the order of the controllers: tilt,
/// tilt rate, wheel angle and wheel rate against the body (rad, rad/s), and `u` the wheel's torque, N·m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// `A`.
    pub a: Matrix4<f64>,
    /// `B`.
    pub b: Vector4<f64>,
}

/// Roll and pitch about upright: continuous, or from sample to sample with torques held for `hold`
/// seconds.
///
/// # Errors
/// [`DesignError`].
pub fn planes(hold: Option<f64>) -> Result<[Plane; 2], DesignError> {
    planes_of(&Standing::of(robot::compiled()?)?, hold)
}

/// The same of a model where it stands.
///
/// # Errors
/// [`DesignError`].
pub fn planes_of(standing: &Standing, hold: Option<f64>) -> Result<[Plane; 2], DesignError> {
    let Standing { lineariser, tilt } = standing;
    let parameters = lineariser.machine().nominal_parameters();
    let mut linear = lineariser.at(&standing.states(*tilt), &parameters)?;
    if let Some(seconds) = hold {
        linear = linear.sampled(seconds).ok_or(DesignError::Hold(seconds))?;
    }
    // The encoder of the rolling wheel sits on the body: it shows wheel less pitch.
    Ok([
        reduced(&linear, "roll", 0, [(ROLL, None), (REACTION, None)])?,
        reduced(&linear, "pitch", 1, [(PITCH, None), (WHEEL, Some(PITCH))])?,
    ])
}

/// The part of a linear model that moves in a plane: with `w = W ξ` the plane's coordinates,
/// `ẇ = W A W⁺ w` is all of it if `W A (1 − W⁺ W) = 0`, which is checked.
fn reduced(
    linear: &Linearisation,
    plane: &'static str,
    input: usize,
    [tilt, wheel]: [(usize, Option<usize>); 2],
) -> Result<Plane, DesignError> {
    let n = linear.basis.nrows() / 2;
    let mut rows = DMatrix::zeros(4, 2 * n);
    for (place, (coordinate, less)) in [tilt, wheel].into_iter().enumerate() {
        for rate in 0..2 {
            rows[(2 * place + rate, coordinate + rate * n)] = 1.0;
            if let Some(less) = less {
                rows[(2 * place + rate, less + rate * n)] = -1.0;
            }
        }
    }
    let chosen = rows * &linear.basis;
    let gram = &chosen * chosen.transpose();
    let coupled = |leak| DesignError::Coupled { plane, leak };
    let inverse = gram.try_inverse().ok_or_else(|| coupled(f64::NAN))?;
    let back = chosen.transpose() * inverse;
    let moved = &chosen * &linear.a;
    let a = &moved * back;
    let forced = &chosen * &linear.b;
    let leak = (moved - &a * &chosen)
        .amax()
        .max(forced.column(1 - input).amax());
    if leak.is_nan() || leak > NEGLIGIBLE * linear.a.amax() {
        return Err(coupled(leak));
    }
    Ok(Plane {
        a: Matrix4::from_fn(|i, k| a[(i, k)]),
        b: Vector4::from_fn(|i, _| forced[(i, input)]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against figures that were computed from the same masses without this project's code.
    #[test]
    fn upright_it_falls_as_it_should() {
        let [roll, pitch] = planes(None).unwrap();
        let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-4;
        assert!(
            close(roll.a[(1, 0)], 73.10) && close(roll.b[1], -51.11),
            "{roll:?}"
        );
        assert!(
            close(pitch.a[(1, 0)], 166.98) && close(pitch.b[1], -439.3),
            "{pitch:?}"
        );
        for plane in [roll, pitch] {
            assert!((plane.a[(0, 1)] - 1.0).abs() < 1e-12);
            assert!(plane.a[(1, 2)].abs().max(plane.a[(1, 3)].abs()) < 1e-9);
        }
    }
}
