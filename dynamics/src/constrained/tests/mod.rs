//! Laws of the constrained solve on random systems, against nalgebra's own
//! factorisations where a number is needed.

use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

use super::*;
use crate::linalg::{ancestors, to_rows};

mod cases;
mod derivatives;

const N: usize = 5;
const M: usize = 3;

type Mass = SMatrix<f64, N, N>;
type Jacobian = SMatrix<f64, M, N>;

/// A random constrained system.
#[derive(Clone, Copy, Debug)]
struct Sample {
    mass: Mass,
    force: SVector<f64, N>,
    a: Jacobian,
    b: SVector<f64, M>,
}

fn matrix<const R: usize, const C: usize>(elements: &[f64]) -> SMatrix<f64, R, C> {
    SMatrix::from_fn(|i, j| elements[i * C + j])
}

/// Positive definite `M` (condition up to some thousands), full row rank `A`.
fn sample() -> impl Strategy<Value = Sample> {
    proptest::collection::vec(-1.0..1.0_f64, N * N + N + M * N + M)
        .prop_map(|e| {
            let root: Mass = matrix(&e[..N * N]);
            let rest = &e[N * N..];
            Sample {
                mass: root * root.transpose() + Mass::identity() * 0.05,
                force: matrix(&rest[..N]),
                a: matrix(&rest[N..N + M * N]),
                b: matrix(&rest[N + M * N..]),
            }
        })
        .prop_filter("A near rank loss", |s| s.a.singular_values().min() > 0.05)
}

/// The same with the third row a multiple-and-sum of the first two, consistently.
fn redundant() -> impl Strategy<Value = Sample> {
    (sample(), -2.0..2.0_f64, 0.1..2.0_f64).prop_map(|(mut s, x, y)| {
        let row = s.a.row(0) * x + s.a.row(1) * y;
        s.a.set_row(2, &row);
        s.b[2] = s.b[0] * x + s.b[1] * y;
        s
    })
}

/// `M` of rank 3 whose null space the constraints hold.
fn singular_mass() -> impl Strategy<Value = Sample> {
    (sample(), proptest::collection::vec(-1.0..1.0_f64, N * 3))
        .prop_map(|(mut s, e)| {
            let root: SMatrix<f64, N, 3> = matrix(&e);
            s.mass = root * root.transpose();
            s
        })
        .prop_filter("rank [M; A] near loss", |s| {
            let stacked = SMatrix::<f64, { N + M }, N>::from_fn(|i, j| {
                if i < N {
                    s.mass[(i, j)]
                } else {
                    s.a[(i - N, j)]
                }
            });
            let pivots = s.mass.symmetric_eigenvalues();
            let mut sorted: [f64; N] = pivots.into();
            sorted.sort_by(f64::total_cmp);
            stacked.singular_values().min() > 0.05 && sorted[2] > 0.02
        })
}

/// Solution of the whole `K [a; −λ] = [Qbar; b]` by nalgebra's pivoted LU.
fn oracle(s: &Sample) -> (SVector<f64, N>, SVector<f64, M>) {
    const K: usize = N + M;
    let k = SMatrix::<f64, K, K>::from_fn(|i, j| match (i < N, j < N) {
        (true, true) => s.mass[(i, j)],
        (true, false) => s.a[(j - N, i)],
        (false, true) => s.a[(i - N, j)],
        (false, false) => 0.0,
    });
    let right = SVector::<f64, K>::from_fn(|i, _| if i < N { s.force[i] } else { s.b[i - N] });
    let x = k.full_piv_lu().solve(&right).unwrap();
    (x.fixed_rows::<N>(0).into_owned(), -x.fixed_rows::<M>(N))
}

fn near<const R: usize, const C: usize>(
    x: &SMatrix<f64, R, C>,
    y: &SMatrix<f64, R, C>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let scale = 1.0 + x.amax().max(y.amax());
    prop_assert!((x - y).amax() <= tolerance * scale, "{} against {}", x, y);
    Ok(())
}

fn is_solution(s: &Sample, x: &Solution<f64, N, M>, tolerance: f64) -> Result<(), TestCaseError> {
    near(&(s.a * x.a), &s.b, tolerance)?;
    near(
        &(s.mass * x.a),
        &(s.force + s.a.transpose() * x.lambda),
        tolerance,
    )?;
    near(&x.constraint_force, &(s.a.transpose() * x.lambda), 1e-14)
}

fn deficient(s: &Sample) -> Result<RankRevealing<f64, N, M>, SolveError> {
    RankRevealing::new(&s.mass, &s.a, &Tolerance::default())
}

