//! The three benchmark systems of thesis 5.2.1, written by hand: `M, A, b`, the
//! known force and their derivatives in the physical parameters.
#![allow(dead_code, reason = "examples and benches use some of it")]

use gp::PointTangent;

/// One state of a system: what [`gp::GaussPoint::new`] wants.
pub struct State {
    /// `M`, row-major.
    pub mass: Vec<f64>,
    /// `A`, row-major.
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    /// Known force `Q_K`.
    pub known: Vec<f64>,
    /// One per physical parameter.
    pub tangents: Vec<PointTangent>,
}

impl State {
    /// Forget the known force and its derivatives.
    pub fn without_known(mut self) -> Self {
        self.known.fill(0.0);
        self.tangents.iter_mut().for_each(|t| t.known.fill(0.0));
        self
    }
}

const G: f64 = 9.81;

/// Particle of mass 3 on `q3 = p1 q1² + p2 q2² + p3 q1 q2 + p4 q1 + p5 q2 + p6 cos(p7 q1)`.
/// `x = [q, v, u]`.
pub fn surface(x: &[f64], p: &[f64]) -> State {
    let (q1, q2, v1, v2) = (x[0], x[1], x[3], x[4]);
    let m = 3.0;
    let (s, c) = (p[6] * q1).sin_cos();
    let a = vec![
        2.0 * p[0] * q1 + p[2] * q2 + p[3] - p[5] * p[6] * s,
        2.0 * p[1] * q2 + p[2] * q1 + p[4],
        -1.0,
    ];
    let b = vec![
        -2.0 * p[0] * v1 * v1 - 2.0 * p[1] * v2 * v2 - 2.0 * p[2] * v1 * v2
            + p[5] * p[6] * p[6] * v1 * v1 * c,
    ];
    // (∂A1, ∂A2, ∂b) for each parameter.
    let d = [
        (2.0 * q1, 0.0, -2.0 * v1 * v1),
        (0.0, 2.0 * q2, -2.0 * v2 * v2),
        (q2, q1, -2.0 * v1 * v2),
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (-p[6] * s, 0.0, p[6] * p[6] * v1 * v1 * c),
        (
            -p[5] * s - p[5] * p[6] * q1 * c,
            0.0,
            p[5] * v1 * v1 * (2.0 * p[6] * c - p[6] * p[6] * q1 * s),
        ),
    ];
    let tangents = d
        .iter()
        .map(|&(a1, a2, db)| PointTangent {
            a: vec![a1, a2, 0.0],
            b: vec![db],
            ..PointTangent::zero(3, 1)
        })
        .collect();
    State {
        mass: vec![m, 0.0, 0.0, 0.0, m, 0.0, 0.0, 0.0, m],
        a,
        b,
        known: vec![x[6], x[7], x[8] - m * G],
        tangents,
    }
}

/// Height of the surface minus `q3`.
pub fn surface_gap(x: &[f64], p: &[f64]) -> f64 {
    let (q1, q2) = (x[0], x[1]);
    p[0] * q1 * q1
        + p[1] * q2 * q2
        + p[2] * q1 * q2
        + p[3] * q1
        + p[4] * q2
        + p[5] * (p[6] * q1).cos()
        - x[2]
}

/// Velocity-quadratic damping `-0.2 m |v| v` of the particle (the true, unknown `Q_z`).
pub fn surface_damping(x: &[f64]) -> Vec<f64> {
    let speed = (x[3] * x[3] + x[4] * x[4] + x[5] * x[5]).sqrt();
    x[3..6].iter().map(|v| -3.0 * 0.2 * speed * v).collect()
}

/// 2-D unicycle, mass 1, `x = [v1, v2, q3, v3, u1, u2]`, `p = [R, I_c]`.
pub fn unicycle(x: &[f64], p: &[f64]) -> State {
    let (v1, v2, v3, u1, u2) = (x[0], x[1], x[3], x[4], x[5]);
    let (s, c) = x[2].sin_cos();
    let (r, ic) = (p[0], p[1]);
    let mass = vec![1.0, 0.0, -r * s, 0.0, 1.0, r * c, -r * s, r * c, ic];
    let w = v3 * v3;
    let dr = PointTangent {
        mass: vec![0.0, 0.0, -s, 0.0, 0.0, c, -s, c, 0.0],
        known: vec![w * c, w * s, 0.0],
        ..PointTangent::zero(3, 1)
    };
    let dic = PointTangent {
        mass: vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        ..PointTangent::zero(3, 1)
    };
    State {
        mass,
        a: vec![s, -c, 0.0],
        b: vec![-v1 * v3 * c - v2 * v3 * s],
        known: vec![r * w * c + c * u1, r * w * s + s * u1, u2],
        tangents: vec![dr, dic],
    }
}

/// The unicycle with its wheel mounted 0.3 rad askew: the other constraint of the reference.
pub fn skewed_unicycle(x: &[f64], p: &[f64]) -> State {
    let (s, c) = (x[2] + 0.3).sin_cos();
    State {
        a: vec![s, -c, 0.0],
        b: vec![-x[3] * (x[0] * c + x[1] * s)],
        ..unicycle(x, p)
    }
}

/// Controlled Duffing oscillator, masses 2 and 1, `x = [q1, q2, v1, v2, t]`,
/// `p = [p1, p2, p3, k1, k2, c1, c2]`, constraint `q1 - q2 = p1 e^{-p2 t} sin p3 t`.
pub fn duffing(x: &[f64], p: &[f64]) -> State {
    let (q1, q2, v1, v2, t) = (x[0], x[1], x[2], x[3], x[4]);
    let e = (-p[1] * t).exp();
    let (s, c) = (p[2] * t).sin_cos();
    // c(t) = p1 e^{-p2 t} sin(p3 t); b is its second time derivative.
    let curve = p[1] * p[1] * s - 2.0 * p[1] * p[2] * c - p[2] * p[2] * s;
    let db = [
        e * curve,
        p[0] * e * (-t * curve + 2.0 * p[1] * s - 2.0 * p[2] * c),
        p[0] * e
            * (p[1] * p[1] * t * c - 2.0 * p[1] * c + 2.0 * p[1] * p[2] * t * s
                - 2.0 * p[2] * s
                - p[2] * p[2] * t * c),
    ];
    let mut tangents: Vec<PointTangent> = db
        .iter()
        .map(|&v| PointTangent {
            b: vec![v],
            ..PointTangent::zero(2, 1)
        })
        .collect();
    let known = [
        vec![-(q1 - q2), q1 - q2],
        vec![0.0, -q2],
        vec![-(v1 - v2), v1 - v2],
        vec![0.0, -v2],
    ];
    tangents.extend(known.map(|known| PointTangent {
        known,
        ..PointTangent::zero(2, 1)
    }));
    State {
        mass: vec![2.0, 0.0, 0.0, 1.0],
        a: vec![1.0, -1.0],
        b: vec![p[0] * e * curve],
        known: vec![
            -p[3] * (q1 - q2) - p[5] * (v1 - v2),
            p[3] * (q1 - q2) - p[4] * q2 + p[5] * (v1 - v2) - p[6] * v2,
        ],
        tangents,
    }
}
