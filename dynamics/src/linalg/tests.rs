use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

use super::*;

/// 4×3 matrices with elements of order 1.
fn tall() -> impl Strategy<Value = SMatrix<f64, 4, 3>> {
    proptest::array::uniform12(-2.0..2.0).prop_map(|e| SMatrix::from_fn(|i, j| e[3 * i + j]))
}

fn close<const R: usize, const C: usize>(
    x: &SMatrix<f64, R, C>,
    y: &SMatrix<f64, R, C>,
    tolerance: f64,
) -> bool {
    (x - y).amax() <= tolerance
}

proptest! {
    #![proptest_config(crate::property_tests())]

    #[test]
    fn products_agree_with_nalgebra(a in tall(), b in tall()) {
        prop_assert!(close(&mul_transpose(&a, &b), &(a * b.transpose()), 1e-14));
        prop_assert!(close(&transpose_mul(&a, &b), &(a.transpose() * b), 1e-14));
        prop_assert!(close(&mul(&a, &b.transpose()), &(a * b.transpose()), 1e-14));
        prop_assert!(close(&add(&a, &b), &(a + b), 0.0));
        prop_assert!(close(&sub(&a, &b), &(a - b), 0.0));
        prop_assert!((norm_squared(&a) - a.norm_squared()).abs() < 1e-13);
        let d = [0.5, 2.0, -1.0, 3.0];
        let weighted = a.transpose() * SMatrix::<f64, 4, 4>::from_diagonal(&SVector::from(d)) * a;
        prop_assert!(close(&gram(&a, &d), &weighted, 1e-13));
    }

    #[test]
    fn ldlt_solves_as_nalgebra_does(a in tall(), b in proptest::array::uniform4(-2.0..2.0)) {
        let m = a * a.transpose() + SMatrix::<f64, 4, 4>::identity() * 0.1;
        let b = SVector::from(b);
        let factor = Ldlt::new(&m);
        let other = m.cholesky().unwrap().solve(&b);
        prop_assert!(close(&factor.solve_vector(&b), &other, 1e-11 * (1.0 + other.amax())));
        prop_assert!(factor.is_positive_definite(&m, 0.0));
        let determinant: f64 = factor.pivots().iter().product();
        prop_assert!((determinant - m.determinant()).abs() < 1e-10 * m.determinant().abs());
    }

    /// A tree of two branches, whose mass matrix is that of four bodies at distances `a`.
    #[test]
    fn ltdl_solves_as_nalgebra_does_and_keeps_the_zeros(
        a in tall(),
        b in proptest::array::uniform8(-2.0..2.0),
    ) {
        static CARRIES: [[bool; 4]; 4] = ancestors([0, 0, 0, 2]);
        let mut m = SMatrix::<f64, 4, 4>::identity() * 0.1;
        for (body, carries) in CARRIES.iter().enumerate() {
            let moved = |i| i == body || carries[i];
            let jacobian = SMatrix::<f64, 3, 4>::from_fn(|k, i| if moved(i) { a[(i, k)] } else { 0.0 });
            m += jacobian.transpose() * jacobian;
        }
        let b = SMatrix::<f64, 4, 2>::from_row_slice(&b);
        let mut x = to_rows(&b);
        Ltdl::new(&to_rows(&m), &CARRIES).solve(&mut x);
        let other = m.cholesky().unwrap().solve(&b);
        prop_assert!(close(&from_rows(&x), &other, 1e-11 * (1.0 + other.amax())));
    }

    #[test]
    fn svd_decomposes(a in tall()) {
        let svd = Svd::new(&a);
        let sigma = SMatrix::<f64, 3, 3>::from_diagonal(&SVector::from(svd.sigma));
        prop_assert!(close(&(svd.u * sigma * svd.v.transpose()), &a, 1e-14));
        prop_assert!(close(&(svd.v.transpose() * svd.v), &identity(), 1e-14));
        prop_assert!(svd.sigma.is_sorted_by(|x, y| x >= y));
        let mut other = a.singular_values();
        other.as_mut_slice().sort_by(|x, y| y.total_cmp(x));
        prop_assert!(close(&SVector::from(svd.sigma), &other, 1e-13));
    }
}

#[test]
fn ldlt_refuses_indefinite_and_nan() {
    let indefinite = SMatrix::<f64, 2, 2>::new(1.0, 2.0, 2.0, 1.0);
    assert!(!Ldlt::new(&indefinite).is_positive_definite(&indefinite, 0.0));
    let nan = SMatrix::<f64, 2, 2>::new(1.0, f64::NAN, f64::NAN, 1.0);
    assert!(!Ldlt::new(&nan).is_positive_definite(&nan, 0.0));
}

#[test]
fn svd_finds_rank_whatever_the_scale_of_columns() {
    // Columns 1 and 3 are parallel; column 2 is 1e-200 of the others.
    let a = SMatrix::<f64, 3, 3>::new(1.0, 1e-200, 2.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.0);
    let svd = Svd::new(&a);
    assert_eq!(svd.rank(1e-12), 1);
    let graded = SMatrix::<f64, 2, 2>::new(1.0, 1e-20, 0.0, 1e-20);
    let sigma = Svd::new(&graded).sigma;
    // det = 1e-20 exactly, and the larger is 1 to round-off.
    assert!((sigma[0] * sigma[1] / 1e-20 - 1.0).abs() < 1e-14);
}

#[test]
fn svd_of_wide_empty_zero_huge_and_nan() {
    let wide = SMatrix::<f64, 1, 3>::new(3.0, 0.0, 4.0);
    let svd = Svd::new(&wide);
    assert!((svd.sigma[0] - 5.0).abs() < 1e-14);
    assert_eq!(svd.rank(1e-12), 1);
    assert_eq!(Svd::new(&SMatrix::<f64, 3, 0>::zeros()).rank(1e-12), 0);
    assert_eq!(Svd::new(&SMatrix::<f64, 3, 2>::zeros()).rank(1e-12), 0);
    let huge = Svd::new(&SMatrix::<f64, 2, 2>::new(1e300, 0.0, 1e300, 1e300));
    assert!(huge.sigma[0].is_finite() && huge.rank(1e-12) == 2);
    assert_eq!(
        Svd::new(&SMatrix::<f64, 2, 1>::new(f64::NAN, 1.0)).rank(1e-12),
        0
    );
}

#[test]
fn rows_there_and_back() {
    let rows = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    assert_eq!(to_rows(&from_rows(&rows)), rows);
    assert_eq!(zeros::<f64, 2, 3>(), SMatrix::<f64, 2, 3>::zeros());
    assert_eq!(scale(2.0, &from_rows(&rows))[(1, 2)], 12.0);
}