/// The unit vector `n` with `nᵀ A = 0` of a Jacobian of rank 2: the longest cross
/// product of two columns. (nalgebra's `pseudo_inverse` is only good to 1e-8 here.)
fn dependency(a: &Jacobian) -> SVector<f64, M> {
    let mut longest = SVector::<f64, M>::zeros();
    for i in 0..N {
        for j in 0..i {
            let cross = a.column(i).cross(&a.column(j));
            if cross.norm() > longest.norm() {
                longest = cross;
            }
        }
    }
    longest.normalize()
}

/// Orthogonal projector onto the null space of `K` independent rows.
fn null_projector<const K: usize>(rows: &SMatrix<f64, K, N>) -> Mass {
    let gram = (rows * rows.transpose()).try_inverse().unwrap();
    Mass::identity() - rows.transpose() * gram * rows
}

/// The laws of [`Projectors`]; `row_projector` is `A A⁺`.
fn are_projectors(
    s: &Sample,
    p: &Projectors<f64, N, M>,
    row_projector: &SMatrix<f64, M, M>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    near(&(p.t * p.t), &p.t, tolerance)?;
    near(&(s.a * p.t), &SMatrix::zeros(), tolerance)?;
    near(&p.p, &p.p.transpose(), 0.0)?;
    near(&(p.p * s.a.transpose()), &SMatrix::zeros(), tolerance)?;
    near(&(p.p * s.mass * p.p), &p.p, tolerance)?;
    near(&(p.p * s.mass), &p.t, tolerance)?;
    near(&(s.a * p.l), row_projector, tolerance)?;
    near(&p.s, &p.t.transpose(), 0.0)?;
    near(&p.t, &(Mass::identity() - p.l * s.a), tolerance)
}

/// The four Penrose identities of `x = g⁺`.
fn is_pseudo_inverse(
    g: &SMatrix<f64, M, M>,
    x: &SMatrix<f64, M, M>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    near(&(g * x * g), g, tolerance)?;
    near(&(x * g * x), x, tolerance)?;
    near(&(g * x), &(g * x).transpose(), tolerance)?;
    near(&(x * g), &(x * g).transpose(), tolerance)
}

