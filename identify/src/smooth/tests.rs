//! Smoothing against dense Gaussian conditioning and against known motions.

use super::wiener::{Hyper, Wiener};
use super::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

#[derive(Deserialize)]
struct Golden {
    savgol: SavgolGolden,
    smoother: Vec<SmootherGolden>,
}

#[derive(Deserialize)]
struct SavgolGolden {
    step: f64,
    x: Vec<f64>,
    cases: Vec<SavgolCase>,
}

#[derive(Deserialize)]
struct SavgolCase {
    window: usize,
    order: usize,
    derivative: usize,
    y: Vec<f64>,
}

#[derive(Deserialize)]
struct SmootherGolden {
    order: usize,
    t: Vec<f64>,
    sd: [f64; 3],
    w: f64,
    prior_sd: Vec<f64>,
    z: [Vec<f64>; 3],
    cases: Vec<SmootherCase>,
}

#[derive(Deserialize)]
struct SmootherCase {
    channels: String,
    log_likelihood: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    sd_q: Vec<f64>,
    sd_v: Vec<f64>,
    sd_a: Vec<f64>,
}

fn golden() -> Golden {
    let text = include_str!("../../tests/golden/kinematics.json");
    serde_json::from_str(text).unwrap()
}

/// Largest deviation relative to the largest reference value.
fn deviation(found: &[f64], reference: &[f64]) -> f64 {
    assert_eq!(found.len(), reference.len());
    let scale = reference.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let pairs = found.iter().zip(reference);
    pairs
        .map(|(a, b)| (a - b).abs() / scale)
        .fold(0.0, f64::max)
}

#[test]
fn savitzky_golay_agrees_with_scipy() {
    let golden = golden().savgol;
    let t: Vec<f64> = (0..golden.x.len())
        .map(|k| golden.step * k as f64)
        .collect();
    for case in &golden.cases {
        let filter = SavitzkyGolay {
            order: case.order,
            window: case.window,
        };
        let y = filter.apply(&t, &golden.x, case.derivative);
        let worst = deviation(&y, &case.y);
        assert!(worst < 1e-10, "{filter:?}, {}: {worst:e}", case.derivative);
    }
}

#[test]
fn smoother_agrees_with_dense_conditioning() {
    for golden in golden().smoother {
        for case in &golden.cases {
            match golden.order {
                3 => compare::<3>(&golden, case),
                4 => compare::<4>(&golden, case),
                _ => compare::<5>(&golden, case),
            }
        }
    }
}

fn compare<const N: usize>(golden: &SmootherGolden, case: &SmootherCase) {
    let used = case.channels.split('_').count();
    let optional = |i: usize| (used > i).then_some(golden.z[i].as_slice());
    let channels = Channels::new(&golden.t, &golden.z[0], optional(1), optional(2)).unwrap();
    let mut prior_sd = [1.0; 5];
    prior_sd[..N].copy_from_slice(&golden.prior_sd);
    let hyper = Hyper {
        density: golden.w,
        sd: std::array::from_fn(|i| (used > i).then_some(golden.sd[i])),
        prior_sd,
    };
    let model = Wiener::<N>::new(&hyper, 2.0 / 45.0, 2.0);
    let evidence = model.log_likelihood(&channels, 0..golden.t.len(), 1.0);
    assert!(
        (evidence - case.log_likelihood).abs() < 1e-6,
        "{evidence} against {}",
        case.log_likelihood
    );
    let steps = model.filter(&channels, 0..golden.t.len());
    let posteriors = model.backward(&steps, &golden.t);
    let means = [&case.q, &case.v, &case.a];
    let sds = [&case.sd_q, &case.sd_v, &case.sd_a];
    for k in 0..3 {
        let mean: Vec<f64> = posteriors.iter().map(|p| p.mean[k] * model.si(k)).collect();
        let sd: Vec<f64> = posteriors
            .iter()
            .map(|p| p.variance[k].sqrt() * model.si(k))
            .collect();
        let worst = deviation(&mean, means[k]).max(deviation(&sd, sds[k]));
        assert!(worst < 1e-6, "N = {N}, {}, {k}: {worst:e}", case.channels);
    }
}

