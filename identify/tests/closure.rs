//! A cam and its follower: what a constraint tells that no acceleration does.

use dynamics_codegen::Library;
use identify::log::Log;
use identify::trace::{Finding, Outcome, Request, Silent, Verdict, trace};
use std::collections::BTreeMap;
use std::fmt::Write;

const CAM: &str = "\
model cam;
coordinate angle: rad;
coordinate height: m;
input angle: N*m;
parameter i: kg*m^2 = 0.02;
parameter m: kg = 0.5;
parameter lift: m = 0.1;
kinetic i/2*dot(angle)^2 + m/2*dot(height)^2;
force angle = input(angle);
constraint cam: height == lift*(angle^2 + angle);
";

/// A log of a cam with this lift, whose angle is read with an offset: `a = 0.5 sin 2t + 0.3 sin 5t`,
/// `b = l (a² + a)`, and by d'Alembert `u = i a″ + m b″ ∂b/∂a`.
fn log(lift: f64, offset: f64) -> Log {
    let mut text = String::from("t,q_angle,q_height,u_angle\n");
    let waves = [(0.5_f64, 2.0_f64), (0.3, 5.0)];
    let mut random: u64 = 9;
    let mut noise = || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    for k in 0..2000 {
        let t = 0.005 * f64::from(k);
        let a: f64 = waves.iter().map(|(x, w)| x * (w * t).sin()).sum();
        let v: f64 = waves.iter().map(|(x, w)| x * w * (w * t).cos()).sum();
        let acceleration: f64 = waves.iter().map(|(x, w)| -x * w * w * (w * t).sin()).sum();
        let slope = lift * (2.0 * a + 1.0);
        let rise = slope * acceleration + 2.0 * lift * v * v;
        let u = 0.02 * acceleration + 0.5 * rise * slope;
        let read = [
            a + offset + 4e-4 * noise(),
            lift * (a * a + a) + 1e-4 * noise(),
        ];
        writeln!(text, "{t},{},{},{u}", read[0], read[1]).unwrap();
    }
    Log::from_bytes("cam.csv", text.as_bytes()).unwrap()
}

fn traced(log: &Log) -> Outcome {
    let request = Request {
        model_name: "cam",
        model_text: CAM,
        library: &Library::builtin(),
        parameters: BTreeMap::new(),
        train: log,
        test: None,
        hold: None,
        horizon: 0.5,
        seed: 1,
        progress: &Silent,
    };
    trace(&request).unwrap()
}

fn only(outcome: &Outcome) -> &Finding {
    let [finding] = &outcome.findings[..] else {
        panic!("{:#?}", outcome.findings);
    };
    finding
}

#[test]
fn what_closes_is_the_machine() {
    assert_eq!(traced(&log(0.1, 0.0)).verdict, Verdict::None);
}

/// Also one that no geometry a little off explains.
#[test]
fn an_offset_breaks_the_constraint() {
    for offset in [0.02, -0.3] {
        let outcome = traced(&log(0.1, offset));
        let found = only(&outcome);
        assert_eq!(outcome.verdict, Verdict::Channel);
        assert_eq!(
            (found.effect.as_str(), &found.on[0][..]),
            ("measurement_offset", "angle")
        );
        let estimate = &found.parameters["offset"];
        let miss = (estimate.value - offset).abs();
        assert!(
            miss < 3.0 * estimate.std + 1e-6 && miss < 1e-4,
            "{estimate:?}"
        );
    }
}

#[test]
fn a_length_that_is_wrong_is_a_parameter() {
    let outcome = traced(&log(0.104, 0.0));
    let found = only(&outcome);
    assert_eq!(outcome.verdict, Verdict::Parameter);
    assert_eq!(found.on, ["lift"]);
    let estimate = &found.parameters["lift"];
    assert!((estimate.value - 0.104).abs() < 1e-5, "{estimate:?}");
}