proptest! {
    #![proptest_config(crate::property_tests())]

    #[test]
    fn full_rank_agrees_with_lu(s in sample()) {
        let (a, lambda) = oracle(&s);
        let fast = FullRank::new(&s.mass, &s.a).solve(&s.force, &s.b);
        is_solution(&s, &fast, 1e-11)?;
        near(&fast.a, &a, 1e-10)?;
        near(&fast.lambda, &lambda, 1e-10)?;
        let checked = solve(&s.mass, &s.force, &s.a, &s.b, &Tolerance::default()).unwrap();
        near(&checked.a, &a, 1e-10)?;
        let revealing = deficient(&s).unwrap();
        prop_assert_eq!(revealing.rank(), M);
        prop_assert!(!revealing.mass_is_singular());
        let revealed = revealing.solve(&s.force, &s.b).unwrap();
        near(&revealed.a, &a, 1e-10)?;
        near(&revealed.lambda, &lambda, 1e-10)?;
    }

    /// With a chain's zeros: none.
    #[test]
    fn branched_agrees_with_full_rank(s in sample(), ds in sample()) {
        static CARRIES: [[bool; N]; N] = ancestors([0, 0, 1, 2, 3]);
        let full = FullRank::new(&s.mass, &s.a);
        let branched = Branched::new(&to_rows(&s.mass), &to_rows(&s.a), &CARRIES);
        let expected = full.solve(&s.force, &s.b);
        let (a, lambda) = branched.motion(s.force.as_ref(), s.b.as_ref());
        near(&SVector::from(a), &expected.a, 1e-10)?;
        near(&SVector::from(lambda), &expected.lambda, 1e-10)?;
        let (expected_a, expected_lambda) = full.derivatives(&ds.mass, &ds.a);
        let (a, lambda) = branched.derivatives(&to_rows(&ds.mass), &to_rows(&ds.a));
        near(&from_rows(&a), &expected_a, 1e-10)?;
        near(&from_rows(&lambda), &expected_lambda, 1e-10)?;
    }

    #[test]
    fn ideal_constraint_force_does_no_virtual_work(s in redundant(), w in proptest::array::uniform5(-1.0..1.0)) {
        // A virtual displacement is any vector of N(A).
        let x = deficient(&s).unwrap().solve(&s.force, &s.b).unwrap();
        let null = null_projector(&s.a.fixed_rows::<2>(0).into_owned());
        let displacement = null * SVector::from(w);
        let work = x.constraint_force.dot(&displacement);
        prop_assert!(work.abs() < 1e-11 * (1.0 + x.constraint_force.amax()));
    }

    #[test]
    fn projectors_of_full_rank(s in sample()) {
        let fast = FullRank::new(&s.mass, &s.a).projectors();
        are_projectors(&s, &fast, &SMatrix::identity(), 1e-9)?;
        let g = s.a * s.mass.try_inverse().unwrap() * s.a.transpose();
        is_pseudo_inverse(&g, &fast.g_pinv, 1e-8)?;
        let other = deficient(&s).unwrap().projectors();
        near(&fast.l, &other.l, 1e-9)?;
        near(&fast.p, &other.p, 1e-9)?;
        near(&fast.t, &other.t, 1e-9)?;
        near(&fast.g_pinv, &other.g_pinv, 1e-9)?;
    }

    #[test]
    fn projectors_of_redundant_rows(s in redundant()) {
        let factor = deficient(&s).unwrap();
        prop_assert_eq!(factor.rank(), 2);
        let p = factor.projectors();
        let n = dependency(&s.a);
        are_projectors(&s, &p, &(SMatrix::identity() - n * n.transpose()), 1e-9)?;
        let g = s.a * s.mass.try_inverse().unwrap() * s.a.transpose();
        is_pseudo_inverse(&g, &p.g_pinv, 1e-8)?;
        let x = factor.solve(&s.force, &s.b).unwrap();
        near(&x.a, &(p.l * s.b + p.p * s.force), 1e-9)?;
        near(&x.lambda, &(p.g_pinv * s.b - p.l.transpose() * s.force), 1e-9)?;
    }

    #[test]
    fn redundant_rows_move_as_the_reduced_system(s in redundant()) {
        let reduced = FullRank::<f64, N, 2>::new(&s.mass, &s.a.fixed_rows::<2>(0).into_owned())
            .solve(&s.force, &s.b.fixed_rows::<2>(0).into_owned());
        let x = solve(&s.mass, &s.force, &s.a, &s.b, &Tolerance::default()).unwrap();
        is_solution(&s, &x, 1e-10)?;
        near(&x.a, &reduced.a, 1e-9)?;
        near(&x.constraint_force, &reduced.constraint_force, 1e-9)?;
        // The shortest multiplier is the pseudo-inverse's.
        prop_assert!(dependency(&s.a).dot(&x.lambda).abs() < 1e-9 * (1.0 + x.lambda.amax()));
    }

    #[test]
    fn scale_of_rows_changes_nothing_but_their_multipliers(s in redundant(), power in -8..8_i32) {
        let mut scaled = s;
        let unit = 10.0_f64.powi(power);
        scaled.a.row_mut(1).scale_mut(unit);
        scaled.b[1] *= unit;
        let factor = deficient(&scaled).unwrap();
        prop_assert_eq!(factor.rank(), 2);
        let (x, y) = (factor.solve(&scaled.force, &scaled.b), deficient(&s).unwrap().solve(&s.force, &s.b));
        let (x, y) = (x.unwrap(), y.unwrap());
        near(&x.a, &y.a, 1e-7)?;
        near(&x.constraint_force, &y.constraint_force, 1e-7)?;
    }

    #[test]
    fn singular_mass_agrees_with_lu(s in singular_mass()) {
        let factor = deficient(&s).unwrap();
        prop_assert!(factor.mass_is_singular());
        let x = factor.solve(&s.force, &s.b).unwrap();
        let (a, lambda) = oracle(&s);
        is_solution(&s, &x, 1e-9)?;
        near(&x.a, &a, 1e-8)?;
        near(&x.lambda, &lambda, 1e-8)?;
        let p = factor.projectors();
        are_projectors(&s, &p, &SMatrix::identity(), 1e-8)?;
        near(&x.a, &(p.l * s.b + p.p * s.force), 1e-8)?;
        near(&x.lambda, &(p.g_pinv * s.b - p.l.transpose() * s.force), 1e-8)?;
    }

    #[test]
    fn contradiction_is_an_error(s in redundant(), gap in 1e-3..10.0_f64) {
        let mut s = s;
        s.b[2] += gap;
        let error = solve(&s.mass, &s.force, &s.a, &s.b, &Tolerance::default()).unwrap_err();
        let is_inconsistent = matches!(error, SolveError::Inconsistent { rank: 2, rows: 3, .. });
        prop_assert!(is_inconsistent, "{}", error);
    }

    #[test]
    fn acceleration_is_the_least_change(s in sample(), w in proptest::array::uniform5(-1.0..1.0)) {
        // Gauss: of all a with A a = b, the true one minimises (a − a₀)ᵀ M (a − a₀).
        let x = FullRank::new(&s.mass, &s.a).solve(&s.force, &s.b);
        let free = s.mass.try_inverse().unwrap() * s.force;
        let null = null_projector(&s.a);
        let other = x.a + null * SVector::from(w) * 0.1;
        let cost = |a: SVector<f64, N>| (a - free).dot(&(s.mass * (a - free)));
        prop_assert!(cost(x.a) <= cost(other) + 1e-9);
    }
}