/// A motion of three sines with its exact derivatives.
fn motion(t: f64) -> [f64; 3] {
    let sines: [(f64, f64, f64); 3] = [(0.8, 1.9, 0.3), (0.35, 5.3, 1.1), (0.12, 11.0, 2.0)];
    let mut state = [0.0; 3];
    for (amplitude, rate, phase) in sines {
        let (s, c) = (rate * t + phase).sin_cos();
        state[0] += amplitude * s;
        state[1] += amplitude * rate * c;
        state[2] -= amplitude * rate * rate * s;
    }
    state
}

struct Simulated {
    t: Vec<f64>,
    truth: [Vec<f64>; 3],
    measured: [Vec<f64>; 3],
}

fn simulate(t: Vec<f64>, sd: [f64; 3], seed: u64) -> Simulated {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut truth = [vec![], vec![], vec![]];
    let mut measured = [vec![], vec![], vec![]];
    for stamp in &t {
        for (i, x) in motion(*stamp).into_iter().enumerate() {
            let noise: f64 = StandardNormal.sample(&mut rng);
            truth[i].push(x);
            measured[i].push(x + sd[i] * noise);
        }
    }
    Simulated { t, truth, measured }
}

fn even(n: usize, step: f64) -> Vec<f64> {
    (0..n).map(|k| step * k as f64).collect()
}

fn jittered(n: usize, step: f64) -> Vec<f64> {
    (0..n)
        .map(|k| step * (k as f64 + 0.3 * (2.3 * k as f64).sin()))
        .collect()
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (square / a.len() as f64).sqrt()
}

/// Share of samples within `z` posterior standard deviations of the truth.
fn coverage(mean: &[f64], sd: &[f64], truth: &[f64], z: f64) -> f64 {
    let all = mean.iter().zip(sd).zip(truth);
    let within = all.filter(|((m, s), x)| (*m - *x).abs() <= z * *s).count();
    within as f64 / mean.len() as f64
}

const SD: [f64; 3] = [2e-4, 0.02, 0.15];

#[test]
fn noise_is_recovered_and_errors_are_covered() {
    for (used, seed) in [(1, 11), (2, 12), (3, 13)] {
        for t in [even(3000, 0.005), jittered(3000, 0.005)] {
            let sim = simulate(t, SD, seed);
            let optional = |i: usize| (used > i).then_some(sim.measured[i].as_slice());
            let channels =
                Channels::new(&sim.t, &sim.measured[0], optional(1), optional(2)).unwrap();
            let smoothed = Smoother::fit(&channels).unwrap().apply(&channels).unwrap();
            let noise = smoothed.noise;
            let found = [Some(noise.sd_q), noise.sd_dq, noise.sd_ddq];
            println!(
                "channels {used}: {noise:?}, order {}",
                smoothed.smoother.order
            );
            for i in 0..used {
                let ratio = found[i].unwrap() / SD[i];
                assert!((0.9..1.1).contains(&ratio), "channel {i}: {ratio}");
            }
            let states = [
                (&smoothed.q, &smoothed.sd_q),
                (&smoothed.v, &smoothed.sd_v),
                (&smoothed.a, &smoothed.sd_a),
            ];
            for (i, (mean, sd)) in states.into_iter().enumerate() {
                let error = rms(mean, &sim.truth[i]);
                let share = [1.0, 1.96].map(|z| coverage(mean, sd, &sim.truth[i], z));
                let mean_sd: f64 = sd.iter().sum::<f64>() / sd.len() as f64;
                println!("  {i}: rms error {error:.3e}, mean sd {mean_sd:.3e}, {share:.3?}");
                assert!(share[0] > 0.55 && share[1] > 0.9, "coverage {i}: {share:?}");
                assert!(
                    error > 0.4 * mean_sd,
                    "sd too large: {error} against {mean_sd}"
                );
            }
        }
    }
}

