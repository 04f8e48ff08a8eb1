//! Single samples that are no measurements: the verdict is what it is without them.

use dynamics_codegen::Library;
use identify::log::Log;
use identify::trace::{HoldIs, Outcome, Request, Verdict, trace};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::fmt::Write;

/// The pendulum that is asked about; the one that moved has friction besides.
const MODEL: &str = "\
model pendulum;
coordinate j: rad;
input j: N*m;
parameter m: kg = 0.5 in 1e-4..;
parameter l: m = 0.5 in 1e-4..;
constant g: m/s^2 = 9.81;
kinetic m*l^2/2*dot(j)^2;
potential -m*g*l*cos(j);
force j = input(j);
";
const INERTIA: f64 = 0.5 * 0.5 * 0.5;
const WEIGHT: f64 = 0.5 * 9.81 * 0.5;
const DAMPING: f64 = 0.05;

/// A table of stamps, positions, velocities and inputs.
type Table = Vec<[f64; 4]>;

fn torque(t: f64) -> f64 {
    1.5 * (1.3 * t).sin() + (3.7 * t).sin()
}

/// What a log of these stamps says that has this torque, the one at the pivot at a time and a
/// velocity being as given.
fn table(
    stamps: &[f64],
    logged: impl Fn(f64) -> f64,
    at_pivot: impl Fn(f64, f64) -> f64,
    seed: u64,
) -> Table {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let (mut q, mut v, mut now) = (0.5, 0.0, 0.0);
    let slope = |t: f64, q: f64, v: f64| (at_pivot(t, v) - WEIGHT * q.sin()) / INERTIA;
    stamps
        .iter()
        .map(|&t| {
            let steps = ((t - now) / 2e-4).ceil();
            let h = (t - now) / steps;
            for _ in 0..steps as usize {
                // The midpoint rule, which sees no jump at either end.
                let (q_m, v_m) = (q + 0.5 * h * v, v + 0.5 * h * slope(now + 1e-3 * h, q, v));
                q += h * v_m;
                v += h * slope(now + 0.5 * h, q_m, v_m);
                now += h;
            }
            [t, q + 1e-4 * normal(), v + 1e-3 * normal(), logged(t)]
        })
        .collect()
}

/// The torque less friction.
fn damped(damping: f64) -> impl Fn(f64, f64) -> f64 {
    move |t, v| torque(t) - damping * v
}

fn even(samples: usize) -> Vec<f64> {
    (0..samples).map(|k| 0.01 * k as f64).collect()
}

/// What is said of a table, with or without velocities.
fn said(table: &Table, with_velocity: bool) -> Outcome {
    let mut text = match with_velocity {
        true => String::from("t,q_j,dq_j,u_j\n"),
        false => String::from("t,q_j,u_j\n"),
    };
    for [t, q, dq, u] in table {
        match with_velocity {
            true => writeln!(text, "{t},{q},{dq},{u}").unwrap(),
            false => writeln!(text, "{t},{q},{u}").unwrap(),
        }
    }
    let log = Log::from_bytes("swing.csv", text.as_bytes()).unwrap();
    trace(&Request::new("pendulum", MODEL, &Library::builtin(), &log)).unwrap()
}

fn found(outcome: &Outcome) -> Vec<&str> {
    outcome.findings.iter().map(|f| f.effect.as_str()).collect()
}

fn assert_viscous(outcome: &Outcome, of: &str) {
    assert_eq!(
        outcome.verdict,
        Verdict::Effect,
        "{of}: {:?}",
        outcome.warnings
    );
    assert_eq!(found(outcome), ["viscous"], "{of}: {:?}", outcome.warnings);
    let d = &outcome.findings[0].parameters["d"];
    assert!((d.value - DAMPING).abs() < 3.0 * d.std, "{of}: {d:?}");
}

#[test]
fn one_wild_sample_changes_no_verdict() {
    let clean = table(&even(600), torque, damped(DAMPING), 3);
    let reference = said(&clean, false);
    assert_viscous(&reference, "clean");
    assert_eq!(reference.warnings, [""; 0]);
    // Where it is learnt from, and where it is judged.
    for (column, name, by) in [
        (1, "q_j", 1.0),
        (1, "q_j", TAU),
        (1, "q_j", 100.0),
        (3, "u_j", 100.0),
    ] {
        for line in [150, 480] {
            let mut table = clean.clone();
            table[line - 2][column] += by;
            let outcome = said(&table, false);
            let of = format!("{name} + {by} on line {line}");
            assert_viscous(&outcome, &of);
            let place = format!("line {line}: `{name}` is ");
            let told = outcome.warnings.iter().any(|w| w.starts_with(&place));
            assert!(told, "{of}: {:?}", outcome.warnings);
        }
    }
}

