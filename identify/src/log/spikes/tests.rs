//! What is wild, and what only looks so.

use crate::log::{Log, Record, Warning};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const STEP: f64 = 0.01;

/// Even noise from −0.5 to 0.5.
fn rectangular(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    move || random.random::<f64>() - 0.5
}

/// A log of a cart of one kilogram that is pushed by `u`, with noise on its position; its cells
/// are changed before it is written.
fn cart(u: impl Fn(usize) -> f64, change: impl Fn(usize, &mut [f64; 4])) -> Record {
    let mut noise = rectangular(3);
    let (mut q, mut v) = (0.2, 0.0);
    let mut text = String::from("# cart\nt,q_x,dq_x,u_x,ucmd_x\n");
    for k in 0..600 {
        let mut cells = [q + 2e-4 * noise(), v + 2e-3 * noise(), u(k), u(k)];
        change(k, &mut cells);
        let [q_x, dq_x, u_x, ucmd_x] = cells;
        text += &format!("{},{q_x},{dq_x},{u_x},{ucmd_x}\n", STEP * k as f64);
        q += v * STEP + 0.5 * u(k) * STEP * STEP;
        v += u(k) * STEP;
    }
    let names = ["x".to_string()];
    let log = Log::from_bytes("cart.csv", text.as_bytes()).unwrap();
    log.select(&names, &names).unwrap()
}

fn wave(k: usize) -> f64 {
    let t = STEP * k as f64;
    1.5 * (1.3 * t).cos() + (3.7 * t).cos()
}

fn wild(record: &Record) -> Vec<String> {
    let all = record.warnings.iter();
    let wild = all.filter(|w| matches!(w, Warning::Wild { .. }));
    wild.map(ToString::to_string).collect()
}

#[test]
fn one_wild_cell_is_named_and_replaced() {
    let clean = cart(wave, |_, _| {});
    for cell in 0..4 {
        for by in [1.0, -std::f64::consts::TAU, 100.0] {
            for at in [0, 1, 77, 300, 598, 599] {
                let record = cart(wave, |k, cells| {
                    if k == at {
                        cells[cell] += by;
                    }
                });
                let said = wild(&record);
                // An input may begin and end anywhere that is usual for it.
                let is_end = cell > 1 && (at == 0 || at == 599);
                if is_end && by != 100.0 && said.is_empty() {
                    continue;
                }
                let column = ["q_x", "dq_x", "u_x", "ucmd_x"][cell];
                assert_eq!(said.len(), 1, "{column} at {at} by {by}: {said:?}");
                let place = format!("line {}: `{column}` is ", at + 3);
                assert!(said[0].starts_with(&place), "{said:?}");
                let channels = |r: &Record| {
                    let all = [&r.q[0], r.dq[0].as_ref().unwrap(), &r.u[0]];
                    let commanded = r.commanded[0].as_ref().unwrap();
                    [all[0][at], all[1][at], all[2][at], commanded[at]]
                };
                let (mended, right) = (channels(&record), channels(&clean));
                for (a, b) in mended.iter().zip(right) {
                    assert!(
                        (a - b).abs() < 0.02,
                        "{column} at {at}: {mended:?}, {right:?}"
                    );
                }
                let flags = record.aside.of(0).map(|flags| flags.get(at) == Some(&true));
                assert_eq!(flags, [cell == 0, cell == 1, false]);
            }
        }
    }
}

#[test]
fn wild_cells_next_to_each_other_are_all_found() {
    for many in [
        vec![300, 301],
        vec![300, 301, 302],
        vec![300, 302, 304],
        vec![300, 304, 307],
        vec![300, 301, 302, 303],
    ] {
        let record = cart(wave, |k, cells| {
            if many.contains(&k) {
                cells[0] += if k == 301 { -3.0 } else { 1.0 };
            }
        });
        let set_aside = record.aside.q[0].iter().filter(|&&a| a).count();
        assert_eq!(set_aside, many.len(), "{:?}", wild(&record));
    }
}

/// The neighbours of four of them are most samples there are for a while.
#[test]
fn many_wild_inputs_in_a_short_time_are_all_found() {
    let many = [(56, 0.8), (68, 1.0), (71, 2.7), (82, -0.7)];
    let record = cart(wave, |k, cells| {
        let own = many.iter().find(|(at, _)| *at == k);
        cells[2] += own.map_or(0.0, |(_, by)| *by);
    });
    for (at, _) in many {
        assert!(
            (record.u[0][at] - wave(at)).abs() < 1e-2,
            "{at}: {:?}",
            wild(&record)
        );
    }
}