#[test]
fn acceleration_is_better_than_by_local_polynomials() {
    for used in [1, 2] {
        let sim = simulate(even(3000, 0.005), SD, 21);
        let dq = (used > 1).then_some(sim.measured[1].as_slice());
        let channels = Channels::new(&sim.t, &sim.measured[0], dq, None).unwrap();
        let smoothed = Smoother::fit(&channels).unwrap().apply(&channels).unwrap();
        let filter = SavitzkyGolay::reference(0.005);
        let local = match dq {
            Some(dq) => filter.apply(&sim.t, dq, 1),
            None => filter.apply(&sim.t, channels.q, 2),
        };
        let (ours, theirs) = (rms(&smoothed.a, &sim.truth[2]), rms(&local, &sim.truth[2]));
        println!("channels {used}: smoother {ours:.4}, Savitzky-Golay {theirs:.4}");
        assert!(ours < 0.5 * theirs, "{ours} against {theirs}");
    }
}

/// A ripple of the encoder counts as motion unless the response is bounded.
#[test]
fn a_bounded_response_leaves_ripple_to_the_noise() {
    let mut sim = simulate(even(3000, 0.005), [2e-5, 0.0, 0.0], 4);
    for (q, t) in sim.measured[0].iter_mut().zip(&sim.t) {
        *q += 2e-4 * (160.0 * t).sin();
    }
    let channels = Channels::new(&sim.t, &sim.measured[0], None, None).unwrap();
    let error = |shortest_response| {
        let options = Options { shortest_response };
        let smoother = Smoother::fit_with(&channels, &options).unwrap();
        let least = shortest_response.unwrap_or(0.0);
        assert!(smoother.response(0.005) >= least);
        rms(&smoother.apply(&channels).unwrap().a, &sim.truth[2])
    };
    let (free, bounded) = (error(None), error(Some(0.03)));
    assert!(bounded < 0.3 * free, "{bounded} against {free}");
}

#[test]
fn stationary_gains_do_not_change_the_likelihood() {
    let sim = simulate(even(2000, 0.005), SD, 5);
    let channels = Channels::new(&sim.t, &sim.measured[0], Some(&sim.measured[1]), None).unwrap();
    let hyper = Hyper {
        density: 4e3,
        sd: [Some(2e-4), Some(0.02), None],
        prior_sd: [3.0, 10.0, 60.0, 400.0, 3e3],
    };
    let model = Wiener::<3>::new(&hyper, 0.005, 10.0);
    let fast = model.log_likelihood(&channels, 0..2000, 0.005);
    // A median step that no step resembles: every covariance is computed.
    let full = model.log_likelihood(&channels, 0..2000, 1.0);
    assert!((fast - full).abs() < 1e-4, "{fast} against {full}");
}

/// Whatever stands in a sample that is set aside, on one channel or on both.
#[test]
fn what_is_set_aside_has_no_weight() {
    let sim = simulate(even(2000, 0.005), SD, 5);
    let hyper = Hyper {
        density: 4e3,
        sd: [Some(2e-4), Some(0.02), None],
        prior_sd: [3.0, 10.0, 60.0, 400.0, 3e3],
    };
    let model = Wiener::<3>::new(&hyper, 0.005, 10.0);
    let mut flags = [vec![false; 2000], vec![false; 2000]];
    for (k, channels) in [
        (700, [true, false]),
        (900, [false, true]),
        (1200, [true, true]),
    ] {
        for (flags, is_aside) in flags.iter_mut().zip(channels) {
            flags[k] = is_aside;
            flags[k + 1] = is_aside;
        }
    }
    let run = |by: f64| {
        let mut values = [sim.measured[0].clone(), sim.measured[1].clone()];
        for (values, flags) in values.iter_mut().zip(&flags) {
            let aside = values.iter_mut().zip(flags).filter(|(_, aside)| **aside);
            aside.for_each(|(value, _)| *value += by);
        }
        let channels = Channels {
            aside: [&flags[0], &flags[1], &[]],
            ..Channels::new(&sim.t, &values[0], Some(&values[1]), None).unwrap()
        };
        let steps = model.filter(&channels, 0..2000);
        let q: Vec<f64> = steps.iter().map(|step| step.mean[0]).collect();
        let fast = model.log_likelihood(&channels, 0..2000, 0.005);
        let full = model.log_likelihood(&channels, 0..2000, 1.0);
        assert!((fast - full).abs() < 1e-4, "{fast} against {full}");
        (q, fast)
    };
    assert_eq!(run(0.0), run(100.0));
}

