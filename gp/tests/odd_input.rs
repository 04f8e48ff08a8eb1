//! What overflows, does not fit or was tampered with: an error that says so.

use gp::{
    Algorithm, Atlas, Chart, Functionals, GaussPoint, GpError, Inputs, Kernel, LatentPrior, Layout,
    Model, PointTangent, Posterior, Problem, Quantity, Saved, Scaling, SparsePosterior, Structure,
    Tangent, Training, Workspace, evidence, greedy_points, prior_covariance, sample_prior,
};

const Y: [f64; 3] = [1.0, 2.0, 3.0];

fn smooth() -> Kernel {
    Kernel::squared_exponential(&[1.0], 1.0)
}

fn model(kernel: Kernel) -> Model {
    Model::new(LatentPrior::shared(1, kernel), &[0.1]).unwrap()
}

fn at(x: &[[f64; 1]]) -> Functionals {
    Functionals::identity(&Inputs::from_rows(x).unwrap(), 1)
}

fn line() -> Functionals {
    at(&[[0.0], [1.0], [2.0]])
}

fn not_finite<T>(result: gp::Result<T>) {
    match result {
        Err(GpError::NotFinite { .. }) => {}
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("a number was given for what overflows"),
    }
}

fn names<T>(result: gp::Result<T>, word: &str) {
    match result {
        Err(e) => assert!(e.to_string().contains(word), "{word}: {e}"),
        Ok(_) => panic!("accepted, though {word} is wrong"),
    }
}

#[test]
fn far_away_a_stationary_kernel_knows_its_prior() {
    let far = at(&[[1e200], [-1e308], [1e308]]);
    for kernel in [
        smooth(),
        Kernel::matern32(&[1.0], 1.0),
        Kernel::matern52(&[1.0], 1.0),
        Kernel::white(1.0),
    ] {
        let model = model(kernel);
        let exact = Posterior::new(&model, &line(), &Y).unwrap();
        let sparse = SparsePosterior::new(&model, &line(), &Y, &line().inputs()).unwrap();
        for p in [exact.predict(&far).unwrap(), sparse.predict(&far).unwrap()] {
            assert_eq!((p.mean, p.variance), (vec![0.0; 3], vec![1.0; 3]));
        }
    }
}

#[test]
fn what_overflows_is_no_number_and_no_certainty() {
    let far = at(&[[1e200], [-1e308], [1e308]]);
    let enormous = Kernel::bias(1e130) * Kernel::bias(1e130) * Kernel::bias(1e130);
    for kernel in [
        Kernel::linear(&[1.0]),
        Kernel::periodic(&[1.0], &[1.0], 1.0),
    ] {
        let model = model(kernel.clone());
        let exact = Posterior::new(&model, &line(), &Y).unwrap();
        let sparse = SparsePosterior::new(&model, &line(), &Y, &line().inputs()).unwrap();
        not_finite(exact.predict(&far));
        not_finite(exact.mean(&far));
        not_finite(exact.covariance(&far));
        not_finite(exact.sample(&far.inputs(), 1, 0));
        not_finite(sparse.predict(&far));
        not_finite(sparse.covariance(&far));
        not_finite(kernel.gram(&far.inputs(), &far.inputs()));
    }
    let mut steep = Functionals::new(1, 1);
    steep.push(&[0.5], &[1e200], &[0.0]).unwrap();
    let exact = Posterior::new(&model(smooth()), &line(), &Y).unwrap();
    not_finite(exact.predict(&steep));
    not_finite(prior_covariance(exact.model(), &steep));
    not_finite(Posterior::new(exact.model(), &steep, &[1.0]));
    not_finite(Posterior::new(&model(enormous.clone()), &line(), &Y));
    not_finite(sample_prior(&model(enormous), &line().inputs(), 1, 0));
    not_finite(Posterior::new(
        exact.model(),
        &line(),
        &[1e300, -1e300, 1e308],
    ));
    let linear = model(Kernel::linear(&[1.0]));
    not_finite(SparsePosterior::new(&linear, &line(), &Y, &far.inputs()));
    not_finite(greedy_points(&linear, &far, 2));
    let ones = faer::Mat::from_fn(3, 3, |_, _| 1.0);
    not_finite(smooth().gradient(&far.inputs(), &far.inputs(), &ones));
}

