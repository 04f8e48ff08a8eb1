//! What holds by construction: `A a = b`, joint consistency, rank-deficient
//! constraints, singular inertia.

use crate::states::{functionals, states};
use crate::systems;
use gp::{
    GaussPoint, GpError, Inputs, Kernel, LatentPrior, Layout, Model, Posterior, Quantity,
    sample_prior,
};

/// Thrust and torque.
const DRIVEN: [f64; 2] = [0.3, -0.1];

fn model(layout: Layout) -> Model {
    let kernel = || Kernel::squared_exponential(&[0.7; 6], 0.5);
    let prior = LatentPrior::independent((0..layout.n_latent(3)).map(|_| kernel()).collect());
    Model::new(prior, &[1e-4; 3]).unwrap()
}

fn violation(x: &[Vec<f64>], a: &[f64]) -> f64 {
    x.iter()
        .zip(a.chunks(3))
        .map(|(x, a)| {
            let s = systems::unicycle(x, &[0.05, 0.02]);
            ((0..3).map(|j| s.a[j] * a[j]).sum::<f64>() - s.b[0]).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn means_and_samples_obey_the_constraint() {
    let (train, test) = (states(30, 1, DRIVEN), states(15, 2, DRIVEN));
    for layout in [Layout::Force, Layout::SplitForce, Layout::Acceleration] {
        let model = model(layout);
        let data = functionals(&train, Quantity::Acceleration, layout);
        let y: Vec<f64> = data
            .mean()
            .iter()
            .enumerate()
            .map(|(i, m)| m + 0.1 * (i as f64).sin())
            .collect();
        let posterior = Posterior::new(&model, &data, &y).unwrap();
        let at = functionals(&test, Quantity::Acceleration, layout);
        assert!(violation(&test, &posterior.mean(&at).unwrap()) < 1e-10);
        let inputs = Inputs::from_rows(&test).unwrap();
        for samples in [
            posterior.sample(&inputs, 5, 7).unwrap(),
            sample_prior(&model, &inputs, 5, 7).unwrap(),
        ] {
            let a = samples.quantity(&at).unwrap();
            assert_eq!(a.len(), 5);
            for a in &a {
                assert!(violation(&test, a) < 1e-10, "{}", violation(&test, a));
            }
            // One draw tells one story: a = M⁻¹ (Q̄ + Q_I).
            let force = samples
                .quantity(&functionals(&test, Quantity::TotalForce, layout))
                .unwrap();
            let ideal = samples
                .quantity(&functionals(&test, Quantity::ConstraintForce, layout))
                .unwrap();
            for (i, x) in test.iter().enumerate() {
                let s = systems::unicycle(x, &[0.05, 0.02]);
                for r in 0..3 {
                    let ma: f64 = (0..3).map(|j| s.mass[3 * r + j] * a[0][3 * i + j]).sum();
                    assert!((ma - force[0][3 * i + r] - ideal[0][3 * i + r]).abs() < 1e-10);
                }
            }
        }
    }
}

#[test]
fn forces_predict_accelerations_and_the_other_way_round() {
    // Measuring Q̄ nearly exactly must give the acceleration it causes.
    let x = states(12, 5, DRIVEN);
    let model = Model::new(model(Layout::Force).prior, &[1e-10; 3]).unwrap();
    let data = functionals(&x, Quantity::TotalForce, Layout::Force);
    let y: Vec<f64> = data
        .mean()
        .iter()
        .enumerate()
        .map(|(i, m)| m + 0.2 * (i as f64 * 0.9).cos())
        .collect();
    let posterior = Posterior::new(&model, &data, &y).unwrap();
    let a = posterior
        .mean(&functionals(&x, Quantity::Acceleration, Layout::Force))
        .unwrap();
    let lambda = posterior
        .mean(&functionals(&x, Quantity::Multiplier, Layout::Force))
        .unwrap();
    for (i, x) in x.iter().enumerate() {
        let s = systems::unicycle(x, &[0.05, 0.02]);
        for r in 0..3 {
            let left: f64 = (0..3).map(|j| s.mass[3 * r + j] * a[3 * i + j]).sum();
            let right = y[3 * i + r] + s.a[r] * lambda[i];
            assert!((left - right).abs() < 1e-5, "{left} {right}");
        }
    }
}

#[test]
fn mixed_measurements_narrow_the_posterior() {
    let x = states(10, 9, DRIVEN);
    let layout = Layout::Force;
    let mut data = functionals(&x, Quantity::Acceleration, layout);
    let model = Model::new(model(layout).prior, &[1e-4, 1e-4, 1e-4, 1e-6]).unwrap();
    let y = data.mean().to_vec();
    let alone = Posterior::new(&model, &data, &y).unwrap();
    let forces = functionals(&x, Quantity::Multiplier, layout);
    for i in 0..x.len() {
        let r = forces.rows_of(i).start;
        data.push_on_channels(&x[i], forces.row(r), &forces.mean()[r..r + 1], &[3])
            .unwrap();
    }
    let both = Posterior::new(&model, &data, &[y, forces.mean().to_vec()].concat()).unwrap();
    let wide: f64 = alone.predict(&forces).unwrap().variance.iter().sum();
    let narrow: f64 = both.predict(&forces).unwrap().variance.iter().sum();
    assert!(narrow < 1e-2 * wide, "{narrow} {wide}");
}

#[test]
fn redundant_rows_change_nothing() {
    let mass = vec![2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5];
    let (single, twice) = (vec![1.0, -1.0, 0.5], vec![1.0, -1.0, 0.5, -2.0, 2.0, -1.0]);
    let known = [0.5, -1.0, 2.0];
    let a = GaussPoint::new(&mass, &single, &[0.7], &known).unwrap();
    let b = GaussPoint::new(&mass, &twice, &[0.7, -1.4], &known).unwrap();
    for quantity in [Quantity::Acceleration, Quantity::ConstraintForce] {
        let (a, b) = (
            a.rows(quantity, Layout::Force).unwrap(),
            b.rows(quantity, Layout::Force).unwrap(),
        );
        for (a, b) in a.h.iter().chain(&a.mean).zip(b.h.iter().chain(&b.mean)) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }
    let e = GaussPoint::new(&mass, &twice, &[0.7, 1.0], &known).unwrap_err();
    assert!(matches!(e, GpError::InconsistentConstraint { .. }), "{e}");
}

#[test]
fn singular_inertia_and_no_constraint_at_all() {
    // A massless middle coordinate held by the constraint: rank [M; A] = 3.
    let mass = vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0];
    let a = vec![1.0, -1.0, 0.0];
    let p = GaussPoint::new(&mass, &a, &[0.2], &[3.0, 1.0, 4.0]).unwrap();
    let r = p.rows(Quantity::Acceleration, Layout::Force).unwrap();
    // a1 + 0 = 3 + λ, 0 = 1 - λ, a1 - a2 = 0.2, 2 a3 = 4.
    for (got, want) in r.mean.iter().zip([4.0, 3.8, 2.0]) {
        assert!((got - want).abs() < 1e-12, "{:?}", r.mean);
    }
    let lambda = p.rows(Quantity::Multiplier, Layout::Force).unwrap();
    assert!((lambda.mean[0] - 1.0).abs() < 1e-12);
    assert!(matches!(
        p.rows(Quantity::UnconstrainedAcceleration, Layout::Force),
        Err(GpError::Singular { .. })
    ));
    let free = vec![0.0, 1.0, 0.0];
    assert!(
        GaussPoint::new(
            &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0],
            &free,
            &[0.0],
            &[0.0; 3]
        )
        .is_err()
    );
    let open = GaussPoint::new(&[2.0], &[], &[], &[4.0]).unwrap();
    assert!(
        (open
            .rows(Quantity::Acceleration, Layout::Force)
            .unwrap()
            .mean[0]
            - 2.0)
            .abs()
            < 1e-14
    );
    assert_eq!(
        open.rows(Quantity::Multiplier, Layout::Force)
            .unwrap()
            .mean
            .len(),
        0
    );
    assert_eq!(
        open.rows(Quantity::ConstraintForce, Layout::Force)
            .unwrap()
            .mean,
        vec![0.0]
    );
}
