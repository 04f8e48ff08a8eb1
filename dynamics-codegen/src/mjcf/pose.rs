//! `pos` with `quat`, `axisangle`, `euler`, `xyaxes` or `zaxis`: where a frame stands.

use super::reader::{Part, Reader};
use crate::diagnostic::Diagnostic;
use crate::robot::spatial::{cross, dot, product, rotation_about, rotation_from_quaternion};
use crate::robot::{IDENTITY, Matrix3, Placement, Vector3};

/// The ways to say how something is turned, of which one may be stated.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// About which axes the three angles of `euler` turn, one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EulerSequence([(usize, bool); 3]);

impl Default for EulerSequence {
    /// `xyz`: about axes that turn along.
    fn default() -> Self {
        Self([(0, true), (1, true), (2, true)])
    }
}

impl EulerSequence {
    /// As `eulerseq` writes it: small letters for axes that turn along, capitals for those of the
    /// outer frame.
    pub fn of(text: &str) -> Option<Self> {
        let axis = |letter: char| {
            let index = "xyz".find(letter.to_ascii_lowercase())?;
            Some((index, letter.is_ascii_lowercase()))
        };
        let axes: Option<Vec<(usize, bool)>> = text.chars().map(axis).collect();
        Some(Self(axes?.try_into().ok()?))
    }

    /// The rotation of three angles, rad.
    pub fn rotation(&self, angles: Vector3) -> Matrix3 {
        let mut whole = IDENTITY;
        for ((axis, turns_along), angle) in self.0.into_iter().zip(angles) {
            let turn = rotation_about(IDENTITY[axis], angle);
            whole = match turns_along {
                true => product(&whole, &turn),
                false => product(&turn, &whole),
            };
        }
        whole
    }
}

impl<'a, 't> Reader<'_, 'a, 't> {
    /// Where an element's frame stands in that of the element around it.
    pub fn pose(&mut self, part: &Part<'a, 't>) -> Placement {
        let translation = part.vector(self, "pos", "lengths in m").unwrap_or_default();
        Placement {
            rotation: self.orientation(part),
            translation,
        }
    }

    fn orientation(&mut self, part: &Part<'a, 't>) -> Matrix3 {
        let own: Vec<_> = ORIENTATIONS
            .into_iter()
            .filter_map(|name| Some((name, part.element.given(name)?)))
            .collect();
        if let [(first, _), (second, given), ..] = own[..] {
            let message = format!("{} has both `{first}` and `{second}`", part.owner);
            self.report(Diagnostic::error(given.span(), message).help("keep one of the two"));
            return IDENTITY;
        }
        let of_class = || {
            let mut all = ORIENTATIONS.into_iter();
            all.find(|name| part.given(self, name).is_some())
        };
        let stated = own.first().map(|(name, _)| *name).or_else(of_class);
        let rotation = stated.and_then(|name| self.rotation(part, name));
        let mut rotation = rotation.unwrap_or(IDENTITY);
        self.snapped.rotation(&mut rotation);
        rotation
    }

    fn rotation(&mut self, part: &Part<'a, 't>, name: &str) -> Option<Matrix3> {
        match name {
            "quat" => {
                let numbers = part.numbers(self, name, [4, 4], "a quaternion w x y z")?;
                let [w, x, y, z] = numbers.try_into().ok()?;
                self.is_direction(part, name, &[w, x, y, z])?;
                Some(rotation_from_quaternion([x, y, z, w]))
            }
            "axisangle" => {
                let numbers = part.numbers(self, name, [4, 4], "an axis x y z and an angle")?;
                let [x, y, z, angle] = numbers.try_into().ok()?;
                self.is_direction(part, name, &[x, y, z])?;
                let angle = self.settings.angle(angle);
                Some(rotation_about(unit([x, y, z]), angle))
            }
            "euler" => {
                let angles = part.vector(self, name, "three angles")?;
                let angles = angles.map(|angle| self.settings.angle(angle));
                Some(self.settings.euler.rotation(angles))
            }
            "xyaxes" => {
                let numbers = part.numbers(self, name, [6, 6], "the axes x and y")?;
                let [a, b, c, d, e, f] = numbers.try_into().ok()?;
                self.is_direction(part, name, &[a, b, c])?;
                let x = unit([a, b, c]);
                let along = [d, e, f];
                let scale = largest(&along);
                let share = dot(x, along.map(|e| e / scale.max(f64::MIN_POSITIVE)));
                let y = [0, 1, 2].map(|i| along[i] - share * scale * x[i]);
                let parallel = largest(&y) <= 1e-12 * scale;
                self.is_direction(part, name, if parallel { &[0.0] } else { &y })?;
                let y = unit(y);
                Some(columns(x, y, cross(x, y)))
            }
            _ => {
                let z = part.vector(self, name, "the axis z")?;
                self.is_direction(part, name, &z)?;
                Some(least_turn_to(unit(z)))
            }
        }
    }

    /// Refuses zeros for a direction.
    fn is_direction(&mut self, part: &Part<'a, 't>, name: &str, entries: &[f64]) -> Option<()> {
        if entries.iter().any(|&x| x != 0.0) {
            return Some(());
        }
        let at = part.given(self, name).map(|given| given.span());
        let at = at.unwrap_or(part.element.tag());
        let message = format!("`{name}` of {} has no direction", part.owner);
        self.report(Diagnostic::error(at, message).label(match name {
            "quat" => "the identity is 1 0 0 0",
            "xyaxes" => "expected two directions that are not parallel",
            _ => "expected an axis of any length but zero",
        }));
        None
    }
}

