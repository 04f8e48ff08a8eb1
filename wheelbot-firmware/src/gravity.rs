//! Tilt from four accelerometers by least squares (6.3.2): which way is up.

use crate::imu::{COUNT, Mounting};
use crate::vector::{Vector, cross, difference, dot, scaled, sum};
use dynamics::Real;

/// `X₁*` of [6.14]: the weights with which the accelerometers' readings add up to gravity.
///
/// [6.14] wants the first column of `Pᵀ (P Pᵀ)⁻¹` with `P = [1 … 1; p₁ … p₄]`. For four sensors `P`
/// is square and the weights solve `Σ wᵢ = 1`, `Σ wᵢ pᵢ = 0`: they are the barycentric coordinates of
/// the pivot in the tetrahedron of the IMUs, ratios of volumes. Rotation drops out whatever it is.
/// Not finite where the four lie in a plane.
pub fn weights<T: Real>(mountings: &[Mounting<T>; COUNT]) -> [T; COUNT] {
    let p = mountings.map(|mounting| mounting.position);
    let volume = |a: Vector<T>, b: Vector<T>, c: Vector<T>| dot(a, cross(b, c));
    let whole = volume(
        difference(p[1], p[0]),
        difference(p[2], p[0]),
        difference(p[3], p[0]),
    );
    // Of the tetrahedra that have the pivot in place of one corner.
    [
        volume(p[1], p[2], p[3]) / whole,
        -(volume(p[0], p[2], p[3]) / whole),
        volume(p[0], p[1], p[3]) / whole,
        -(volume(p[0], p[1], p[2]) / whole),
    ]
}

/// `ᴮĝ = Σ wᵢ (ᴮmᵢ − ᴮp̈_W)`, m/s², [6.5] in [6.14], with the sign of [6.15]: upright it is
/// `(0, 0, 9.81)`.
pub fn estimate<T: Real>(
    weights: &[T; COUNT],
    felt: &[Vector<T>; COUNT],
    pivot: Vector<T>,
) -> Vector<T> {
    let mut gravity = scaled(-T::one(), pivot);
    for (weight, reading) in weights.iter().zip(felt) {
        gravity = sum(gravity, scaled(*weight, *reading));
    }
    gravity
}

/// Roll and pitch from gravity in body axes, [6.16].
pub fn tilt<T: Real>(gravity: Vector<T>) -> [T; 2] {
    let [x, y, z] = gravity;
    [y.atan2((x * x + z * z).sqrt()), (-x).atan2(z)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imu::mountings;
    use crate::vector::Attitude;

    /// The firmware's constants, to the digits that it has (wheelbot-v2.5, e8aebc5).
    #[test]
    fn weights_are_the_published_ones() {
        let found: [f64; COUNT] = weights(&mountings());
        for (found, published) in found.iter().zip([0.0163, 0.0163, 0.4837, 0.4837]) {
            assert!((found - published).abs() < 5e-5, "{found}");
        }
    }

    #[test]
    fn turning_drops_out() {
        let mountings = mountings::<f64>();
        let (omega, alpha) = ([3.0, -2.0, 5.0], [40.0, -70.0, 20.0]);
        let attitude = Attitude::new(0.3, -0.2);
        let gravity = attitude.to_body([0.0, 0.0, 9.81]);
        let pivot = [1.0, -2.0, 0.5];
        let felt = mountings.map(|m| {
            let turning = sum(
                cross(alpha, m.position),
                cross(omega, cross(omega, m.position)),
            );
            sum(sum(gravity, pivot), turning)
        });
        let [roll, pitch] = tilt(estimate(&weights(&mountings), &felt, pivot));
        assert!((roll - 0.3).abs() < 1e-12 && (pitch + 0.2).abs() < 1e-12);
    }
}
