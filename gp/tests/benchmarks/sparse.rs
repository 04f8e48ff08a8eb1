//! The inducing-point approximation against the exact model.

use crate::states::{functionals, states};
use crate::systems;
use gp::{
    Functionals, GaussPoint, Inputs, Kernel, LatentPrior, Layout, Model, Posterior, Quantity,
    Saved, SavedSparse, SparsePosterior, Workspace, farthest_points, greedy_points, nll,
};
use rand::{RngExt, SeedableRng};

fn measured(x: &[Vec<f64>], noise: f64) -> Vec<f64> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(99);
    let mut y = Vec::new();
    for x in x {
        let s = systems::unicycle(x, &[0.05, 0.02]);
        let speed = x[0].hypot(x[1]);
        let d = [-0.5 * speed * x[0], -0.5 * speed * x[1], 0.0];
        let total: Vec<f64> = (0..3)
            .map(|i| s.known[i] + (0..3).map(|j| s.mass[3 * i + j] * d[j]).sum::<f64>())
            .collect();
        let p = GaussPoint::new(&s.mass, &s.a, &s.b, &total).unwrap();
        let a = p.rows(Quantity::Acceleration, Layout::Force).unwrap().mean;
        y.extend(a.iter().map(|a| a + noise * rng.random_range(-1.7..1.7)));
    }
    y
}

fn model() -> Model {
    let kernel = Kernel::squared_exponential(&[1.0, 1.0, 6.0, 2.0, 20.0, 20.0], 0.3);
    Model::new(LatentPrior::shared(3, kernel), &[1e-4; 3]).unwrap()
}

#[test]
fn error_against_the_exact_model_falls_with_the_inducing_points() {
    let (train, test) = (states(150, 1, [0.0; 2]), states(40, 2, [0.0; 2]));
    let (data, at) = (
        functionals(&train, Quantity::Acceleration, Layout::Acceleration),
        functionals(&test, Quantity::Acceleration, Layout::Acceleration),
    );
    let y = measured(&train, 0.01);
    let model = model();
    let exact = Posterior::new(&model, &data, &y).unwrap();
    let reference = exact.predict(&at).unwrap();
    let evidence = -nll(&model, &data, &y, &mut Workspace::default()).unwrap();
    let inputs = Inputs::from_rows(&train).unwrap();
    let mut last = f64::INFINITY;
    for (count, mean_error, gap) in [
        (15, 0.2, f64::INFINITY),
        (50, 2e-2, 200.0),
        (100, 2e-3, 10.0),
        (150, 1e-3, 0.1),
    ] {
        let chosen = farthest_points(&inputs, count, 0).unwrap();
        let sparse =
            SparsePosterior::new(&model, &data, &y, &inputs.subset(&chosen).unwrap()).unwrap();
        let p = sparse.predict(&at).unwrap();
        let error = p
            .mean
            .iter()
            .zip(&reference.mean)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        let variance = p
            .variance
            .iter()
            .zip(&reference.variance)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        let loss = evidence - sparse.bound();
        println!(
            "{count:>4} inducing points: mean {error:.1e}, variance {variance:.1e}, evidence lost {loss:.3e} nats"
        );
        assert!(error < mean_error, "{count}: {error}");
        assert!(loss > -1e-3 && loss < gap, "the bound is a bound: {loss}");
        assert!(loss < last);
        last = loss;
        let full = sparse.covariance(&at).unwrap();
        assert!((0..at.n_rows()).all(|i| (full[(i, i)] - p.variance[i]).abs() < 1e-9));
        for (x, a) in test.iter().zip(p.mean.chunks(3)) {
            let s = systems::unicycle(x, &[0.05, 0.02]);
            let residual: f64 = (0..3).map(|j| s.a[j] * a[j]).sum::<f64>() - s.b[0];
            assert!(residual.abs() < 1e-10);
        }
        // Other quantities come out of the same approximation.
        let lambda = functionals(&test, Quantity::Multiplier, Layout::Acceleration);
        let (a, b) = (sparse.mean(&lambda).unwrap(), exact.mean(&lambda).unwrap());
        let worst = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(worst < 10.0 * mean_error, "{worst}");
    }
}

