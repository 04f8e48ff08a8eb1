//! Bodies that float by their twists: seven positions for six velocities.

use crate::{Real, Scalar};

/// Where the pose of a floating body stands among a system's positions and velocities.
///
/// Its seven positions are the body's origin `x, y, z` and a unit quaternion `x, y, z, w` for
/// its orientation `R`; its six velocities are the twist in the body's own frame, linear `v`,
/// then angular `ω`. They move by `R v` and `½ η ⊗ (ω, 0)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pose {
    /// The place of its first position in `q`.
    pub position: usize,
    /// The place of its first velocity in `v`.
    pub velocity: usize,
}

impl Pose {
    /// With its first position and its first velocity at these places.
    pub const fn at(position: usize, velocity: usize) -> Self {
        Self { position, velocity }
    }
}

/// What [`walk`] hands on: places in `q` and in `v`.
enum Part {
    /// A position with a velocity of its own.
    Single(usize, usize),
    /// A pose.
    Pose(usize, usize),
}

/// Goes through the positions in order.
fn walk(poses: &[Pose], positions: usize, mut take: impl FnMut(Part)) {
    let (mut i, mut j) = (0, 0);
    while i < positions {
        if poses.iter().any(|p| p.position == i && p.velocity == j) {
            take(Part::Pose(i, j));
            (i, j) = (i + 7, j + 6);
        } else {
            take(Part::Single(i, j));
            (i, j) = (i + 1, j + 1);
        }
    }
}

/// `q̇` of positions `q` that move by velocities `v`: `v` itself but at poses.
///
/// # Panics
/// If there are not seven positions for six velocities at each pose, and one for one elsewhere.
///
/// ```
/// use dynamics::{Pose, position_rate};
///
/// // A body at the origin, turned by 90° about z, that moves forwards: along the world's y.
/// let half = 0.5_f64.sqrt();
/// let q = [0.0, 0.0, 0.0, 0.0, 0.0, half, half];
/// let v = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// let rate = position_rate(&[Pose::at(0, 0)], &q, &v);
/// assert!((rate[1] - 2.0).abs() < 1e-15 && rate[0].abs() < 1e-15);
/// ```
#[inline]
pub fn position_rate<T: Scalar, const N: usize, const Q: usize>(
    poses: &[Pose],
    q: &[T; Q],
    v: &[T; N],
) -> [T; Q] {
    let mut rate = [T::zero(); Q];
    // Where nothing floats, which compilers see, no place has to be checked.
    if poses.is_empty() {
        rate.iter_mut().zip(v).for_each(|(rate, v)| *rate = *v);
        return rate;
    }
    walk(poses, Q, |part| match part {
        Part::Single(i, j) => rate[i] = v[j],
        Part::Pose(i, j) => {
            let at = |k: usize| q[i + 3 + k];
            let (eta, w) = ([at(0), at(1), at(2), at(3)], [v[j + 3], v[j + 4], v[j + 5]]);
            rate[i..i + 3].copy_from_slice(&turned(eta, [v[j], v[j + 1], v[j + 2]]));
            let half = T::from_f64(0.5);
            let turning = times(eta, [w[0], w[1], w[2], T::zero()]);
            rate[i + 3..i + 7].copy_from_slice(&turning.map(|x| half * x));
        }
    });
    rate
}

/// As [`position_rate`], with a pull towards unit length on each quaternion, as fast as the
/// body turns: what integrators lose of the length does not add up.
#[inline]
pub(crate) fn steady_rate<T: Real, const N: usize, const Q: usize>(
    poses: &[Pose],
    q: &[T; Q],
    v: &[T; N],
) -> [T; Q] {
    let mut rate = position_rate(poses, q, v);
    for pose in poses {
        let (i, j) = (pose.position + 3, pose.velocity + 3);
        let speed = (v[j] * v[j] + v[j + 1] * v[j + 1] + v[j + 2] * v[j + 2]).sqrt();
        let missing = q[i..i + 4].iter().fold(T::one(), |rest, &x| rest - x * x);
        let pull = T::from_f64(0.5) * speed * missing;
        for k in i..i + 4 {
            rate[k] = pull.mul_add(q[k], rate[k]);
        }
    }
    rate
}

