//! Named cases and every error.

use std::string::ToString;

use nalgebra::{SMatrix, SVector};

use super::super::*;
use crate::Constraint;

fn default_solve<const N: usize, const M: usize>(
    mass: [[f64; N]; N],
    force: [f64; N],
    a: [[f64; N]; M],
    b: [f64; M],
) -> Result<([f64; N], [f64; M]), SolveError> {
    solve_arrays(&mass, &force, &a, &b)
}

#[test]
fn no_constraint_is_newton() {
    let (a, lambda) = default_solve([[2.0, 0.0], [0.0, 4.0]], [2.0, 8.0], [], []).unwrap();
    assert_eq!((a, lambda), ([1.0, 2.0], []));
    let revealing = RankRevealing::<f64, 2, 0>::new(
        &SMatrix::identity(),
        &SMatrix::zeros(),
        &Tolerance::default(),
    );
    assert_eq!(revealing.unwrap().rank(), 0);
}

#[test]
fn more_rows_than_coordinates() {
    let a = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let (x, _) = default_solve([[1.0, 0.0], [0.0, 3.0]], [5.0, 5.0], a, [1.0, 2.0, 3.0]).unwrap();
    assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14);
}

#[test]
fn an_empty_row_is_redundant_or_a_contradiction() {
    let (x, lambda) = default_solve([[1.0]], [3.0], [[0.0]], [0.0]).unwrap();
    assert_eq!((x, lambda), ([3.0], [0.0]));
    assert!(matches!(
        default_solve([[1.0]], [3.0], [[0.0]], [1.0]),
        Err(SolveError::Inconsistent {
            row: 0,
            rank: 0,
            rows: 1,
            ..
        })
    ));
}

/// A row that is switched off leaves the others as they are, on both paths.
#[test]
fn an_empty_row_is_switched_off() {
    let mass = SMatrix::<f64, 2, 2>::new(2.0, 0.5, 0.5, 1.0);
    let force = SVector::from([3.0, -1.0]);
    let a = SMatrix::<f64, 2, 2>::new(0.0, 0.0, 1.0, 2.0);
    let b = SVector::from([0.0, 0.7]);
    let one = SMatrix::<f64, 1, 2>::new(1.0, 2.0);
    let expected = FullRank::new(&mass, &one).solve(&force, &SVector::from([0.7]));
    let blind = FullRank::new(&mass, &a).solve(&force, &b);
    let checked = solve(&mass, &force, &a, &b, &Tolerance::default()).unwrap();
    for found in [blind, checked] {
        assert!((found.a - expected.a).amax() < 1e-12);
        assert!((found.lambda[1] - expected.lambda[0]).abs() < 1e-12);
        assert!(found.lambda[0].abs() < 1e-12);
    }
}

/// A wheel described by position and angle with the inertia on one of them only
/// (thesis 3.49): x without mass, φ with inertia 2, rolling x = 0.5 φ.
#[test]
fn massless_coordinate() {
    let (x, lambda) =
        default_solve([[0.0, 0.0], [0.0, 2.0]], [1.0, 0.0], [[1.0, -0.5]], [0.0]).unwrap();
    // 2 φ̈ = 0.5 · 1 N at the rim.
    assert!((x[1] - 0.25).abs() < 1e-14 && (x[0] - 0.125).abs() < 1e-14);
    assert!((lambda[0] + 1.0).abs() < 1e-14);
}

#[test]
fn single_precision() {
    let (x, lambda) = solve_arrays::<f32, 2, 2>(
        &[[1.0, 0.0], [0.0, 1.0]],
        &[0.0, -9.81],
        &[[1.0, -1.0], [3.0, -3.0]],
        &[0.0, 0.0],
    )
    .unwrap();
    assert!((x[0] + 4.905).abs() < 1e-5 && (lambda[1] / lambda[0] - 3.0).abs() < 1e-4);
}

#[test]
fn tiny_row_is_still_a_constraint() {
    let (x, _) = default_solve(
        [[1.0, 0.0], [0.0, 1.0]],
        [1.0, 1.0],
        [[1e-13, 0.0], [0.0, 1.0]],
        [0.0, 0.0],
    )
    .unwrap();
    assert!(x[0].abs() < 1e-15 && x[1].abs() < 1e-15);
}

#[test]
fn every_error_says_what_and_how_to_mend() {
    let id = [[1.0, 0.0], [0.0, 1.0]];
    let row = [[1.0, 1.0]];
    let cases = [
        (
            default_solve([[f64::NAN, 0.0], [0.0, 1.0]], [0.0; 2], row, [0.0]),
            "mass matrix M",
        ),
        (
            default_solve(id, [0.0, f64::INFINITY], row, [0.0]),
            "generalised force Qbar is not",
        ),
        (
            default_solve(id, [0.0; 2], [[1.0, f64::NAN]], [0.0]),
            "row 0, column 1",
        ),
        (
            default_solve(id, [0.0; 2], row, [f64::NAN]),
            "right-hand side b",
        ),
        (
            default_solve([[1.0, 0.5], [0.0, 1.0]], [0.0; 2], row, [0.0]),
            "transpose",
        ),
        (
            default_solve([[1.0, 0.0], [0.0, -1.0]], [0.0; 2], row, [0.0]),
            "negative inertia (seen at coordinate 1)",
        ),
        (
            default_solve([[0.0, 1.0], [1.0, 0.0]], [0.0; 2], row, [0.0]),
            "negative inertia",
        ),
        (
            default_solve([[1.0, 0.0], [0.0, 0.0]], [0.0; 2], [[1.0, 0.0]], [0.0]),
            "coordinate 1",
        ),
        (
            default_solve(
                [[1e200, 0.0], [0.0, 1e200]],
                [1e308, 0.0],
                [[1e-200, 0.0]],
                [1e300],
            ),
            "acceleration a",
        ),
    ];
    for (result, words) in cases {
        let message = result.expect_err(words).to_string();
        assert!(message.contains(words), "{message}");
    }
    let error = solve_arrays(&id, &[0.0; 2], &[[1.0, 1.0], [2.0, 2.0]], &[0.0, 1.0]).unwrap_err();
    assert!(error.to_string().contains("contradict"), "{error}");
    // It is an error to the rest of the world.
    let _: &dyn core::error::Error = &error;
}

#[test]
fn lanes_and_duals_take_the_full_rank_path() {
    let d = |x: f64| crate::Dual::<f64, 1>::constant(x);
    let (a, lambda) = solve_full_rank_arrays(
        &[[crate::Dual::variable(2.0, 0)]],
        &[d(6.0)],
        &[] as &[[crate::Dual<f64, 1>; 1]; 0],
        &[],
    );
    assert_eq!((a[0].re, a[0].eps[0], lambda.len()), (3.0, -1.5, 0));
}

#[test]
fn baumgarte_by_kind_of_row() {
    let constraint = Constraint {
        a: SMatrix::<f64, 2, 1>::new(1.0, 1.0),
        b: SVector::from([1.0, 1.0]),
        c: SVector::from([0.1, 0.1]),
        c_dot: SVector::from([0.2, 99.0]),
        holonomic: [true, false],
    };
    let b = Baumgarte {
        omega: 10.0,
        zeta: 0.5,
    }
    .stabilise(&constraint);
    assert!((b[0] - (1.0 - 2.0 - 10.0)).abs() < 1e-14);
    assert!((b[1] - (1.0 - 1.0)).abs() < 1e-14);
}