#[test]
fn points_that_needed_jitter_are_named() {
    let data = at(&[[0.0], [5.0], [-0.0], [1.0], [5.0]]);
    let y = [1.0, 2.0, 3.0, 4.0, 5.0];
    let bare = Model::new(LatentPrior::shared(1, smooth()), &[1e-18]).unwrap();
    let e = evidence(&bare, &data, &y, &[], &mut Workspace::default()).unwrap();
    assert!(e.jitter > 0.0);
    assert_eq!(e.coincident, vec![(0, 2), (1, 4)]);
    let posterior = Posterior::new(&bare, &data, &y).unwrap();
    assert_eq!(posterior.coincident(), &e.coincident[..]);
    let problem = Problem::new(bare, &data, &y);
    let fitted = Training::new(&problem).fix("*").unwrap().run(&problem);
    assert_eq!(fitted.unwrap().coincident, e.coincident);
    let noisy = Posterior::new(&model(smooth()), &data, &y).unwrap();
    assert!(noisy.jitter() == 0.0 && noisy.coincident().is_empty());
}

/// One row whose input and map are the two parameters.
struct Two;

impl Structure for Two {
    fn n_theta(&self) -> usize {
        2
    }

    fn functionals(&self, theta: &[f64]) -> gp::Result<Functionals> {
        let mut f = Functionals::new(1, 1);
        f.push(&[theta[0]], &[theta[1]], &[0.0])?;
        Ok(f)
    }

    fn tangents(&self, _: &[f64]) -> gp::Result<Vec<Tangent>> {
        Ok(Vec::new())
    }
}

#[test]
fn parameters_charts_and_structure_must_agree() {
    let f = line();
    let mut work = Workspace::default();
    let few = Problem::new(model(smooth()), &Two, &Y);
    names(few.objective(&[0.0; 3], &mut work), "expected 2");
    names(Training::new(&few).run(&few), "expected 2");
    let charts = Problem::new(model(smooth()), &Two, &Y).with_theta(&[1.0, 1.0], Atlas::free(3));
    names(charts.objective(&[0.0; 5], &mut work), "charts");
    let many = Problem::new(model(smooth()), &f, &Y).with_theta(&[1.0], Atlas::free(1));
    names(many.objective(&[0.0; 4], &mut work), "structure");
    assert!(Atlas::free(2).forward(&[1.0]).is_err());
    assert!(Atlas::free(2).pull_back(&[1.0, 1.0], &[1.0]).is_err());
    assert!(Atlas::free(2).inverse(&[f64::NAN, 0.0]).is_err());
    let positive = Atlas::new(vec![Chart::Positive], 1).unwrap();
    not_finite(positive.forward(&[1e3]));
    let endless = Chart::Interval {
        lower: f64::NEG_INFINITY,
        upper: 1.0,
    };
    names(
        Atlas::new(vec![endless], 1).unwrap().inverse(&[0.0]),
        "finite interval",
    );
}

#[test]
fn settings_no_optimiser_can_use_are_refused() {
    let f = line();
    let problem = Problem::new(model(smooth()), &f, &Y);
    let run = |algorithm| Training::new(&problem).algorithm(algorithm).run(&problem);
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let lbfgs = |gradient_tolerance, reduction_tolerance| Algorithm::Lbfgs {
            max_iterations: 9,
            gradient_tolerance,
            reduction_tolerance,
        };
        names(run(lbfgs(bad, 1e-8)), "gradient_tolerance");
        names(run(lbfgs(1e-4, bad)), "reduction_tolerance");
        names(
            run(Algorithm::Adam {
                rate: bad,
                iterations: 3,
                reset_every: 0,
            }),
            "rate",
        );
    }
    let idle = run(Algorithm::Lbfgs {
        max_iterations: 0,
        gradient_tolerance: 0.0,
        reduction_tolerance: 0.0,
    });
    assert_eq!(idle.unwrap().model, problem.model);
    assert!(
        Training::new(&problem)
            .bounds("*", f64::INFINITY, f64::INFINITY)
            .unwrap()
            .run(&problem)
            .is_err()
    );
}