/// A machine that is hit, an input that switches, and one that is a short blow: real, all of them.
#[test]
fn what_the_machine_answers_to_is_real() {
    let blow = |k: usize| if k == 300 { 60.0 } else { 0.2 * wave(k) };
    let record = cart(blow, |_, _| {});
    assert_eq!(record.u[0][300], 60.0);
    assert_eq!(wild(&record), [""; 0]);
    // The same where nothing moves for it.
    let record = cart(
        |k| 0.2 * wave(k),
        |k, cells| {
            if k == 300 {
                cells[2] = 60.0;
            }
        },
    );
    assert_eq!(wild(&record).len(), 1);
}

#[test]
fn signals_that_step_are_not_wild() {
    let switching = |k: usize| {
        if (k / 40).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    };
    let held = |k: usize| wave(k - k % 5);
    let mut random = rectangular(11);
    let noise: Vec<f64> = (0..600).map(|_| random()).collect();
    // Now and then for one sample only.
    let telegraph: Vec<f64> = noise
        .iter()
        .scan(1.0, |level, x| {
            if *x > 0.45 {
                *level = -*level;
            }
            Some(*level)
        })
        .collect();
    let inputs: [&dyn Fn(usize) -> f64; 5] =
        [&switching, &held, &|k| noise[k], &|k| telegraph[k], &|k| {
            if k < 200 { 0.0 } else { wave(k) }
        }];
    for input in inputs {
        assert_eq!(wild(&cart(input, |_, _| {})), [""; 0]);
    }
}

/// A controller that begins with a large error: its first two commands are alike, as it sees the same twice, and
/// fall fast from there. What ends a log may be as violent.
#[test]
fn a_log_may_begin_and_end_with_a_corner() {
    let violent = |k: usize| {
        let since = (k as f64 - 1.0).max(0.0);
        wave(k) * 0.1 + 60.0 * (-0.3 * since).exp() * (0.4 * since).cos()
    };
    let record = cart(violent, |_, _| {});
    assert_eq!(wild(&record), [""; 0]);
    let record = cart(|k| violent(599 - k), |_, _| {});
    assert_eq!(wild(&record), [""; 0]);
}

/// A controller that is switched on far from its goal rings, faster than the log can show.
#[test]
fn commands_that_ring_where_a_log_begins_are_not_wild() {
    let ringing = [
        0.0, -13.8, -10.0, 11.5, 13.1, 0.8, -6.2, -2.6, 2.7, 2.9, 0.1, -1.5,
    ];
    let rings = |k: usize| ringing.get(k).copied().unwrap_or(0.0);
    let record = cart(|k| wave(k) + rings(k), |_, _| {});
    assert_eq!(wild(&record), [""; 0]);
    let ends = cart(|k| wave(k) + rings(599 - k), |_, _| {});
    assert_eq!(wild(&ends), [""; 0]);
}

/// A ball on the floor: its velocity jumps, its position has a corner.
#[test]
fn a_bounce_is_not_wild() {
    for noise in [0.0, 1e-4, 1e-3] {
        let mut random = rectangular(5);
        let mut text = String::from("t,q_z,dq_z\n");
        let (mut q, mut v) = (1.0, 0.0);
        for k in 0..1000 {
            let (q_z, dq_z) = (q + noise * random(), v + 10.0 * noise * random());
            text += &format!("{},{q_z},{dq_z}\n", STEP * f64::from(k));
            v -= 9.81 * STEP;
            q += v * STEP;
            if q < 0.0 {
                (q, v) = (-q, -0.9 * v);
            }
        }
        let log = Log::from_bytes("ball.csv", text.as_bytes()).unwrap();
        let record = log.select(&["z".to_string()], &[]).unwrap();
        assert_eq!(wild(&record), [""; 0], "noise {noise}");
    }
}

/// A wild sample neither hides that an angle was wrapped nor undoes it.
#[test]
fn a_wrapped_angle_with_a_wild_sample_is_unwrapped() {
    use std::f64::consts::{PI, TAU};
    let angle = |k: usize| 0.05 * k as f64 + (0.03 * k as f64).sin();
    for by in [0.0, 100.0, TAU] {
        let mut text = String::from("t,q_x\n");
        for k in 0..400 {
            let mut cell = (angle(k) + PI).rem_euclid(TAU) - PI;
            if k == 200 {
                cell += by;
            }
            text += &format!("{},{cell}\n", STEP * k as f64);
        }
        let log = Log::from_bytes("wheel.csv", text.as_bytes()).unwrap();
        let record = log.select(&["x".to_string()], &[]).unwrap();
        for (k, q) in record.q[0].iter().enumerate() {
            assert!((q - angle(k)).abs() < 1e-3, "{by} at {k}: {q}");
        }
        assert_eq!(wild(&record).len(), usize::from(by == 100.0));
    }
}