#[test]
fn bad_inducing_points_are_refused() {
    let train = states(5, 1, [0.0; 2]);
    let data = functionals(&train, Quantity::Acceleration, Layout::Acceleration);
    let y = measured(&train, 0.01);
    assert!(SparsePosterior::new(&model(), &data, &y, &Inputs::empty(6)).is_err());
    assert!(
        SparsePosterior::new(&model(), &data, &y, &Inputs::from_rows(&[[0.0]]).unwrap()).is_err()
    );
    assert!(SparsePosterior::new(&model(), &data, &y[..3], &data.inputs()).is_err());
    // Twice the same inducing point costs jitter, not correctness.
    let twice = data.inputs().subset(&[0, 0, 1, 2, 3, 4]).unwrap();
    let p = SparsePosterior::new(&model(), &data, &y, &twice).unwrap();
    assert!(p.jitter() > 0.0 && p.mean(&data).unwrap().iter().all(|v| v.is_finite()));
}

#[test]
fn a_saved_sparse_model_predicts_bit_for_bit_without_its_data() {
    let inputs = Inputs::from_rows(&states(12, 5, [0.0; 2])).unwrap();
    let text = |count: usize| {
        let x = states(count, 1, [0.0; 2]);
        let data = functionals(&x, Quantity::Acceleration, Layout::Acceleration);
        let posterior =
            SparsePosterior::new(&model(), &data, &measured(&x, 0.01), &inputs).unwrap();
        let saved = SavedSparse::new(&posterior, vec![0.05, 0.02]);
        (posterior, saved.to_json().unwrap())
    };
    let (posterior, json) = text(200);
    let back = SavedSparse::from_json(&json).unwrap();
    assert_eq!(
        (&back.theta[..], back.model()),
        (&[0.05, 0.02][..], &model())
    );
    let loaded = back.posterior().unwrap();
    let at = functionals(
        &states(30, 8, [0.0; 2]),
        Quantity::ConstraintForce,
        Layout::Acceleration,
    );
    assert_eq!(
        loaded.predict(&at).unwrap(),
        posterior.predict(&at).unwrap()
    );
    assert_eq!(
        loaded.covariance(&at).unwrap(),
        posterior.covariance(&at).unwrap()
    );
    assert_eq!(loaded.bound().to_bits(), posterior.bound().to_bits());
    // Twice the data, the same file but for the digits.
    let longer = text(400).1.len() as f64 / json.len() as f64;
    assert!((longer - 1.0).abs() < 0.02, "{longer}");

    let refuse = |text: &str, word: &str| {
        let e = SavedSparse::from_json(text).unwrap_err().to_string();
        assert!(e.contains(word), "{word}: {e}");
    };
    refuse(&json[..json.len() / 2], "truncated");
    refuse(&json.replace("\"version\":1", "\"version\":0"), "older");
    refuse(&json.replacen("0.05", "0.06", 1), "checksum");
    refuse(
        &json.replacen("\"weights\":[", "\"weights\":[1.0,", 1),
        "weights",
    );
    refuse(
        &json.replacen("\"factor_b\":[", "\"factor_b\":[-1.0,", 1),
        "factor of B",
    );
    let data = functionals(
        &states(3, 2, [0.0; 2]),
        Quantity::Acceleration,
        Layout::Acceleration,
    );
    let exact = Saved::new(model(), vec![], data.clone(), data.mean().to_vec());
    refuse(&exact.to_json().unwrap(), "gp2-model");
}

#[test]
fn greedy_points_explain_more_than_far_ones() {
    let x = states(120, 1, [0.0; 2]);
    let data = functionals(&x, Quantity::Acceleration, Layout::Acceleration);
    let (y, inputs) = (measured(&x, 0.01), data.inputs());
    let bound = |chosen: &[usize]| {
        let at = inputs.subset(chosen).unwrap();
        SparsePosterior::new(&model(), &data, &y, &at)
            .unwrap()
            .bound()
    };
    // With enough points for a useful approximation; both are bad below.
    for count in [45, 60, 80] {
        let (far, greedy) = (
            bound(&farthest_points(&inputs, count, 0).unwrap()),
            bound(&greedy_points(&model(), &data, count).unwrap()),
        );
        println!("{count} inducing inputs: bound {far:.1} farthest, {greedy:.1} greedy");
        assert!(greedy > far, "{count}: {greedy} {far}");
    }
}

