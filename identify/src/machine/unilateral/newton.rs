//! All laws at once, by Newton's method on what is smooth in pieces.
//!
//! With `ρ` of every contact, m/s per N s, the laws are the zeros of
//!
//! ```text
//! F = ρ (p − g(z))        z = p − u/ρ
//! ```
//!
//! where `g` is the [`Law`]'s aim (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991). `F` is
//! a velocity: `u` where a contact sticks, and everywhere by how much the laws are missed.
//!
//! Where contacts can share a force in more than one way, `W` is singular. What is solved has
//! `u + ε (p − p₀)` in place of `u`: of all impulses those near to `p₀`, at the price of `ε` times
//! the way there. From what is found the same is done again, until the price is nothing (proximal
//! points); where a round fails, the next one has a larger `ε`.

use super::law::Law;
use super::solve::Problem;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// `ε` of the first round, relative to the mobility: as small as rounding allows.
const PROXIMAL: f64 = 1e-7;
/// A round that comes no closer is followed by one with so many times its `ε`.
const HARDER: f64 = 10.0;
/// Rounds at most.
const ROUNDS: usize = 6;
/// Steps in one round at most.
const STEPS: usize = 40;
/// Halvings of a step that brings the laws no closer, at most.
const HALVINGS: usize = 8;
/// A step is long enough if it takes this share of itself off what was missed.
const DECREASE: f64 = 1e-4;

/// What Newton's method led to.
pub(super) struct Outcome {
    /// `p`, `3c`.
    pub impulse: DVector<f64>,
    /// The largest `|F|` without `ε`, m/s.
    pub residual: f64,
    pub steps: usize,
}

/// From `start` until no contact misses `law` by more than `settled` m/s, or the best on the way.
pub(super) fn solve(problem: &Problem<'_>, law: Law, start: DVector<f64>, settled: f64) -> Outcome {
    let exact = Laws::new(problem, law, 0.0);
    let mut best = Outcome {
        residual: exact.residual(&start),
        impulse: start,
        steps: 0,
    };
    let mut epsilon = PROXIMAL;
    for _ in 0..ROUNDS {
        let laws = Laws::new(problem, law, epsilon);
        let (impulse, steps) = laws.round(&best.impulse, settled);
        let residual = exact.residual(&impulse);
        best.steps += steps;
        let closer = residual < best.residual / 2.0;
        if residual < best.residual {
            (best.impulse, best.residual) = (impulse, residual);
        }
        if best.residual <= settled {
            break;
        }
        epsilon *= if closer { 1.0 } else { HARDER };
    }
    best
}

/// The laws of a problem.
struct Laws<'a> {
    problem: &'a Problem<'a>,
    law: Law,
    /// `ρ`, per contact.
    rho: Vec<f64>,
    /// `ε/ρ`.
    epsilon: f64,
}

/// Impulses on the way, and what they lead to.
struct Place {
    impulse: DVector<f64>,
    /// `u + ε (p − p₀)`.
    moving: DVector<f64>,
    /// `F`.
    missed: DVector<f64>,
}

impl<'a> Laws<'a> {
    fn new(problem: &'a Problem<'a>, law: Law, epsilon: f64) -> Self {
        let contacts = 0..problem.friction.len();
        let rho = contacts.map(|i| problem.block(i).trace()).collect();
        Self {
            problem,
            law,
            rho,
            epsilon,
        }
    }

    /// The largest `|F|`, m/s.
    fn residual(&self, impulse: &DVector<f64>) -> f64 {
        self.place(impulse.clone(), impulse).missed.amax()
    }

    /// From `center`, with `ε` around it; the impulses, and how many steps led there.
    fn round(&self, center: &DVector<f64>, settled: f64) -> (DVector<f64>, usize) {
        let mut here = self.place(center.clone(), center);
        let mut best = (here.missed.norm(), here.impulse.clone());
        for step in 0..STEPS {
            if here.missed.amax() <= settled {
                return (here.impulse, step);
            }
            let Some(way) = self.slope(&here).lu().solve(&here.missed) else {
                return (best.1, step);
            };
            here = self.step(&here, &way, center);
            if here.missed.norm() < best.0 {
                best = (here.missed.norm(), here.impulse.clone());
            }
        }
        (best.1, STEPS)
    }

    /// As much of `way` as brings the laws closer. Where no part of it does, all of it: it leads to
    /// other pieces of the laws.
    fn step(&self, here: &Place, way: &DVector<f64>, center: &DVector<f64>) -> Place {
        let size = here.missed.norm();
        let parts = (0..=HALVINGS).map(|halvings| 0.5_f64.powi(halvings as i32));
        let mut places = parts.map(|part| {
            let there = self.place(&here.impulse - way * part, center);
            let closer = there.missed.norm() <= (1.0 - DECREASE * part) * size;
            (closer, there)
        });
        match places.find(|(closer, _)| *closer) {
            Some((_, there)) => there,
            None => self.place(&here.impulse - way, center),
        }
    }

    fn place(&self, impulse: DVector<f64>, center: &DVector<f64>) -> Place {
        let mut moving = self.problem.mobility * &impulse + self.problem.velocity;
        for (row, value) in moving.iter_mut().enumerate() {
            *value += self.epsilon * self.rho[row / 3] * (impulse[row] - center[row]);
        }
        let mut missed = DVector::zeros(impulse.len());
        for (i, rho) in self.rho.iter().enumerate() {
            let z = self.aim(i, &impulse, &moving);
            let goal = self.law.goal(&z, self.problem.friction[i]);
            let off = (impulse.fixed_rows::<3>(3 * i) - goal) * *rho;
            missed.fixed_rows_mut::<3>(3 * i).copy_from(&off);
        }
        Place {
            impulse,
            moving,
            missed,
        }
    }

    /// `z` of contact `i`.
    fn aim(&self, i: usize, impulse: &DVector<f64>, moving: &DVector<f64>) -> Vector3<f64> {
        impulse.fixed_rows::<3>(3 * i) - moving.fixed_rows::<3>(3 * i) / self.rho[i]
    }

    /// `∂F/∂p = ρ (1 − ∂g/∂z) + ∂g/∂z ∂u/∂p`, `3c×3c`: of rows that stick `∂u/∂p`, as it is there.
    fn slope(&self, here: &Place) -> DMatrix<f64> {
        let mut slope = self.problem.mobility.clone();
        for row in 0..slope.nrows() {
            slope[(row, row)] += self.epsilon * self.rho[row / 3];
        }
        for (i, &rho) in self.rho.iter().enumerate() {
            let z = self.aim(i, &here.impulse, &here.moving);
            let of_goal = self.law.slope(&z, self.problem.friction[i]);
            let mut rows = of_goal * slope.fixed_rows::<3>(3 * i);
            let mut own = rows.fixed_columns_mut::<3>(3 * i);
            own += (Matrix3::identity() - of_goal) * rho;
            slope.fixed_rows_mut::<3>(3 * i).copy_from(&rows);
        }
        slope
    }
}
