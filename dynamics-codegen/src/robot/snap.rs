//! Rounding of rotations that mean 0 and ±1 but miss them by a digit.
//!
//! Files write π/2 as `1.57079632679`. The rotation then has entries such as
//! `4.9e-12` that mean zero, and each of them costs operations in everything
//! that is derived from it.

use super::spatial::{Matrix3, Vector3};

/// What was rounded.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Snapped {
    /// The tolerance; 0 if rounding was switched off.
    pub tolerance: f64,
    /// How many entries of rotations and axes were moved to 0 or ±1.
    pub count: usize,
    /// The farthest that an entry was moved.
    pub largest: f64,
}

impl Snapped {
    /// Nothing rounded yet, at a tolerance. Tolerances above 1e-3 count as that;
    /// what is not above 0 switches rounding off.
    pub fn within(tolerance: f64) -> Self {
        Self {
            tolerance: if tolerance > 0.0 {
                tolerance.min(1e-3)
            } else {
                0.0
            },
            ..Self::default()
        }
    }

    /// Rounds the entries of a rotation: those within the tolerance of 0 become
    /// 0; one within the tolerance of ±1 becomes ±1 if that leaves its row and
    /// its column with nothing else, so that an orthogonal matrix stays one.
    pub fn rotation(&mut self, rotation: &mut Matrix3) {
        if self.tolerance == 0.0 {
            return;
        }
        for entry in rotation.as_flattened_mut() {
            self.round_to_zero(entry);
        }
        for i in 0..3 {
            for j in 0..3 {
                let alone = (0..3).all(|k| {
                    (k == j || rotation[i][k] == 0.0) && (k == i || rotation[k][j] == 0.0)
                });
                if alone {
                    self.round_to_one(&mut rotation[i][j]);
                }
            }
        }
    }

    /// As [`rotation`](Self::rotation), for a unit vector.
    pub fn unit_vector(&mut self, vector: &mut Vector3) {
        if self.tolerance == 0.0 {
            return;
        }
        for entry in vector.iter_mut() {
            self.round_to_zero(entry);
        }
        if vector.iter().filter(|&&x| x != 0.0).count() == 1 {
            for entry in vector.iter_mut() {
                self.round_to_one(entry);
            }
        }
    }

    fn round_to_zero(&mut self, entry: &mut f64) {
        if entry.abs() <= self.tolerance {
            self.moved(entry, 0.0);
        }
    }

    fn round_to_one(&mut self, entry: &mut f64) {
        if (entry.abs() - 1.0).abs() <= self.tolerance {
            self.moved(entry, 1.0_f64.copysign(*entry));
        }
    }

    fn moved(&mut self, entry: &mut f64, target: f64) {
        let distance = (*entry - target).abs();
        if distance > 0.0 {
            self.count += 1;
            self.largest = self.largest.max(distance);
        }
        *entry = target;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::spatial::rotation_from_rpy;

    #[test]
    #[expect(clippy::approx_constant, reason = "an angle as files write it")]
    fn a_quarter_turn_with_eleven_digits_becomes_exact() {
        let mut r = rotation_from_rpy([1.57079632679, 0.0, 3.14159265359]);
        let mut snapped = Snapped::within(1e-9);
        snapped.rotation(&mut r);
        assert_eq!(r, [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
        assert!(snapped.count > 0 && snapped.largest < 1e-11, "{snapped:?}");
    }

    #[test]
    fn an_honest_angle_stays() {
        let exact = rotation_from_rpy([0.0, 0.0, 0.3]);
        let mut r = exact;
        let mut snapped = Snapped::within(1e-6);
        snapped.rotation(&mut r);
        assert_eq!(r, exact);
        assert_eq!(snapped.count, 0);
    }

    #[test]
    fn a_small_angle_that_cannot_be_zero_keeps_its_cosine() {
        // cos(1e-4) misses 1 by 5e-9, sin(1e-4) is not near 0.
        let exact = rotation_from_rpy([0.0, 0.0, 1e-4]);
        let mut r = exact;
        Snapped::within(1e-6).rotation(&mut r);
        assert_eq!(r, exact);
    }

    #[test]
    fn at_tolerance_zero_nothing_moves() {
        let exact = rotation_from_rpy([std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
        let mut r = exact;
        let mut snapped = Snapped::default();
        snapped.rotation(&mut r);
        assert_eq!((r, snapped.count), (exact, 0));
    }
}