#[test]
fn one_wild_sample_in_a_hundred_changes_no_verdict() {
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(100 + seed);
        for damping in [0.0, DAMPING] {
            let mut table = table(&even(900), torque, damped(damping), seed);
            for sample in &mut table {
                for cell in &mut sample[1..] {
                    if random.random::<f64>() < 0.01 {
                        let size = 10.0_f64.powf(3.0 * random.random::<f64>() - 1.0);
                        *cell += if random.random::<f64>() < 0.5 {
                            size
                        } else {
                            -size
                        };
                    }
                }
            }
            let outcome = said(&table, true);
            let of = format!("seed {seed}, damping {damping}");
            match damping {
                0.0 => assert_eq!(
                    outcome.verdict,
                    Verdict::None,
                    "{of}: {:?}",
                    found(&outcome)
                ),
                _ => assert_viscous(&outcome, &of),
            }
        }
    }
}

/// More samples in a row than can be told from a motion are wrong, where the model is judged.
#[test]
fn nothing_missing_is_not_said_above_an_error_that_is_large() {
    let mut table = table(&even(600), torque, damped(0.0), 5);
    for sample in &mut table[480..488] {
        sample[1] += 100.0;
    }
    let outcome = said(&table, false);
    assert_eq!(outcome.verdict, Verdict::Unknown, "{:?}", outcome.after);
    let told = |w: &String| w.starts_with("the search found nothing missing, but");
    assert!(outcome.warnings.iter().any(told), "{:?}", outcome.warnings);
}

/// What is said of a torque that is held from one stamp to the next, 5 ms late, where stamps are irregular.
fn said_of_late(torque: impl Fn(f64) -> f64) -> Outcome {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut stamps = even(2400);
    for t in &mut stamps[1..] {
        *t *= 0.5;
        *t += 0.003 * (random.random::<f64>() - 0.5);
    }
    let held = |t: f64, _: f64| {
        let sent = stamps.partition_point(|&stamp| stamp <= t - 0.005);
        torque(stamps[sent.max(1) - 1])
    };
    let outcome = said(&table(&stamps, &torque, held, 4), false);
    let found = found(&outcome);
    // That the sensor is early by as much is the same.
    assert!(
        matches!(found[..], ["input_delay" | "time_shift"]),
        "{found:?}"
    );
    outcome
}

#[test]
fn a_held_input_that_is_late_is_found_under_stamps_that_jitter() {
    let lively = |t: f64| torque(t) + 2.0 * (11.0 * t).sin() + 2.0 * (23.0 * t).sin();
    let outcome = said_of_late(lively);
    let tau = &outcome.findings[0].parameters["tau"];
    let error = (tau.value - 0.005).abs();
    assert!(error < 2.0 * tau.std && error < 5e-4, "{tau:?}");
    assert_eq!(outcome.input_hold_is, HoldIs::Found);
}

/// What a slow torque does between samples is within the noise: drawn straight it is half a sample later.
/// Both times are said, and the standard deviation covers both.
#[test]
fn a_held_input_that_is_slow_has_two_times() {
    let outcome = said_of_late(torque);
    let tau = &outcome.findings[0].parameters["tau"];
    assert_eq!(outcome.input_hold_is, HoldIs::Undecided);
    let otherwise: Vec<f64> = outcome.if_held_otherwise.into_values().collect();
    let [otherwise] = otherwise[..] else {
        panic!("{otherwise:?}");
    };
    let times = [tau.value.min(otherwise), tau.value.max(otherwise)];
    for (time, expected) in times.into_iter().zip([0.005, 0.0075]) {
        assert!((time - expected).abs() < 3e-4, "{times:?}");
        let apart = (tau.value - expected).abs();
        assert!(apart < 2.0 * tau.std && tau.std < 3e-3, "{tau:?}");
    }
}