/// Positions `q` moved by velocities `v` for the time `h`: `q + h v`, and at each pose the
/// exponential map of the twist, with the quaternion made a unit again.
///
/// # Panics
/// As [`position_rate`].
///
/// ```
/// use dynamics::{Pose, moved};
///
/// // Half a turn about z, going forwards all the while: a half circle, to the left.
/// let pi = core::f64::consts::PI;
/// let start = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// let q = moved(&[Pose::at(0, 0)], &start, &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0], pi);
/// assert!((q[1] - 2.0).abs() < 1e-15 && (q[5] - 1.0).abs() < 1e-15);
/// ```
#[inline]
pub fn moved<T: Real, const N: usize, const Q: usize>(
    poses: &[Pose],
    q: &[T; Q],
    v: &[T; N],
    h: T,
) -> [T; Q] {
    let mut next = *q;
    if poses.is_empty() {
        let each = next.iter_mut().zip(v);
        each.for_each(|(next, v)| *next = v.mul_add(h, *next));
        return next;
    }
    walk(poses, Q, |part| match part {
        Part::Single(i, j) => next[i] = v[j].mul_add(h, q[i]),
        Part::Pose(i, j) => {
            let of = |from: usize| [h * v[from], h * v[from + 1], h * v[from + 2]];
            let eta = [q[i + 3], q[i + 4], q[i + 5], q[i + 6]];
            let (along, turn) = exponential(of(j), of(j + 3));
            for (k, x) in turned(eta, along).into_iter().enumerate() {
                next[i + k] = q[i + k] + x;
            }
            let eta = times(eta, turn);
            let length = eta.iter().fold(T::zero(), |sum, &x| sum + x * x).sqrt();
            next[i + 3..i + 7].copy_from_slice(&eta.map(|x| x / length));
        }
    });
    next
}

/// Translation and quaternion of the displacement by a twist `v, w`.
fn exponential<T: Real>(v: [T; 3], w: [T; 3]) -> ([T; 3], [T; 4]) {
    let number = T::from_f64;
    let square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    let angle = square.sqrt();
    // sin(φ/2)/φ, (1 − cos φ)/φ², (φ − sin φ)/φ³; their series where these cancel.
    let small = angle < number(0.02);
    let (half_sine, half_cosine) = (number(0.5) * angle).sin_cos();
    let (a, b, c) = if small {
        let s = square;
        (
            number(0.5) - s * (number(1.0 / 48.0) - s * number(1.0 / 3840.0)),
            number(0.5) - s * (number(1.0 / 24.0) - s * number(1.0 / 720.0)),
            number(1.0 / 6.0) - s * (number(1.0 / 120.0) - s * number(1.0 / 5040.0)),
        )
    } else {
        let (sine, _) = angle.sin_cos();
        (
            half_sine / angle,
            number(2.0) * half_sine * half_sine / square,
            (angle - sine) / (square * angle),
        )
    };
    let across = cross(w, v);
    let twice = cross(w, across);
    let along = core::array::from_fn(|k| v[k] + b * across[k] + c * twice[k]);
    (along, [a * w[0], a * w[1], a * w[2], half_cosine])
}

fn cross<T: Scalar>(x: [T; 3], y: [T; 3]) -> [T; 3] {
    [
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    ]
}

/// `R(η) x = x + 2 w (u × x) + 2 u × (u × x)` with `η = (u, w)`.
fn turned<T: Scalar>([x, y, z, w]: [T; 4], a: [T; 3]) -> [T; 3] {
    let u = [x, y, z];
    let once = cross(u, a);
    let twice = cross(u, once);
    let two = T::from_f64(2.0);
    core::array::from_fn(|k| a[k] + two * (w * once[k] + twice[k]))
}

/// The product of two quaternions `x, y, z, w`.
fn times<T: Scalar>([x, y, z, w]: [T; 4], [a, b, c, d]: [T; 4]) -> [T; 4] {
    [
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: [Pose; 1] = [Pose::at(1, 1)];

    /// The exponential map is what the rates lead to: many small steps of these make one large.
    #[test]
    fn a_step_is_what_its_rates_lead_to() {
        for size in [1e-3, 0.019, 0.021, 1.0, 4.0] {
            let step: [f64; 8] = [0.3, 0.4, -0.2, 0.7, 0.5, -0.6, 0.3, 0.9].map(|x| size * x);
            let start = [0.1, 1.0, 2.0, 3.0, 0.5, -0.5, 0.5, 0.5, -1.0];
            let mut y: [f64; 9] = start;
            let count = 2000;
            let rate = |_: f64, y: &[f64; 9]| {
                Ok::<_, core::convert::Infallible>(position_rate(&BODY, y, &step))
            };
            for _ in 0..count {
                y = crate::integrate::rk4_step(rate, 0.0, &y, 1.0 / f64::from(count)).unwrap();
            }
            let found = moved(&BODY, &start, &step, 1.0);
            for (found, expected) in found.into_iter().zip(y) {
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{size}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn a_quaternion_that_is_too_long_comes_back() {
        let q = [0.0, 0.0, 0.0, 0.0, 1.1, 0.0, 0.0, 0.0, 0.0];
        let v = [0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
        let rate = steady_rate(&BODY, &q, &v);
        assert!((rate[4] + 1.1 * 0.21).abs() < 1e-15, "{}", rate[4]);
    }
}
