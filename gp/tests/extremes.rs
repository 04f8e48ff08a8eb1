//! Hyper-parameters at their bounds, empty requests, structures that fail.

use gp::{
    Atlas, Chart, Functionals, GaussPoint, GpError, Inputs, Kernel, LatentPrior, Layout, Model,
    PointTangent, Posterior, Problem, Quantity, Reason, SparsePosterior, Structure, Tangent,
    Training, Workspace, evidence, farthest_points, prior_covariance, sample_prior,
};
use rand::{RngExt, SeedableRng};

fn everything() -> Kernel {
    Kernel::squared_exponential(&[1.0], 1.0)
        + Kernel::matern32(&[1.0], 1.0) * Kernel::periodic(&[1.0], &[1.0], 1.0)
        + (Kernel::matern52(&[1.0], 1.0) + Kernel::linear(&[1.0])).scaled(1.0)
        + Kernel::bias(1.0)
        + Kernel::white(1.0)
}

#[test]
fn any_hyper_parameters_give_numbers_or_an_error() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let x = Inputs::from_rows(
        &(0..9)
            .map(|i| [1e3 * (i as f64 - 4.0).powi(3)])
            .collect::<Vec<_>>(),
    )
    .unwrap();
    let f = Functionals::identity(&x, 2);
    let y: Vec<f64> = (0..18).map(|i| 1e4 * (i as f64).sin()).collect();
    let prior = LatentPrior::shared(2, everything()).clone();
    let mut model = Model::new(prior, &[1.0, 1.0]).unwrap();
    let (mut fine, mut refused) = (0, 0);
    for round in 0..300 {
        let wide = [20.0, 100.0, 299.0][round % 3];
        let z: Vec<f64> = (0..model.n_params())
            .map(|_| {
                if rng.random_range(0..3) == 0 {
                    wide * f64::from(rng.random_range(-1..=1))
                } else {
                    rng.random_range(-wide..wide)
                }
            })
            .collect();
        model.set_params(&z).unwrap();
        match evidence(&model, &f, &y, &[], &mut Workspace::default()) {
            Ok(e) => {
                fine += 1;
                assert!(e.nll.is_finite() && e.jitter.is_finite());
                assert!(e.gradient.iter().all(|g| g.is_finite()));
                let p = Posterior::new(&model, &f, &y).unwrap().predict(&f);
                assert!(
                    p.is_err()
                        || p.unwrap()
                            .variance
                            .iter()
                            .all(|v| v.is_finite() && *v >= 0.0)
                );
            }
            Err(GpError::NotPositiveDefinite { .. } | GpError::NotFinite { .. }) => refused += 1,
            Err(other) => panic!("{other}"),
        }
    }
    assert!(fine > 50, "{fine} fine, {refused} refused");
    let mut too_far = model.params();
    too_far[0] = 301.0;
    model.set_params(&too_far).unwrap();
    let e = evidence(&model, &f, &y, &[], &mut Workspace::default()).unwrap_err();
    assert!(matches!(e, GpError::Parameter { .. }), "{e}");
}

