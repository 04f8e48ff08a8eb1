//! Bad input ends in an error or a documented result, never in a panic or NaN.

use gp::{
    Algorithm, Functionals, GpError, Inputs, Kernel, LatentPrior, Model, Penalty, Posterior,
    Problem, Reason, Saved, Scaling, Training, Workspace, evidence,
};

fn line(n: usize) -> (Functionals, Vec<f64>) {
    let x = Inputs::from_rows(&(0..n).map(|i| [0.37 * i as f64]).collect::<Vec<_>>()).unwrap();
    let y = x.dims();
    assert!(n == 0 || y == 1);
    let values = (0..n).map(|i| (0.37 * i as f64).sin()).collect();
    if n == 0 {
        (Functionals::new(1, 1), values)
    } else {
        (Functionals::identity(&x, 1), values)
    }
}

fn model(noise: f64) -> Model {
    Model::new(
        LatentPrior::independent(vec![Kernel::squared_exponential(&[1.0], 1.0)]),
        &[noise],
    )
    .unwrap()
}

#[test]
fn no_data_and_one_point() {
    let (f, y) = line(0);
    assert!(matches!(
        Posterior::new(&model(0.1), &f, &y),
        Err(GpError::Shape { .. })
    ));
    assert!(
        Training::new(&Problem::new(model(0.1), &f, &y))
            .run(&Problem::new(model(0.1), &f, &y))
            .is_err()
    );
    let (f, y) = line(1);
    let p = Posterior::new(&model(0.1), &f, &[0.8])
        .unwrap()
        .predict(&f)
        .unwrap();
    assert!((p.mean[0] - 0.8 / 1.1).abs() < 1e-14);
    assert!((p.variance[0] - (1.0 - 1.0 / 1.1)).abs() < 1e-14);
    assert_eq!(y.len(), 1);
    let empty = Posterior::new(&model(0.1), &f, &[0.8])
        .unwrap()
        .predict(&Functionals::new(1, 1))
        .unwrap();
    assert!(empty.mean.is_empty());
}

#[test]
fn not_finite_and_wrong_shapes() {
    let (f, mut y) = line(5);
    y[3] = f64::NAN;
    match Posterior::new(&model(0.1), &f, &y).err() {
        Some(GpError::NotFinite { index: 3, .. }) => {}
        other => panic!("{other:?}"),
    }
    assert!(Posterior::new(&model(0.1), &f, &y[..4]).is_err());
    assert!(Inputs::from_rows(&[vec![0.0], vec![f64::INFINITY]]).is_err());
    assert!(Inputs::from_rows(&[vec![0.0], vec![0.0, 1.0]]).is_err());
    let mut g = Functionals::new(2, 1);
    assert!(g.push(&[0.0], &[1.0], &[0.0]).is_err());
    assert!(g.push(&[0.0, 0.0], &[1.0, 2.0], &[0.0]).is_err());
    assert!(g.push(&[0.0, 0.0], &[f64::NAN], &[0.0]).is_err());
    assert!(
        g.push_on_channels(&[0.0, 0.0], &[1.0], &[0.0], &[7])
            .is_ok()
    );
    let two = Model::new(LatentPrior::independent(vec![Kernel::bias(1.0)]), &[0.1]).unwrap();
    assert!(
        Posterior::new(&two, &g, &[1.0]).is_err(),
        "channel 7 has no noise"
    );
    assert!(Model::new(LatentPrior::independent(vec![Kernel::bias(1.0)]), &[-0.1]).is_err());
    assert!(
        Model::new(
            LatentPrior::independent(vec![Kernel::bias(1.0)]),
            &[f64::NAN]
        )
        .is_err()
    );
    let wrong = Model::new(
        LatentPrior::independent(vec![Kernel::squared_exponential(&[1.0, 1.0], 1.0)]),
        &[0.1],
    )
    .unwrap();
    let e = Posterior::new(&wrong, &f, &[0.0; 5])
        .err()
        .unwrap()
        .to_string();
    assert!(e.contains("term[0]") && e.contains("length-scales"), "{e}");
    let negative = Model::new(
        LatentPrior::independent(vec![Kernel::squared_exponential(&[-1.0], 1.0)]),
        &[0.1],
    )
    .unwrap();
    let e = Posterior::new(&negative, &f, &[0.0; 5])
        .err()
        .unwrap()
        .to_string();
    assert!(e.contains("term[0].log_length[0]"), "{e}");
    assert!(LatentPrior::new(1, vec![]).is_err());
    assert!(LatentPrior::independent(vec![]).set_params(&[]).is_ok());
    let none = Model::new(LatentPrior::independent(vec![]), &[0.1]).unwrap();
    assert!(Posterior::new(&none, &Functionals::new(1, 0), &[]).is_err());
}