#[test]
fn greedy_points_are_what_a_posterior_calls_least_known() {
    // A coregional prior, whose latent functions depend on one another.
    let x = states(25, 3, [0.0; 2]);
    let kernel = Kernel::squared_exponential(&[1.0, 1.0, 3.0, 2.0, 5.0, 5.0], 0.3);
    let weights = vec![vec![1.0], vec![-0.5], vec![0.3]];
    let prior = LatentPrior::intrinsic(kernel, weights, &[0.2, 0.1, 0.05]);
    let model = Model::new(prior.clone(), &[1e-4, 4e-4, 1e-4]).unwrap();
    let data = functionals(&x, Quantity::Acceleration, Layout::Acceleration);
    let chosen = greedy_points(&model, &data, 5).unwrap();
    let exact = Model::new(prior, &[1e-10; 3]).unwrap();
    for k in 1..5 {
        let seen = Functionals::identity(&data.inputs().subset(&chosen[..k]).unwrap(), 3);
        let posterior = Posterior::new(&exact, &seen, &vec![0.0; seen.n_rows()]).unwrap();
        let left = posterior.predict(&data).unwrap().variance;
        let lost = |i: usize| left[3 * i] / 1e-4 + left[3 * i + 1] / 4e-4 + left[3 * i + 2] / 1e-4;
        let worst = (0..x.len())
            .max_by(|&i, &j| lost(i).total_cmp(&lost(j)))
            .unwrap();
        assert_eq!(chosen[k], worst, "{k}");
    }
    assert!(greedy_points(&model, &data, 0).is_err());
    // Points that coincide explain one another.
    let mut twice = data.subset(&[0, 1]).unwrap();
    twice.extend(&data.subset(&[0, 1]).unwrap()).unwrap();
    assert_eq!(greedy_points(&model, &twice, 9).unwrap().len(), 2);
}

/// `-ln` of what is lost when `count` measurements of standard deviation `sd` are replaced by
/// their mean: `(2π sd²)^(-(count-1)/2) count^(-1/2) exp(-squares/(2 sd²))`.
fn within(count: usize, sd: f64, squares: f64) -> f64 {
    let n = count as f64;
    0.5 * (n - 1.0) * (2.0 * std::f64::consts::PI * sd * sd).ln()
        + 0.5 * n.ln()
        + 0.5 * squares / (sd * sd)
}

#[test]
fn twenty_thousand_points_against_the_exact_model() {
    // Each of 200 states is measured 100 times. The exact model of 60 000 rows then follows,
    // without approximation, from the 600 means and a hundredth of the noise variance.
    let (count, sd) = (100, 0.1);
    let (distinct, test) = (states(200, 1, [0.0; 2]), states(40, 2, [0.0; 2]));
    let all: Vec<Vec<f64>> = (0..count).flat_map(|_| distinct.clone()).collect();
    let of = |x: &[Vec<f64>]| functionals(x, Quantity::Acceleration, Layout::Acceleration);
    let (data, few, at) = (of(&all), of(&distinct), of(&test));
    assert_eq!((data.n_points(), data.n_rows()), (20_000, 60_000));
    let y = measured(&all, sd);
    let rows = few.n_rows();
    let mean: Vec<f64> = (0..rows)
        .map(|r| y.iter().skip(r).step_by(rows).sum::<f64>() / count as f64)
        .collect();
    let scatter: f64 = (0..rows)
        .map(|r| {
            let off = y.iter().skip(r).step_by(rows).map(|y| y - mean[r]);
            within(count, sd, off.map(|d| d * d).sum())
        })
        .sum();
    let with = |variance: f64| Model::new(model().prior, &[variance; 3]).unwrap();
    let exact = Posterior::new(&with(sd * sd / count as f64), &few, &mean).unwrap();
    let reference = exact.predict(&at).unwrap();
    let nll = exact.nll() + scatter;

    let inputs = Inputs::from_rows(&distinct).unwrap();
    let mut last = f64::INFINITY;
    for (inducing, error, gap) in [(50, 4e-2, 400.0), (100, 3e-3, 10.0)] {
        let chosen = farthest_points(&inputs, inducing, 0).unwrap();
        let z = inputs.subset(&chosen).unwrap();
        let sparse = SparsePosterior::new(&with(sd * sd), &data, &y, &z).unwrap();
        let p = sparse.predict(&at).unwrap();
        let worst = |a: &[f64], b: &[f64]| {
            let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
            off.fold(0.0, f64::max)
        };
        let sd_of = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| v.sqrt()).collect() };
        let (mean, band) = (
            worst(&p.mean, &reference.mean),
            worst(&sd_of(&p.variance), &sd_of(&reference.variance)),
        );
        let loss = -nll - sparse.bound();
        println!(
            "20 000 points, {inducing:>3} inducing: mean {mean:.1e}, sd {band:.1e}, evidence lost {loss:.3e} of {nll:.3e} nats"
        );
        assert!(mean < error && band < error, "{inducing}: {mean} {band}");
        assert!(
            loss > -1e-3 && loss < gap && loss < last,
            "{inducing}: {loss}"
        );
        last = loss;
    }
}
