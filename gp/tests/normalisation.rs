//! Normalised data and a model in normalised units give back, by the inverse, what the model in
//! the units of the data gives.

use gp::{Functionals, Kernel, LatentPrior, Model, Posterior, Prediction, Saved, Scaling};
use rand::{RngExt, SeedableRng};

const POINTS: usize = 14;

/// Two outputs in very different units, of two latent functions of two inputs.
fn data(seed: u64, points: usize) -> (Functionals, Vec<f64>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |lo: f64, hi: f64| rng.random_range(lo..hi);
    let (mut f, mut y) = (Functionals::new(2, 2), Vec::new());
    for _ in 0..points {
        let x = [uniform(100.0, 300.0), uniform(-1e-3, 1e-3)];
        let h = [
            uniform(1e4, 2e4),
            uniform(-1e4, 1e4),
            uniform(-1e-6, 1e-6),
            1e-6,
        ];
        f.push(&x, &h, &[5e4, -2e-6]).unwrap();
        y.extend([uniform(0.0, 1e5), uniform(-1e-5, 1e-5)]);
    }
    (f, y)
}

fn posterior(lengths: &[f64], noise: &[f64], f: &Functionals, y: &[f64]) -> Posterior {
    let prior = LatentPrior::independent(vec![
        Kernel::squared_exponential(lengths, 1.3),
        Kernel::matern52(lengths, 0.7),
    ]);
    Posterior::new(&Model::new(prior, noise).unwrap(), f, y).unwrap()
}

fn same(what: &str, got: &[f64], want: &[f64]) {
    for (g, w) in got.iter().zip(want) {
        assert!(
            (g - w).abs() < 1e-9 * w.abs() + 1e-18,
            "{what}: {g} and {w}"
        );
    }
    assert_eq!(got.len(), want.len());
}

#[test]
fn the_inverse_is_applied_to_every_output() {
    let ((f, y), (at, _)) = (data(1, POINTS), data(2, 5));
    let (lengths, noise) = ([60.0, 4e-4], [1e7, 1e-12]);
    let raw = posterior(&lengths, &noise, &f, &y);

    let inputs = Scaling::of_inputs(&f.inputs()).unwrap();
    let outputs = Scaling::of_outputs(&y, f.channels()).unwrap();
    let normal = |f: &Functionals| {
        let x = inputs.inputs(&f.inputs()).unwrap();
        let f = f.clone().with_inputs(&x).unwrap();
        f.normalised(&outputs.shift, &outputs.scale).unwrap()
    };
    let y1 = outputs.outputs(&y, f.channels()).unwrap();
    for c in 0..2 {
        let own: Vec<f64> = y1.iter().skip(c).step_by(2).copied().collect();
        let mean: f64 = own.iter().sum::<f64>() / POINTS as f64;
        let square: f64 = own.iter().map(|v| v * v).sum::<f64>() / POINTS as f64;
        assert!(mean.abs() < 1e-12 && (square - 1.0).abs() < 1e-12);
    }
    same(
        "measurements",
        &outputs.restore(&y1, f.channels()).unwrap(),
        &y,
    );
    let units = |v: &[f64], s: &[f64], power: i32| -> Vec<f64> {
        v.iter().zip(s).map(|(v, s)| v / s.powi(power)).collect()
    };
    let scaled = posterior(
        &units(&lengths, &inputs.scale, 1),
        &units(&noise, &outputs.scale, 2),
        &normal(&f),
        &y1,
    );
    let back = |p: &Prediction| outputs.restore_prediction(p, at.channels()).unwrap();
    let (got, want) = (
        back(&scaled.predict(&normal(&at)).unwrap()),
        raw.predict(&at).unwrap(),
    );
    same("mean", &got.mean, &want.mean);
    same("variance", &got.variance, &want.variance);
    let (got, want) = (
        back(&scaled.predict_measured(&normal(&at)).unwrap()),
        raw.predict_measured(&at).unwrap(),
    );
    same("variance of a measurement", &got.variance, &want.variance);
    let (got, want) = (
        scaled.covariance(&normal(&at)).unwrap(),
        raw.covariance(&at).unwrap(),
    );
    let got = outputs.restore_covariance(&got, at.channels()).unwrap();
    for (i, j) in (0..10).flat_map(|i| (0..10).map(move |j| (i, j))) {
        let size = (want[(i, i)] * want[(j, j)]).sqrt();
        assert!((got[(i, j)] - want[(i, j)]).abs() < 1e-9 * size, "{i} {j}");
    }
    // The latent functions have no unit to lose: one draw, seen in both.
    let draws = scaled.sample(&normal(&at).inputs(), 3, 4).unwrap();
    let seen = draws.quantity(&normal(&at)).unwrap();
    for (got, want) in seen.iter().zip(&draws.quantity(&at).unwrap()) {
        same(
            "sample",
            &outputs.restore(got, at.channels()).unwrap(),
            want,
        );
    }
    // Saved with its scalings, a model knows its units.
    let mut saved = Saved::new(scaled.model().clone(), vec![], normal(&f), y1);
    (saved.inputs, saved.outputs) = (Some(inputs.clone()), Some(outputs.clone()));
    let loaded = Saved::from_json(&saved.to_json().unwrap()).unwrap();
    assert_eq!(
        (loaded.inputs, loaded.outputs),
        (Some(inputs), Some(outputs))
    );
}
