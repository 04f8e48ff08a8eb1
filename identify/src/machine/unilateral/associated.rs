//! The associated law: a contact that slides lifts by `μ` times its slip.
//!
//! Its impulses are those within the friction cones at which
//!
//! ```text
//! ½ pᵀ (W + ε) p + qᵀ p
//! ```
//!
//! is least (Anitescu, Math. Program. 105, 2006): a convex problem with one solution. An interior-point
//! method finds it to about the root of what its own accuracy is; Newton's method goes on from there.
//! These impulses take energy as Coulomb's do, and leave nothing inside of a plane.

use super::law::Law;
use super::newton::{self, Outcome};
use super::solve::Problem;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::DVector;

/// `ε`, relative to the mobility: what leaves one solution where forces can be shared in many ways.
const SOFT: f64 = 1e-9;
/// What the solver is asked for, of numbers about one.
const ACCURACY: f64 = 1e-11;

/// Solves it for velocities about `scale` m/s, until nothing is missed by more than `settled` m/s or
/// nothing comes closer. `None` if the solver ends without an answer.
pub(super) fn solve(problem: &Problem<'_>, scale: f64, settled: f64) -> Option<Outcome> {
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
    found.then(|| newton::solve(problem, Law::Associated, impulse, settled))
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