#[test]
fn coincident_points_are_named() {
    let mixed = Functionals::identity(&Inputs::from_rows(&[[0.0], [0.0]]).unwrap(), 1);
    let m = model(1e-18);
    let e = evidence(&m, &mixed, &[1.0, 1.0], &[], &mut Workspace::default()).unwrap();
    assert!(e.jitter > 0.0 && e.nll.is_finite());
    // With ordinary noise duplicates are ordinary data.
    assert_eq!(
        evidence(
            &model(0.1),
            &mixed,
            &[1.0, 1.1],
            &[],
            &mut Workspace::default()
        )
        .unwrap()
        .jitter,
        0.0
    );
    let text = GpError::NotPositiveDefinite {
        row: 2,
        point: 2,
        jitter: 1e-6,
        coincident: vec![(0, 2)],
    }
    .to_string();
    assert!(
        text.contains("data points 0 and 2 have the same input"),
        "{text}"
    );
}

#[test]
fn constant_outputs_and_bounds() {
    let (f, _) = line(12);
    let y = vec![3.0; 12];
    let channels = vec![0; 12];
    let scaling = Scaling::of_outputs(&y, &channels).unwrap();
    assert_eq!((scaling.shift[0], scaling.scale[0]), (3.0, 1.0));
    let flat = scaling.outputs(&y, &channels).unwrap();
    let problem = Problem::new(model(0.01), &f, &flat);
    let fitted = Training::new(&problem)
        .bounds("*log_length*", -2.0, 5.0)
        .unwrap()
        .restarts(2)
        .start_in("*log_length*", -1.0, 1.0)
        .unwrap()
        .run(&problem)
        .unwrap();
    assert!(fitted.nll.is_finite());
    assert!(
        !fitted.at_bounds.is_empty(),
        "nothing but bounds stops a constant: {fitted:?}"
    );
    assert!(fitted.model.params().iter().all(|v| v.is_finite()));
    let p = Posterior::new(&fitted.model, &f, &flat)
        .unwrap()
        .predict(&f)
        .unwrap();
    let back = scaling.restore_prediction(&p, &channels).unwrap();
    assert!(back.mean.iter().all(|m| (m - 3.0).abs() < 1e-3));
    assert!(back.variance.iter().all(|v| v.is_finite() && *v >= 0.0));
}

#[test]
fn training_options_are_checked() {
    let (f, y) = line(8);
    let problem = Problem::new(model(0.01), &f, &y);
    let e = Training::new(&problem)
        .fix("nonsense*")
        .unwrap_err()
        .to_string();
    assert!(e.contains("nonsense*") && e.contains("log_noise[0]"), "{e}");
    assert!(Training::new(&problem).bounds("*", 1.0, -1.0).is_err());
    assert!(Training::new(&problem).bounds("*", f64::NAN, 1.0).is_err());
    assert!(
        Training::new(&problem)
            .start_in("*", 0.0, f64::INFINITY)
            .is_err()
    );
    assert!(
        Training::new(&problem)
            .penalty("*", Penalty::Normal { mean: 0.0, sd: 0.0 })
            .is_err()
    );
}

