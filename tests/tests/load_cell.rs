//! Load cells in a log: what a constraint bears shows in no motion.

use dynamics_codegen::Library;
use identify::log::Log;
use identify::trace::{Outcome, Request, Verdict, trace};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::fmt::Write;

/// A bob of 0.5 kg on a rod of 0.8 m, which pulls at a load cell.
const BOB: &str = "\
model bob;
coordinate x: m;
coordinate y: m;
parameter m: kg = 0.5 in 0.1..2;
constant l: m = 0.8;
body bob { frame: translate(x, y, 0); mass: m; }
gravity (0, -9.81, 0);
constraint rod: x^2 + y^2 == l^2;
sensor cell: N = -2*l*multiplier(rod);
";

/// Twelve seconds of its swings from 1.3 rad, where the cell reads `reading` of what the rod bears:
/// `T = m (l ω² + g cos θ)`, with `θ̈ = −g/l sin θ` by a step of Runge and Kutta.
fn swings(mass: f64, columns: &[&str], reading: impl Fn(f64) -> f64) -> String {
    let (l, g, h) = (0.8, 9.81, 1e-3);
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut text = format!("t,{}\n", columns.join(","));
    let (mut angle, mut rate) = (1.3_f64, 0.0_f64);
    let fall = |angle: f64| -g / l * f64::sin(angle);
    for tick in 0..12_000 {
        if tick % 10 == 0 {
            let mut noise = |sd: f64| sd * random.sample::<f64, _>(StandardNormal);
            let tension = mass * (l * rate * rate + g * angle.cos());
            let all = [
                ("q_x", l * angle.sin() + noise(2e-4)),
                ("q_y", -l * angle.cos() + noise(2e-4)),
                ("cell", reading(tension) + noise(0.02)),
            ];
            write!(text, "{}", f64::from(tick) * h).unwrap();
            for (_, value) in all.iter().filter(|(name, _)| columns.contains(name)) {
                write!(text, ",{value}").unwrap();
            }
            text.push('\n');
        }
        let a = [rate, fall(angle)];
        let b = [rate + h / 2.0 * a[1], fall(angle + h / 2.0 * a[0])];
        let c = [rate + h / 2.0 * b[1], fall(angle + h / 2.0 * b[0])];
        let d = [rate + h * c[1], fall(angle + h * c[0])];
        angle += h / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0]);
        rate += h / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1]);
    }
    text
}

fn traced(log: &str) -> Outcome {
    let log = Log::from_bytes("bob.csv", log.as_bytes()).unwrap();
    trace(&Request::new("bob", BOB, &Library::builtin(), &log)).unwrap()
}

const ALL: [&str; 3] = ["q_x", "q_y", "cell"];

#[test]
fn a_right_load_cell_says_nothing() {
    let outcome = traced(&swings(0.5, &ALL, |tension| tension));
    assert_eq!(outcome.verdict, Verdict::None, "{:#?}", outcome.findings);
    let noise = outcome.sensor_noise["cell"];
    assert!((noise / 0.02 - 1.0).abs() < 0.1, "{noise}");
}

#[test]
fn a_load_cell_with_an_offset_is_named() {
    let outcome = traced(&swings(0.5, &ALL, |tension| tension + 0.4));
    let [found] = &outcome.findings[..] else {
        panic!("{:#?}", outcome.findings);
    };
    let name = (found.effect.as_str(), &found.on[..]);
    assert_eq!(name, ("measurement_offset", &["cell".to_string()][..]));
    let offset = &found.parameters["offset"];
    let miss = (offset.value - 0.4).abs();
    assert!(miss < 3.0 * offset.std && offset.std < 0.01, "{offset:?}");
}

/// A pendulum swings alike whatever its bob weighs: but for the load cell nothing tells. It may read too
/// much, of course.
#[test]
fn a_heavy_bob_is_felt_by_the_load_cell_alone() {
    let unseen = traced(&swings(0.6, &["q_x", "q_y"], |tension| tension));
    assert_eq!(unseen.verdict, Verdict::None, "{:#?}", unseen.findings);
    let outcome = traced(&swings(0.6, &ALL, |tension| tension));
    let [found] = &outcome.findings[..] else {
        panic!("{:#?}", outcome.findings);
    };
    let rivals = found.confounded_with.iter();
    let mut names: Vec<(&str, &[String])> =
        rivals.map(|r| (r.effect.as_str(), &r.on[..])).collect();
    names.push((&found.effect, &found.on));
    let wanted = [("parameter", "m"), ("measurement_scale", "cell")];
    for (effect, on) in wanted {
        assert!(
            names.contains(&(effect, &[on.to_string()][..])),
            "{names:?}"
        );
    }
    let number = found.parameters.values().next().unwrap();
    let share = number.value
        / if found.effect == "parameter" {
            0.5
        } else {
            1.0
        };
    assert!((share - 1.2).abs() < 0.01, "{number:?}");
}
