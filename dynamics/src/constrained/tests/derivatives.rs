//! Derivatives of the solution: implicit, by dual numbers, by finite differences.

use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

use super::{M, N, Sample, near, redundant, sample, singular_mass};
use crate::Dual;
use crate::constrained::{FullRank, RankRevealing, Tolerance};

/// `s + h ds`, the mass staying symmetric.
fn moved(s: &Sample, ds: &Sample, h: f64) -> Sample {
    Sample {
        mass: s.mass + ds.mass * h,
        force: s.force + ds.force * h,
        a: s.a + ds.a * h,
        b: s.b + ds.b * h,
    }
}

/// `∂(M a − Qbar − Aᵀ λ)` and `∂(A a − b)` along `ds` at fixed `a`, `λ`.
fn residuals(
    ds: &Sample,
    a: &SVector<f64, N>,
    lambda: &SVector<f64, M>,
) -> (SVector<f64, N>, SVector<f64, M>) {
    (
        ds.mass * a - ds.force - ds.a.transpose() * lambda,
        ds.a * a - ds.b,
    )
}

/// `s` with derivative `ds` in the only direction.
fn dual<const R: usize, const C: usize>(
    s: &SMatrix<f64, R, C>,
    ds: &SMatrix<f64, R, C>,
) -> SMatrix<Dual<f64, 1>, R, C> {
    SMatrix::from_fn(|i, j| Dual {
        re: s[(i, j)],
        eps: [ds[(i, j)]],
    })
}

proptest! {
    #![proptest_config(crate::property_tests())]

    #[test]
    fn implicit_dual_and_difference_agree(s in sample(), ds in sample()) {
        let factor = FullRank::new(&s.mass, &s.a);
        let x = factor.solve(&s.force, &s.b);
        let (dr, dt) = residuals(&ds, &x.a, &x.lambda);
        let (da, dlambda) = factor.derivatives(&dr, &dt);

        let by_dual = FullRank::new(&dual(&s.mass, &ds.mass), &dual(&s.a, &ds.a))
            .solve(&dual(&s.force, &ds.force), &dual(&s.b, &ds.b));
        near(&by_dual.a.map(|e| e.re), &x.a, 1e-12)?;
        near(&by_dual.a.map(|e| e.eps[0]), &da, 1e-9)?;
        near(&by_dual.lambda.map(|e| e.eps[0]), &dlambda, 1e-9)?;

        let h = 1e-6;
        let at = |h| {
            let s = moved(&s, &ds, h);
            FullRank::new(&s.mass, &s.a).solve(&s.force, &s.b)
        };
        near(&((at(h).a - at(-h).a) / (2.0 * h)), &da, 1e-4)?;
        near(&((at(h).lambda - at(-h).lambda) / (2.0 * h)), &dlambda, 1e-4)?;

        let revealing = RankRevealing::new(&s.mass, &s.a, &Tolerance::default()).unwrap();
        let (da2, dlambda2) = revealing.derivatives(&dr, &dt);
        near(&da2, &da, 1e-8)?;
        near(&dlambda2, &dlambda, 1e-8)?;
    }

    #[test]
    fn redundant_rows_have_the_derivatives_of_the_reduced(s in redundant(), ds in redundant()) {
        // Move so that the third row stays the same combination of the first two.
        let mut ds = ds;
        let weights = (s.a.fixed_rows::<2>(0).transpose()).pseudo_inverse(1e-9).unwrap()
            * s.a.row(2).transpose();
        let row = ds.a.row(0) * weights[0] + ds.a.row(1) * weights[1];
        ds.a.set_row(2, &row);
        ds.b[2] = ds.b[0] * weights[0] + ds.b[1] * weights[1];

        let revealing = RankRevealing::new(&s.mass, &s.a, &Tolerance::default()).unwrap();
        let x = revealing.solve(&s.force, &s.b).unwrap();
        let (dr, dt) = residuals(&ds, &x.a, &x.lambda);
        let (da, dlambda) = revealing.derivatives(&dr, &dt);

        let two = |m: &SMatrix<f64, M, N>| m.fixed_rows::<2>(0).into_owned();
        let pair = |b: &SVector<f64, M>| b.fixed_rows::<2>(0).into_owned();
        let reduced = FullRank::new(&dual(&s.mass, &ds.mass), &dual(&two(&s.a), &two(&ds.a)))
            .solve(&dual(&s.force, &ds.force), &dual(&pair(&s.b), &pair(&ds.b)));
        near(&reduced.a.map(|e| e.eps[0]), &da, 1e-7)?;
        let dforce = ds.a.transpose() * x.lambda + s.a.transpose() * dlambda;
        near(&reduced.constraint_force.map(|e| e.eps[0]), &dforce, 1e-7)?;
    }

    #[test]
    fn singular_mass_has_derivatives(s in singular_mass(), ds in sample()) {
        // The mass keeps its rank: no change of it here.
        let ds = Sample { mass: SMatrix::zeros(), ..ds };
        let revealing = RankRevealing::new(&s.mass, &s.a, &Tolerance::default()).unwrap();
        let x = revealing.solve(&s.force, &s.b).unwrap();
        let (dr, dt) = residuals(&ds, &x.a, &x.lambda);
        let (da, dlambda) = revealing.derivatives(&dr, &dt);
        let h = 1e-6;
        let at = |h| super::oracle(&moved(&s, &ds, h));
        near(&((at(h).0 - at(-h).0) / (2.0 * h)), &da, 1e-4)?;
        near(&((at(h).1 - at(-h).1) / (2.0 * h)), &dlambda, 1e-4)?;
    }
}