#[test]
fn empty_requests_give_empty_answers() {
    let x = Inputs::from_rows(&[[0.0], [1.0], [2.0]]).unwrap();
    let f = Functionals::identity(&x, 1);
    let model = Model::new(
        LatentPrior::shared(1, Kernel::matern52(&[1.0], 1.0)),
        &[0.1],
    )
    .unwrap();
    let none = Functionals::new(1, 1);
    let posterior = Posterior::new(&model, &f, &[1.0, 2.0, 3.0]).unwrap();
    assert!(posterior.predict(&none).unwrap().mean.is_empty());
    assert_eq!(posterior.covariance(&none).unwrap().nrows(), 0);
    assert_eq!(
        posterior.sample(&Inputs::empty(1), 2, 0).unwrap().draws,
        vec![Vec::<f64>::new(); 2]
    );
    assert!(posterior.sample(&x, 0, 0).unwrap().draws.is_empty());
    assert_eq!(prior_covariance(&model, &none).unwrap().nrows(), 0);
    assert_eq!(
        sample_prior(&model, &Inputs::empty(1), 1, 0)
            .unwrap()
            .draws
            .len(),
        1
    );
    assert!(posterior.predict(&Functionals::new(2, 1)).is_err());
    assert!(posterior.mean(&Functionals::new(1, 3)).is_err());
    assert!(posterior.sample(&Inputs::empty(4), 1, 0).is_err());
    let sparse = SparsePosterior::new(&model, &f, &[1.0, 2.0, 3.0], &x).unwrap();
    assert!(sparse.predict(&none).unwrap().mean.is_empty());
    assert_eq!(sparse.covariance(&none).unwrap().nrows(), 0);
    // A point without rows is no measurement.
    let mut odd = f.clone();
    odd.push(&[0.5], &[], &[]).unwrap();
    let again = Posterior::new(&model, &odd, &[1.0, 2.0, 3.0]).unwrap();
    assert_eq!(again.mean(&f).unwrap(), posterior.mean(&f).unwrap());
    assert!(farthest_points(&x, 0, 0).is_err() && farthest_points(&x, 1, 3).is_err());
    assert_eq!(farthest_points(&x, 10, 1).unwrap().len(), 3);
    let mut flat = Functionals::new(1, 0);
    flat.push(&[0.0], &[], &[1.0]).unwrap();
    assert!(flat.with_latent_scale(&[]).is_ok());
}

#[test]
fn noise_widens_what_a_measurement_shows() {
    let f = Functionals::identity(&Inputs::from_rows(&[[0.0], [1.0]]).unwrap(), 1);
    let model = Model::new(
        LatentPrior::shared(1, Kernel::matern52(&[1.0], 1.0)),
        &[0.1],
    )
    .unwrap();
    let posterior = Posterior::new(&model, &f, &[1.0, 2.0]).unwrap();
    let (quiet, noisy) = (
        posterior.predict(&f).unwrap(),
        posterior.predict_measured(&f).unwrap(),
    );
    for (q, n) in quiet.variance.iter().zip(&noisy.variance) {
        assert!((n - q - 0.1).abs() < 1e-12);
    }
    let one = posterior.mean_at(&[0.0], &[1.0], &[0.0]).unwrap();
    assert_eq!(one[0], quiet.mean[0]);
}

/// Fails once its parameter exceeds a limit.
struct Fragile {
    limit: f64,
    tangents: usize,
}

impl Structure for Fragile {
    fn n_theta(&self) -> usize {
        1
    }

    fn functionals(&self, theta: &[f64]) -> gp::Result<Functionals> {
        if theta[0] > self.limit {
            return Err(GpError::Structure {
                theta: theta.to_vec(),
                message: "the linkage does not close".into(),
            });
        }
        let mut f = Functionals::new(1, 1);
        for i in 0..6 {
            f.push(&[i as f64], &[1.0], &[theta[0]])?;
        }
        Ok(f)
    }

    fn tangents(&self, _: &[f64]) -> gp::Result<Vec<Tangent>> {
        Ok(vec![
            Tangent {
                rows: vec![0.0; 6],
                mean: vec![1.0; 6]
            };
            self.tangents
        ])
    }
}

#[test]
fn a_structure_that_fails_ends_the_run_and_keeps_the_best() {
    let model = || Model::new(LatentPrior::shared(1, Kernel::bias(1e-6)), &[0.01]).unwrap();
    let y = [2.0; 6];
    let whole = Fragile {
        limit: 1.0,
        tangents: 1,
    };
    let problem = Problem::new(model(), &whole, &y).with_theta(&[0.0], Atlas::free(1));
    let training = |p: &Problem<'_>| {
        Training::new(p)
            .fix("term*")
            .unwrap()
            .fix("log_noise*")
            .unwrap()
    };
    let fitted = training(&problem).run(&problem).unwrap();
    assert!(fitted.theta[0] <= 1.0);
    assert!(
        matches!(&fitted.runs[0].reason, Reason::Evaluation(m) if m.contains("linkage")),
        "{:?}",
        fitted.runs
    );
    let lost = Problem::new(model(), &whole, &y).with_theta(&[3.0], Atlas::free(1));
    assert!(
        training(&lost)
            .run(&lost)
            .unwrap_err()
            .to_string()
            .contains("linkage")
    );
    let e = training(&lost).restarts(3).run(&lost).unwrap_err();
    assert!(matches!(e, GpError::Training { starts: 3, .. }), "{e}");
    let short = Fragile {
        limit: 1.0,
        tangents: 0,
    };
    let problem = Problem::new(model(), &short, &y).with_theta(&[0.0], Atlas::free(1));
    assert!(matches!(
        training(&problem).run(&problem),
        Err(GpError::Shape { .. })
    ));
    assert!(
        problem
            .objective(&[0.0], &mut Workspace::default())
            .is_err()
    );
    assert!(Atlas::new(vec![Chart::Inertia], 3).is_err());
    let inside = Fragile {
        limit: 9.0,
        tangents: 1,
    };
    let problem = Problem::new(model(), &inside, &y)
        .with_theta(&[0.1], Atlas::new(vec![Chart::Positive], 1).unwrap());
    let fitted = training(&problem).run(&problem).unwrap();
    assert!((fitted.theta[0] - 2.0).abs() < 1e-3, "{fitted:?}");
}