/// What stands in the place of wild samples is on no step of the encoder, and hides these.
#[test]
fn samples_that_are_set_aside_hide_no_steps() {
    let step = 1e-3;
    let t: Vec<f64> = (0..2000).map(|k| 0.005 * f64::from(k)).collect();
    let turned = |t: f64| 0.4 * (1.1 * t).sin() + 0.1 * (2.3 * t).cos();
    let mut q: Vec<f64> = t
        .iter()
        .map(|&t| (turned(t) / step).round() * step)
        .collect();
    let mut flags = vec![false; q.len()];
    for k in (20..2000).step_by(60) {
        flags[k] = true;
        q[k] = turned(t[k]);
    }
    let channels = Channels {
        aside: [&flags, &[], &[]],
        ..Channels::new(&t, &q, None, None).unwrap()
    };
    let smoothed = Smoother::fit(&channels).unwrap().apply(&channels).unwrap();
    let least = step / 12_f64.sqrt();
    assert!(
        smoothed.noise.sd_q > 0.99 * least,
        "{}",
        smoothed.noise.sd_q
    );
}

#[test]
fn midpoints_follow_the_motion() {
    let sim = simulate(jittered(2000, 0.005), SD, 3);
    let channels = Channels::new(&sim.t, &sim.measured[0], Some(&sim.measured[1]), None).unwrap();
    let smoothed = Smoother::fit(&channels).unwrap().apply(&channels).unwrap();
    let midpoints = smoothed.midpoints();
    assert_eq!(midpoints.len(), 1999);
    for midpoint in &midpoints {
        let k = midpoint.after;
        let [q, v, a] = motion(midpoint.t);
        let at = smoothed.between(k, 0.5).unwrap();
        assert_eq!(at, midpoint.state);
        assert!((at.q - q).abs() < 6.0 * smoothed.sd_q[k]);
        assert!((at.v - v).abs() < 6.0 * smoothed.sd_v[k]);
        assert!((at.a - a).abs() < 6.0 * smoothed.sd_a[k]);
    }
    assert_eq!(smoothed.between(1999, 0.5), None);
}

#[test]
fn gaps_are_not_bridged() {
    let mut t = even(600, 0.005);
    t[300..].iter_mut().for_each(|stamp| *stamp += 0.4);
    let sim = simulate(t, SD, 9);
    let channels = Channels::new(&sim.t, &sim.measured[0], None, None).unwrap();
    let smoothed = Smoother::fit(&channels).unwrap().apply(&channels).unwrap();
    assert_eq!(smoothed.segments, vec![0..300, 300..600]);
    assert_eq!(smoothed.between(299, 0.5), None);
    assert_eq!(smoothed.midpoints().len(), 598);
    assert!(rms(&smoothed.v, &sim.truth[1]) < 0.1);
}

#[test]
fn degenerate_channels_give_finite_states() {
    let t = even(200, 0.01);
    let constant = vec![0.7; 200];
    let ramp: Vec<f64> = t.iter().map(|t| 1.0 + 2.0 * t).collect();
    let exact: Vec<f64> = t.iter().map(|t| motion(*t)[0]).collect();
    let alternating: Vec<f64> = (0..200).map(|k| f64::from(k % 2)).collect();
    let huge: Vec<f64> = exact.iter().map(|x| 1e12 * x).collect();
    let tiny: Vec<f64> = exact.iter().map(|x| 1e-15 * x).collect();
    for q in [constant, ramp, exact, alternating, huge, tiny] {
        let channels = Channels::new(&t, &q, None, None).unwrap();
        let smoothed = Smoother::fit(&channels).unwrap().apply(&channels).unwrap();
        let states = [
            &smoothed.q,
            &smoothed.v,
            &smoothed.a,
            &smoothed.sd_q,
            &smoothed.sd_v,
            &smoothed.sd_a,
        ];
        assert!(states.iter().all(|x| x.iter().all(|x| x.is_finite())));
        let scale = q.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(rms(&smoothed.q, &q) < 0.6 * scale);
    }
}

