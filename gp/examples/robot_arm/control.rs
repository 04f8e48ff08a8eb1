//! Reference trajectories in task space and the controller that tracks them.

use crate::arm::{Arm, N, PLANE, State, Terms, Vector};
use dynamics::nalgebra::{SMatrix, SVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

type V3 = SVector<f64, 3>;

/// Largest acceleration of the reference, m/s². The published bounds (segments of 0.5
/// to 1 s, 0.5 m/s²) exclude one another over a metre. With 1 m/s² and longer
/// segments where needed, the analytical model errs by 0.57 rad/s² as published.
const ACCELERATION: f64 = 1.0;
/// The reference runs this far below the plane, m: the tip presses.
const DEPTH: f64 = 5e-4;
/// Natural frequency of the task-space error, 1/s, critically damped.
const OMEGA: f64 = 100.0;
/// Damping of the least-squares inverse.
const LEAST_SQUARES: f64 = 1e-3;
/// Stiffness of the posture in the null space, 1/s².
const POSTURE: [f64; N] = [0.0, 1e4, 1e4, 0.0, 1e4, 0.0, 0.0];
/// Torque limits, N·m.
const LIMITS: [f64; N] = [320.0, 320.0, 176.0, 176.0, 110.0, 40.0, 40.0];
/// Rest posture, °.
const REST: [f64; N] = [85.0, 50.0, -10.0, -100.0, -170.0, -25.0, -100.0];

/// Rest posture, rad.
pub fn rest() -> [f64; N] {
    REST.map(f64::to_radians)
}

/// What the tip is to do.
#[derive(Clone, Copy)]
pub struct Reference {
    pub position: V3,
    pub velocity: V3,
    pub acceleration: V3,
}

/// A straight line with a trapezoidal velocity profile, at rest at both ends.
#[derive(Clone, Copy)]
pub struct Segment {
    from: V3,
    to: V3,
    pub seconds: f64,
}

/// A point of the working area, drawn uniformly.
fn target(rng: &mut ChaCha8Rng) -> V3 {
    V3::from([
        rng.random_range(-0.5..0.5),
        rng.random_range(0.4..0.6),
        PLANE - DEPTH,
    ])
}

/// A chain of segments between random points, begun at `(0, 0.5)`. Travel times
/// are drawn from 0.5 to 1 s and lengthened where the acceleration demands it.
pub fn path(count: usize, rng: &mut ChaCha8Rng) -> Vec<Segment> {
    let mut from = start();
    (0..count)
        .map(|_| {
            let to = target(rng);
            let shortest = (4.0 * (to - from).norm() / ACCELERATION).sqrt();
            let seconds = rng.random_range(0.5..1.0f64).max(1.1 * shortest);
            let segment = Segment { from, to, seconds };
            from = to;
            segment
        })
        .collect()
}

fn start() -> V3 {
    V3::from([0.0, 0.5, PLANE - DEPTH])
}

impl Segment {
    /// The reference `t` seconds after the beginning.
    pub fn at(&self, t: f64) -> Reference {
        let (d, total) = (self.to - self.from, self.seconds);
        // s(t) runs from 0 to 1 with acceleration ±a, a T² ≥ 4.
        let a = ACCELERATION / d.norm().max(1e-9);
        let ramp = 0.5 * (total - (total * total - 4.0 / a).max(0.0).sqrt());
        let (s, ds, dds) = if t < ramp {
            (0.5 * a * t * t, a * t, a)
        } else if t < total - ramp {
            (a * ramp * (t - 0.5 * ramp), a * ramp, 0.0)
        } else {
            let left = (total - t).max(0.0);
            let slow = if left > 0.0 { -a } else { 0.0 };
            (1.0 - 0.5 * a * left * left, a * left, slow)
        };
        Reference {
            position: self.from + d * s,
            velocity: d * ds,
            acceleration: d * dds,
        }
    }
}

/// `J^T (J J^T + λ²)⁻¹`.
fn damped_inverse(j: &SMatrix<f64, 6, N>) -> SMatrix<f64, N, 6> {
    let gram = j * j.transpose() + SMatrix::<f64, 6, 6>::identity() * LEAST_SQUARES.powi(2);
    // Positive definite by the damping, so that the factorisation exists.
    match gram.cholesky() {
        Some(factor) => j.transpose() * factor.inverse(),
        None => SMatrix::zeros(),
    }
}

/// Half the sum of `r_i × r_d,i`: the rotation that is missing, for small angles.
fn turn(from: &SMatrix<f64, 3, 3>, to: &SMatrix<f64, 3, 3>) -> V3 {
    (0..3)
        .map(|i| from.column(i).cross(&to.column(i)))
        .fold(V3::zeros(), |sum, c| sum + c)
        * 0.5
}

/// Tool axis straight down, the other axes as near to the rest posture as can be.
fn upright(terms: &Terms) -> SMatrix<f64, 3, 3> {
    let down = V3::from([0.0, 0.0, -1.0]);
    let x = terms.rotation.column(0).into_owned();
    let x = (x - down * x.dot(&down)).normalize();
    SMatrix::from_columns(&[x, down.cross(&x), down])
}

fn beside(linear: V3, angular: V3) -> SVector<f64, 6> {
    SVector::from_fn(|i, _| if i < 3 { linear[i] } else { angular[i - 3] })
}

/// The controller of thesis 5.3.2: inverse dynamics in task space, posture in its null space.
pub struct Controller<'a> {
    arm: &'a Arm,
    orientation: SMatrix<f64, 3, 3>,
}

impl<'a> Controller<'a> {
    /// Holds the tool upright. It knows the arm but neither friction nor contact.
    pub fn new(arm: &'a Arm) -> Self {
        let at_rest = State {
            q: rest(),
            ..State::zero()
        };
        let orientation = upright(&arm.terms(&at_rest));
        Self { arm, orientation }
    }

    /// Joint angles with the tip on the plane at the first point, by inverse kinematics.
    pub fn start(&self) -> State {
        let mut x = State {
            q: rest(),
            ..State::zero()
        };
        let mut goal = start();
        goal[2] = PLANE;
        for _ in 0..200 {
            let terms = self.arm.terms(&x);
            let error = beside(
                goal - terms.position,
                turn(&terms.rotation, &self.orientation),
            );
            let step = damped_inverse(&terms.jacobian) * error;
            (0..N).for_each(|i| x.q[i] += step[i]);
        }
        x
    }

    /// Torques for a reference.
    pub fn torque(&self, x: &State, r: &Reference) -> [f64; N] {
        let terms = self.arm.terms(x);
        let v = Vector::from(x.v);
        let rate = terms.jacobian * v;
        let (linear, angular) = (rate.fixed_rows::<3>(0), rate.fixed_rows::<3>(3));
        let (stiffness, damping) = (OMEGA * OMEGA, 2.0 * OMEGA);
        let wanted = beside(
            r.acceleration
                + (r.velocity - linear) * damping
                + (r.position - terms.position) * stiffness,
            turn(&terms.rotation, &self.orientation) * stiffness - angular * damping,
        );
        let inverse = damped_inverse(&terms.jacobian);
        let rest = rest();
        let posture = Vector::from_fn(|i, _| {
            POSTURE[i] * (rest[i] - x.q[i]) - 2.0 * POSTURE[i].sqrt() * x.v[i]
        });
        let null = SMatrix::<f64, N, N>::identity() - inverse * terms.jacobian;
        let a = inverse * (wanted - terms.drift) + null * posture;
        let u = terms.mass * a - terms.bias;
        std::array::from_fn(|i| u[i].clamp(-LIMITS[i], LIMITS[i]))
    }
}