#[test]
fn points_with_wrong_shapes_are_refused() {
    let p = GaussPoint::new(&[1.0, 0.0, 0.0, 1.0], &[1.0, 0.0], &[0.0], &[0.0, 0.0]).unwrap();
    let mut d = PointTangent::zero(2, 1);
    d.b.push(0.0);
    assert!(
        p.tangent(&d, Quantity::Acceleration, Layout::Force)
            .is_err()
    );
    assert!(
        p.tangent(
            &PointTangent::zero(3, 1),
            Quantity::Acceleration,
            Layout::Force
        )
        .is_err()
    );
    assert!(p.rows(Quantity::Force, Layout::Force).is_err());
    assert!(p.rows(Quantity::Force, Layout::SplitForce).is_ok());
    assert!(GaussPoint::new(&[1.0; 3], &[], &[], &[0.0, 0.0]).is_err());
    assert!(GaussPoint::new(&[f64::NAN], &[], &[], &[0.0]).is_err());
    assert!(GaussPoint::new(&[1.0], &[], &[], &[]).is_err());
    // Indefinite inertia that no constraint mends.
    assert!(GaussPoint::new(&[1.0, 2.0, 2.0, 1.0], &[], &[], &[0.0, 0.0]).is_err());
    let twice = GaussPoint::new(
        &[1.0, 0.0, 0.0, 1.0],
        &[1.0, 0.0, 1.0, 0.0],
        &[0.0; 2],
        &[0.0; 2],
    )
    .unwrap();
    let e = twice
        .tangent(
            &PointTangent::zero(2, 2),
            Quantity::Acceleration,
            Layout::Force,
        )
        .unwrap_err();
    assert!(e.to_string().contains("redundant"), "{e}");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(8);
    let mut f = Functionals::new(2, 2);
    for _ in 0..70 {
        let mut draw =
            |n: usize| -> Vec<f64> { (0..n).map(|_| rng.random_range(-1.0..1.0)).collect() };
        f.push(&draw(2), &draw(4), &[0.0, 0.0]).unwrap();
    }
    let y: Vec<f64> = (0..140).map(|i| (i as f64).sin()).collect();
    let kernel = || Kernel::matern52(&[0.7, 0.9], 1.0);
    let tangents = [Tangent {
        rows: vec![0.3; 280],
        mean: vec![0.1; 140],
    }];
    let inducing = f.inputs().subset(&[0, 9, 33, 51]).unwrap();
    for prior in [
        LatentPrior::shared(2, kernel()),
        LatentPrior::intrinsic(kernel(), vec![vec![0.4], vec![-0.8]], &[0.2, 0.3]),
    ] {
        let model = Model::new(prior, &[0.1, 0.2]).unwrap();
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mut work = Workspace::default();
                let posterior = Posterior::new(&model, &f, &y).unwrap();
                (
                    evidence(&model, &f, &y, &[], &mut work).unwrap(),
                    evidence(&model, &f, &y, &tangents, &mut work).unwrap(),
                    gp::sparse_evidence(&model, &f, &y, &inducing, &tangents).unwrap(),
                    posterior.predict(&f).unwrap(),
                )
            })
        };
        assert_eq!(run(1), run(3));
    }
}