#[test]
fn training_is_deterministic_and_can_be_stopped() {
    let (f, y) = line(25);
    let problem = Problem::new(model(0.01), &f, &y);
    let training = Training::new(&problem)
        .bounds("*", -9.0, 5.0)
        .unwrap()
        .start_in("*", -2.0, 1.0)
        .unwrap()
        .restarts(4)
        .seed(11);
    let (a, b) = (
        training.run(&problem).unwrap(),
        training.run(&problem).unwrap(),
    );
    assert_eq!(a, b);
    assert_ne!(
        a.runs[1].start,
        training.clone().seed(12).run(&problem).unwrap().runs[1].start
    );
    let stopped = training
        .run_watched(&problem, &|p| p.iteration < 2)
        .unwrap();
    assert!(stopped.runs.iter().any(|r| r.reason == Reason::Stopped));
    let adam = Training::new(&problem)
        .bounds("*", -9.0, 5.0)
        .unwrap()
        .algorithm(Algorithm::Adam {
            rate: 0.1,
            iterations: 400,
            reset_every: 100,
        })
        .run(&problem)
        .unwrap();
    let exact = training
        .algorithm(Algorithm::default())
        .run(&problem)
        .unwrap();
    assert!(adam.nll - exact.nll < 0.5, "{} {}", adam.nll, exact.nll);
    assert_eq!(adam.runs[0].reason, Reason::Iterations);
}

#[test]
fn priors_pull_the_estimate() {
    let (f, y) = line(25);
    let problem = Problem::new(model(0.01), &f, &y);
    let training = || Training::new(&problem).bounds("*", -9.0, 5.0).unwrap();
    let free = training().run(&problem).unwrap();
    let target = free.model.params()[0] - 0.5;
    let tight = Penalty::Normal {
        mean: target,
        sd: 1e-4,
    };
    let map = training()
        .penalty("*log_length*", tight)
        .unwrap()
        .run(&problem)
        .unwrap();
    assert!((map.model.params()[0] - target).abs() < 1e-3);
    for p in [
        tight,
        Penalty::Gamma {
            shape: 2.5,
            rate: 0.7,
        },
        Penalty::HalfNormal { scale: 1.3 },
    ] {
        let (z, h) = (0.4, 1e-5);
        let numeric = (p.value(z + h).0 - p.value(z - h).0) / (2.0 * h);
        assert!(
            (p.value(z).1 - numeric).abs() < 1e-5 * (1.0 + numeric.abs()),
            "{p:?}"
        );
    }
}

#[test]
fn saved_models_round_trip_and_refuse_damage() {
    let (f, y) = line(9);
    let kernel = Kernel::matern32(&[0.1 + 0.2], 1.0 / 3.0) * Kernel::bias(1e-100)
        + Kernel::white(0.3).on(&[0]);
    let model = Model::new(
        LatentPrior::intrinsic(kernel, vec![vec![0.7]], &[0.1]),
        &[1.0 / 7.0],
    )
    .unwrap();
    let mut saved = Saved::new(model, vec![std::f64::consts::PI], f.clone(), y);
    saved.inputs = Some(Scaling {
        shift: vec![0.1],
        scale: vec![0.3],
    });
    let text = saved.to_json().unwrap();
    let back = Saved::from_json(&text).unwrap();
    assert_eq!(back, saved);
    let bits = |s: &Saved| -> Vec<u64> {
        let p = s.posterior().unwrap().predict(&f).unwrap();
        p.mean
            .iter()
            .chain(&p.variance)
            .map(|v| v.to_bits())
            .collect()
    };
    assert_eq!(bits(&back), bits(&saved));
    let refuse = |text: &str, word: &str| {
        let e = Saved::from_json(text).unwrap_err().to_string();
        assert!(e.contains(word), "{e}");
    };
    for cut in [0, 1, text.len() / 3, text.len() - 1] {
        refuse(&text[..cut], "truncated");
    }
    refuse("{}", "some other JSON file");
    refuse("not json", "not a JSON file");
    refuse(&text.replace("\"version\":1", "\"version\":0"), "older");
    refuse(&text.replace("\"version\":1", "\"version\":9"), "newer");
    refuse(
        &text.replace("\"version\":1", "\"version\":\"x\""),
        "version",
    );
    refuse(&text.replace("\"theta\"", "\"thata\""), "thata");
    refuse(&text.replacen("0.37", "0.38", 1), "checksum");
    refuse(
        &text.replacen("\"starts\":[0,1", "\"starts\":[0,2", 1),
        "checksum",
    );
    refuse(
        &text.replacen("\"starts\":[0,1", "\"starts\":[0,99", 1),
        "inconsistent shapes",
    );
    let mut bad = saved.clone();
    bad.theta[0] = f64::NAN;
    assert!(bad.to_json().is_err());
}
