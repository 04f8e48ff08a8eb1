//! The robot-arm study (thesis 5.3) in small: its parts, and what must hold.

use crate::arm::{Arm, N, PLANE, State, TRUE_END};
use crate::models::{DIMS, Kind};
use crate::training::Effort;
use crate::{control, motion, network, study};
use rand::{RngExt, SeedableRng};

#[test]
fn references_are_trapezoids_that_meet_end_to_end() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    for s in control::path(50, &mut rng) {
        let (first, last) = (s.at(0.0), s.at(s.seconds));
        assert!(first.velocity.norm() < 1e-12 && last.velocity.norm() < 1e-12);
        let h = 1e-6;
        for k in 1..40 {
            let t = s.seconds * f64::from(k) / 40.0;
            let (before, at, after) = (s.at(t - h), s.at(t), s.at(t + h));
            let v = (after.position - before.position) / (2.0 * h);
            assert!((v - at.velocity).norm() < 1e-6, "{t}");
            assert!(at.acceleration.norm() < 1.0 + 1e-9);
            assert!((at.position[2] - first.position[2]).abs() < 1e-12);
        }
    }
}

#[test]
fn slopes_in_the_last_link_agree_with_differences() {
    let arm = Arm::new().unwrap();
    let x = State {
        q: control::rest(),
        v: [0.3, -0.2, 0.5, 0.1, -0.4, 0.6, -0.1],
        ..State::zero()
    };
    let slopes = arm.slopes(&x);
    for (i, slope) in slopes.iter().enumerate() {
        let h = 1e-6;
        let terms = |sign: f64| {
            let mut end = TRUE_END;
            end[i] += sign * h;
            arm.known(end).terms(&x)
        };
        let (low, high) = (terms(-1.0), terms(1.0));
        for k in 0..N {
            let d = (high.bias[k] - low.bias[k]) / (2.0 * h);
            assert!((d - slope.bias[k]).abs() < 1e-6 * (1.0 + d.abs()));
            for j in 0..N {
                let d = (high.mass[(k, j)] - low.mass[(k, j)]) / (2.0 * h);
                assert!((d - slope.mass[N * k + j]).abs() < 1e-6 * (1.0 + d.abs()));
            }
        }
    }
}

#[test]
fn slopes_of_the_network_agree_with_differences() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let mut numbers =
        |n: usize| -> Vec<f64> { (0..n).map(|_| rng.random_range(-2.0..2.0)).collect() };
    let pairs: Vec<network::Pair> = (0..4)
        .map(|_| (numbers(DIMS), numbers(N).try_into().unwrap()))
        .collect();
    let batch: Vec<&network::Pair> = pairs.iter().collect();
    let parameters = network::start(&mut rng);
    let (_, gradient) = network::loss(&parameters, &batch);
    let h = 1e-5;
    for i in (0..network::PARAMETERS).step_by(7) {
        let at = |step: f64| {
            let mut moved = parameters.clone();
            moved[i] += step;
            network::loss(&moved, &batch).0
        };
        let slope = (at(h) - at(-h)) / (2.0 * h);
        assert!(
            (slope - gradient[i]).abs() < 1e-8,
            "{i}: {slope} {}",
            gradient[i]
        );
    }
}

#[test]
fn the_study_holds_in_small() {
    let plan = study::Plan {
        train: (8, 21),
        test: (5, 22),
        sizes: vec![50],
        held_out: 60,
        network: (100, 500),
        link: 50,
        effort: Effort {
            iterations: 25,
            further: 10,
            anew: 300,
        },
    };
    let data = study::data(&plan).unwrap();
    assert!(data.violation < 1e-6, "tip {} m off", data.violation);
    // The controller keeps the tip where it is sent, and pressed on the plane.
    for (t, tip) in &data.test_run.tip {
        assert!(
            tip[0].abs() < 0.51 && (0.39..0.61).contains(&tip[1]),
            "{t}: {tip:?}"
        );
        assert!((tip[2] - PLANE).abs() < 1e-6);
    }
    assert!(data.test_run.samples.iter().all(|s| s.lambda > 0.0));
    // Filter and differences leave nothing but the noise that was added.
    let squares = data
        .test
        .iter()
        .flat_map(|s| (0..N).map(move |i| s.measured[i] - s.truth[i]));
    let square: f64 = squares.map(|e| e * e).sum();
    let sd = (square / (N * data.test.len()) as f64).sqrt();
    assert!((0.08..0.13).contains(&sd), "{sd}");

    let (scores, fits) = study::curves(&data, &plan, &|s| {
        println!("{:<24} {:.4} {:.1e}", s.kind.name(), s.error, s.constraint);
    })
    .unwrap();
    let ours = fits
        .iter()
        .find(|f| f.kind == Kind::ForcePriorMean)
        .unwrap();
    let m = study::multipliers(&data, ours).unwrap();
    println!(
        "λ: coverage {:.3}, error {:.3}, half width {:.3} N",
        m.coverage, m.error, m.half_width
    );
    let networks = study::networks(&data, &plan).unwrap();
    println!("{networks:?}");
    assert_eq!(
        study::faults(&scores, &networks, std::slice::from_ref(&m), false),
        Vec::<String>::new()
    );
    // A band that says nothing would hold everything.
    assert!(m.half_width < m.spread, "{} {}", m.half_width, m.spread);
    let known = study::analytical(&data.arm, TRUE_END, &data.test).unwrap();
    let known = study::mean(&study::errors(&known, &data.test));
    let score = scores
        .iter()
        .find(|s| s.kind == Kind::ForcePriorMean)
        .unwrap();
    assert!(score.error < 0.5 * known, "{} {known}", score.error);

    let se = fits.iter().find(|f| f.kind == Kind::Se).unwrap();
    let window = &data.test_run.samples[..73];
    let motions = motion::motions(&data.arm, window, se, ours, 31).unwrap();
    let end = |i: usize| motions[i].height[motions[i].height.len() - 1].abs();
    let [drifting, held] = [2, 3].map(end);
    println!("height after 0.3 s: GP² {drifting:.1e} m, with Baumgarte {held:.1e} m");
    assert!(held < 0.2 * drifting, "{drifting} {held}");
}
