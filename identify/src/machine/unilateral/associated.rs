//! The associated law: a contact that slides lifts by `μ` times its slip.
//!
//! Its impulses are those within the friction cones at which
//!
//! ```text
//! ½ pᵀ (W + ε) p + qᵀ p
//! ```
//!
//! is least (Anitescu, Math. Program. 105, 2006): a convex problem with one solution, which an interior-point
//! method finds. They take energy as Coulomb's do, and leave nothing inside of a plane.

use super::cone;
use super::solve::Problem;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DVector, Vector3};

/// `ε`, relative to the mobility: what leaves one solution where forces can be shared in many ways.
const SOFT: f64 = 1e-9;
/// What the solver is asked for, of numbers about one.
const ACCURACY: f64 = 1e-11;

/// What solves it.
pub(super) struct Convex {
    /// `p`, `3c`.
    pub impulse: DVector<f64>,
    /// By how much it misses the law, m/s.
    pub residual: f64,
}

/// Solves it for velocities about `scale` m/s. `None` if the solver ends without an answer.
pub(super) fn solve(problem: &Problem<'_>, scale: f64) -> Option<Convex> {
    let size = problem.velocity.len();
    let mobility = problem.mobility.trace() / size as f64;
    let upper = (0..size).flat_map(|column| (0..=column).map(move |row| (row, column)));
    let entry = |(row, column): (usize, usize)| {
        let soft = if row == column { SOFT } else { 0.0 };
        let entry = problem.mobility[(row, column)] / mobility;
        (row, column, entry + soft)
    };
    let square = sparse(size, upper.map(entry));
    let linear: Vec<f64> = problem.velocity.iter().map(|q| q / scale).collect();
    let (cones, rows) = cones(problem.friction.as_slice());
    let (rows, bounds) = (sparse(size, rows.into_iter()), vec![0.0; size]);
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: ACCURACY,
        tol_gap_rel: ACCURACY,
        tol_feas: ACCURACY,
        ..DefaultSettings::default()
    };
    let solver = DefaultSolver::new(&square, &linear, &rows, &bounds, &cones, settings);
    let mut solver = solver.ok()?;
    solver.solve();
    let status = solver.solution.status;
    let found = matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    let impulse = DVector::from_column_slice(&solver.solution.x) * (scale / mobility);
    found.then(|| Convex {
        residual: residual(problem, &impulse),
        impulse,
    })
}

/// By how much impulses change if they go against the velocity and back onto the cone, as a velocity,
/// m/s.
fn residual(problem: &Problem<'_>, impulse: &DVector<f64>) -> f64 {
    let miss = |i: usize| {
        let p: Vector3<f64> = impulse.fixed_rows::<3>(3 * i).into_owned();
        let rho = problem.block(i).trace();
        let z = p - problem.moving(i, impulse) / rho;
        rho * (p - cone::onto(&z, problem.friction[i])).amax()
    };
    (0..problem.friction.len()).map(miss).fold(0.0, f64::max)
}

/// A matrix entry: row, column, value.
type Entry = (usize, usize, f64);

/// The cones `K`, and `−G` of `G p ∈ K`: `(μ pₙ, pₜ)` of a contact in a round one; without
/// friction no `pₜ`, and `pₙ` not below zero.
fn cones(friction: &[f64]) -> (Vec<SupportedConeT<f64>>, Vec<Entry>) {
    let (mut cones, mut rows) = (Vec::new(), Vec::new());
    for (i, &mu) in friction.iter().enumerate() {
        let [first, second, normal] = [0, 1, 2].map(|k| 3 * i + k);
        if mu > 0.0 {
            cones.push(SupportedConeT::SecondOrderConeT(3));
            rows.push((first, normal, -mu));
            rows.extend([(second, first, -1.0), (normal, second, -1.0)]);
        } else {
            cones.push(SupportedConeT::ZeroConeT(2));
            cones.push(SupportedConeT::NonnegativeConeT(1));
            rows.extend([first, second, normal].map(|k| (k, k, -1.0)));
        }
    }
    (cones, rows)
}

/// A square matrix from its entries.
fn sparse(size: usize, entries: impl Iterator<Item = Entry>) -> CscMatrix<f64> {
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (row, column, value) in entries {
        rows.push(row);
        columns.push(column);
        values.push(value);
    }
    CscMatrix::new_from_triplets(size, size, rows, columns, values)
}