/// The largest of some numbers without their signs.
fn largest(entries: &[f64]) -> f64 {
    entries.iter().fold(0.0, |m, x| x.abs().max(m))
}

/// A vector of length one along another of any length but zero.
pub(super) fn unit(vector: Vector3) -> Vector3 {
    // Scaled first: the square of a huge or tiny number is none.
    let scale = largest(&vector);
    let scaled = vector.map(|x| x / scale);
    let length = dot(scaled, scaled).sqrt();
    scaled.map(|x| x / length)
}

/// The matrix of these columns.
fn columns(x: Vector3, y: Vector3, z: Vector3) -> Matrix3 {
    [0, 1, 2].map(|i| [x[i], y[i], z[i]])
}

/// The rotation that takes the axis z to a unit vector on the shortest way; where that is −z,
/// half a turn about x.
pub(super) fn least_turn_to(target: Vector3) -> Matrix3 {
    let z = IDENTITY[2];
    let axis = cross(z, target);
    let sine = dot(axis, axis).sqrt();
    let angle = sine.atan2(target[2]);
    let axis = if sine < 1e-10 {
        IDENTITY[0]
    } else {
        unit(axis)
    };
    rotation_about(axis, angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn close(a: &Matrix3, b: &Matrix3) {
        for (x, y) in a.as_flattened().iter().zip(b.as_flattened()) {
            assert!((x - y).abs() < 1e-15, "{a:?} {b:?}");
        }
    }

    #[test]
    fn axes_turn_along_or_stay() {
        // A quarter turn about x, then one about the new y, which is the old z.
        let along = EulerSequence::of("xyz").unwrap();
        let about_x = rotation_about(IDENTITY[0], FRAC_PI_2);
        let about_z = rotation_about(IDENTITY[2], FRAC_PI_2);
        let expected = product(&about_z, &about_x);
        close(&along.rotation([FRAC_PI_2, FRAC_PI_2, 0.0]), &expected);
        let stay = EulerSequence::of("XZX").unwrap();
        close(&stay.rotation([FRAC_PI_2, FRAC_PI_2, 0.0]), &expected);
        for wrong in ["", "xy", "xyzx", "xya", "абв"] {
            assert_eq!(EulerSequence::of(wrong), None);
        }
    }

    #[test]
    fn z_is_turned_to_any_direction() {
        for target in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], unit([1.0, -2.0, 0.5])] {
            let rotation = least_turn_to(target);
            for i in 0..3 {
                assert!((rotation[i][2] - target[i]).abs() < 1e-15, "{rotation:?}");
            }
        }
        close(&least_turn_to([0.0, 0.0, 1.0]), &IDENTITY);
    }
}