#[test]
fn exact_data_gives_exact_derivatives() {
    let t = even(1000, 0.005);
    let q: Vec<f64> = t.iter().map(|t| motion(*t)[0]).collect();
    let a: Vec<f64> = t.iter().map(|t| motion(*t)[2]).collect();
    let channels = Channels::new(&t, &q, None, None).unwrap();
    let smoothed = Smoother::fit(&channels).unwrap().apply(&channels).unwrap();
    let error = rms(&smoothed.a[10..990], &a[10..990]);
    assert!(error < 0.02, "rms error {error} of 27 rad/s²");
}

#[test]
fn bad_channels_are_refused() {
    let t = even(30, 0.01);
    let q = vec![0.0; 30];
    let mut bad = q.clone();
    bad[7] = f64::NAN;
    let mut backwards = t.clone();
    backwards[5] = 0.0;
    let plain = Channels::new(&t, &q, None, None).unwrap();
    let with_velocity = Channels::new(&t, &q, Some(&q), None).unwrap();
    let none = Channels::new(&[], &[], None, None).unwrap();
    let errors = [
        Channels::new(&t, &q[1..], None, None).unwrap_err(),
        Channels::new(&t, &q, Some(&bad), None).unwrap_err(),
        Channels::new(&backwards, &q, None, None).unwrap_err(),
        Smoother::fit(&Channels::new(&t[..9], &q[..9], None, None).unwrap()).unwrap_err(),
        Smoother::fit(&plain)
            .unwrap()
            .apply(&with_velocity)
            .unwrap_err(),
        Smoother::fit(&plain).unwrap().apply(&none).unwrap_err(),
    ];
    let shown: Vec<String> = errors.iter().map(ToString::to_string).collect();
    insta::assert_snapshot!(shown.join("\n"));
}

/// A joint that spins up: its fastest turn changes within three samples, so that one intensity
/// for all of the motion leaves no noise at all.
#[test]
fn calm_stretches_tell_the_noise_of_wild_motion() {
    let t = even(2000, 0.01);
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let turning = |t: f64| {
        let phase = 2.0 * t + 0.04 * t.powi(3);
        phase + 0.3 * phase.sin()
    };
    let truth: Vec<f64> = t.iter().map(|&t| turning(t)).collect();
    let measured: Vec<f64> = truth.iter().map(|q| q + 2e-4 * draw()).collect();
    let channels = Channels::new(&t, &measured, None, None).unwrap();
    let smoother = Smoother::fit(&channels).unwrap();
    let found = smoother.noise().sd_q;
    assert!((1.6e-4..2.4e-4).contains(&found), "{found}");
}

/// A linkage that snaps through once: accelerations of one moment alone must not pass for those
/// of all the motion, which would leave their sensor no noise, nor for errors that follow one
/// another.
#[test]
fn one_flash_does_not_hide_the_noise_of_accelerations() {
    let t = even(4000, 0.004);
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let mut noisy = |x: f64, sd: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut random);
        x + sd * z
    };
    let (width, jump) = (0.012, 0.15);
    let (mut q, mut dq, mut ddq) = (Vec::new(), Vec::new(), Vec::new());
    for t in &t {
        let through = ((t - 9.62) / width).tanh();
        let rate = (1.0 - through * through) / width;
        q.push(noisy(t.sin() + jump * through, 4e-4));
        dq.push(noisy(t.cos() + jump * rate, 0.03));
        ddq.push(noisy(-t.sin() - 2.0 * jump * through * rate / width, 0.3));
    }
    let channels = Channels::new(&t, &q, Some(&dq), Some(&ddq)).unwrap();
    let smoother = Smoother::fit(&channels).unwrap();
    let found = smoother.noise().sd_ddq.unwrap();
    assert!((0.27..0.33).contains(&found), "{found}");
    let smoothed = smoother.apply(&channels).unwrap();
    let follow = |channel: &Innovations| channel.lag_1.abs();
    assert!(
        smoothed
            .innovations
            .iter()
            .all(|channel| follow(channel) < 0.3)
    );
}