#[test]
fn restarts_without_intervals_still_differ() {
    let f = line();
    let problem = Problem::new(model(smooth()), &f, &Y);
    let training = Training::new(&problem).bounds("*", -1.0, 1.0).unwrap();
    let runs = training.restarts(4).run(&problem).unwrap().runs;
    // The given noise, ln 0.1, is outside: where a run starts is where it is reported to start.
    assert_eq!(runs[0].start, vec![0.0, 0.0, -1.0]);
    for (i, run) in runs.iter().enumerate() {
        assert!(
            run.start.iter().all(|v| (-1.0..=1.0).contains(v)),
            "{run:?}"
        );
        assert!(runs[..i].iter().all(|other| other.start != run.start));
    }
}

#[test]
fn scalings_are_checked_before_use() {
    names(Scaling::of_outputs(&[1.0], &[usize::MAX]), "channels");
    not_finite(Scaling::of_outputs(&[1e308, 1e308, -1e308], &[0; 3]));
    let large = Inputs::from_rows(&[[1e308], [1e308], [-1e308]]).unwrap();
    not_finite(Scaling::of_inputs(&large));
    // A unit is no reason to call a quantity constant.
    let tiny = Scaling::of_outputs(&[1e-13, 2e-13, -3e-13], &[0; 3]).unwrap();
    assert!((tiny.scale[0] / 2.16e-13 - 1.0).abs() < 1e-3, "{tiny:?}");
    let constant = Scaling::of_outputs(&[0.1; 7], &[0; 7]).unwrap();
    assert_eq!(constant.scale, vec![1.0]);
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let scaling = Scaling {
            shift: vec![0.0],
            scale: vec![scale],
        };
        names(scaling.outputs(&[1.0], &[0]), "scale[0]");
        names(scaling.restore(&[1.0], &[0]), "scale[0]");
        names(scaling.inputs(&line().inputs()), "scale[0]");
        let mut saved = Saved::new(model(smooth()), vec![], line(), Y.to_vec());
        saved.outputs = Some(scaling);
        names(saved.to_json(), "scale[0]");
    }
    let lost = Scaling {
        shift: vec![f64::NAN],
        scale: vec![1.0],
    };
    not_finite(lost.restore(&[1.0], &[0]));
    assert!(line().normalised(&[0.0], &[0.0]).is_err());
}

#[test]
fn matrices_no_mechanism_has_are_refused() {
    let none = [0.0, 0.0];
    names(
        GaussPoint::new(&[1.0, 0.9, 0.0, 1.0], &[], &[], &none),
        "M[1][0]",
    );
    // Round-off of generated code is no asymmetry.
    assert!(GaussPoint::new(&[1.0, 0.1, 0.1 + 1e-12, 1.0], &[], &[], &none).is_ok());
    names(GaussPoint::new(&[-1.0], &[], &[], &[0.0]), "singular");
    not_finite(GaussPoint::new(&[1e-300], &[1e200], &[0.0], &[1.0]));
    let p = GaussPoint::new(&[1.0], &[], &[], &[1.0]).unwrap();
    let mut d = PointTangent::zero(1, 0);
    d.mass[0] = f64::NAN;
    not_finite(p.tangent(&d, Quantity::Acceleration, Layout::Force));
}

#[test]
fn indices_and_sizes_that_do_not_exist() {
    let f = line();
    names(f.subset(&[0, 9]), "below 3");
    names(f.inputs().subset(&[3]), "below 3");
    let mut wide = Functionals::new(1, usize::MAX);
    assert!(wide.push(&[0.0], &[1.0], &[0.0, 1.0]).is_err());
    let posterior = Posterior::new(&model(smooth()), &f, &Y).unwrap();
    let mut samples = posterior.sample(&f.inputs(), 2, 0).unwrap();
    samples.draws[1].pop();
    names(samples.quantity(&f), "sampled ones");
    let text = Saved::new(model(smooth()), vec![], f, Y.to_vec())
        .to_json()
        .unwrap();
    let many = text.replace("\"n_latent\":1", "\"n_latent\":18446744073709551615");
    names(Saved::from_json(&many), "inconsistent shapes");
}
