use core::convert::Infallible;
use core::ops::ControlFlow;
use std::string::ToString;
use std::vec::Vec;

use super::*;
use crate::Dual;

type Result2 = Result<[f64; 2], Infallible>;

/// Harmonic oscillator; solution (cos t, −sin t) from (1, 0).
fn oscillator(_: f64, y: &[f64; 2]) -> Result2 {
    Ok([y[1], -y[0]])
}

/// dy/dt = −2 t y², y(0) = 1: y = 1/(1 + t²). Nonlinear and time-dependent.
fn rational(t: f64, y: &[f64; 1]) -> Result<[f64; 1], Infallible> {
    Ok([-2.0 * t * y[0] * y[0]])
}

/// Observed order from the errors at `n` and `2n` steps.
fn order(error: impl Fn(usize) -> f64, n: usize) -> f64 {
    (error(n) / error(2 * n)).log2()
}

fn steps<Y: Copy>(n: usize, end: f64, start: Y, mut step: impl FnMut(f64, &Y, f64) -> Y) -> Y {
    let h = end / n as f64;
    (0..n).fold(start, |y, k| step(k as f64 * h, &y, h))
}

#[test]
fn rk4_is_of_order_4() {
    let error = |n| {
        let y = steps(n, 2.0, [1.0], |t, y, h| {
            rk4_step(rational, t, y, h).unwrap()
        });
        (y[0] - 0.2_f64).abs()
    };
    let order = order(error, 80);
    std::println!("rk4: order {order:.3}, error at 160 steps {:e}", error(160));
    assert!((order - 4.0).abs() < 0.15, "{order}");
}

#[test]
fn symplectic_euler_is_of_order_1_and_keeps_energy_bounded() {
    let rate = |_t: f64, y: &State<f64, 1, 1>| {
        Ok::<_, Infallible>(State {
            q: y.v,
            v: [-y.q[0]],
            z: [-y.z[0]],
        })
    };
    let start = State {
        q: [1.0],
        v: [0.0],
        z: [1.0],
    };
    let run = |n, end| {
        steps(n, end, start, |t, y, h| {
            symplectic_euler_step(rate, t, y, h).unwrap()
        })
    };
    let error = |n| (run(n, 2.0).q[0] - 2.0_f64.cos()).abs();
    let order = order(error, 2000);
    std::println!("symplectic Euler: order {order:.3}");
    assert!((order - 1.0).abs() < 0.05, "{order}");
    assert!((run(4000, 2.0).z[0] - (-2.0_f64).exp()).abs() < 1e-3);
    // The energy error stays below h/2 · E for 10^4 periods; explicit Euler's explodes.
    let end = run(1_000_000, 1e4);
    let energy = 0.5 * (end.q[0].powi(2) + end.v[0].powi(2));
    assert!((energy - 0.5).abs() < 0.01, "{energy}");
}

/// One step of length `h` exactly, whatever its error.
fn one_step(h: f64) -> (Segment<f64, [f64; 1]>, f64) {
    let solver = DormandPrince {
        relative: 1e6,
        absolute: 1e6,
        first_step: Some(h),
        ..Default::default()
    };
    let exact = |t: f64| 1.0 / (1.0 + t * t);
    let mut segment = None;
    solver
        .integrate(rational, 0.3, &[exact(0.3)], 0.3 + h, |s| {
            segment = Some(*s);
            ControlFlow::Continue(())
        })
        .unwrap();
    let segment = segment.unwrap();
    assert!((segment.end_time() - segment.start_time() - h).abs() < 1e-15);
    (segment, (segment.end()[0] - exact(0.3 + h)).abs())
}

#[test]
fn dormand_prince_step_and_dense_output_have_their_orders() {
    // Local errors: h^6 of the step, h^5 of the dense output.
    let local = (one_step(0.1).1 / one_step(0.05).1).log2();
    let dense = |h: f64| {
        let segment = one_step(h).0;
        (1..20)
            .map(|k| 0.3 + h * f64::from(k) / 20.0)
            .map(|t| (segment.at(t)[0] - 1.0 / (1.0 + t * t)).abs())
            .fold(0.0, f64::max)
    };
    let dense_local = (dense(0.1) / dense(0.05)).log2();
    std::println!("Dormand–Prince: local order {local:.3}, dense output {dense_local:.3}");
    assert!((local - 6.0).abs() < 0.3, "{local}");
    assert!((dense_local - 5.0).abs() < 0.3, "{dense_local}");
    // Dense output meets both ends.
    let (segment, _) = one_step(0.1);
    assert_eq!(segment.at(segment.start_time()), *segment.start());
    assert!((segment.at(segment.end_time())[0] - segment.end()[0]).abs() < 1e-15);
}

#[test]
fn dormand_prince_follows_its_tolerance() {
    for digits in [4, 6, 8, 10, 12] {
        let tolerance = 10.0_f64.powi(-digits);
        let solver = DormandPrince {
            relative: tolerance,
            absolute: tolerance,
            ..Default::default()
        };
        let (_, y, cost) = solver
            .integrate(oscillator, 0.0, &[1.0, 0.0], 10.0, |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
        let error = (y[0] - 10.0_f64.cos()).hypot(y[1] + 10.0_f64.sin());
        std::println!("tolerance 1e-{digits}: error {error:.1e}, {cost:?}");
        assert!(error < 30.0 * tolerance, "{error}");
        assert!(
            error > 0.01 * tolerance,
            "far more work than asked: {error}"
        );
        assert_eq!(cost.evaluations, 2 + 6 * (cost.accepted + cost.rejected));
    }
}

/// State at t = 20 of van der Pol's oscillator, μ = 5, by SciPy 1.17.1, DOP853 and Radau
/// alike to 12 digits: `tests/reference/van_der_pol.py`.
const VAN_DER_POL: [f64; 2] = [-1.601_296_879_543, 0.198_326_676_338];

#[test]
fn van_der_pol_agrees_with_scipy() {
    let rate =
        |_: f64, y: &[f64; 2]| -> Result2 { Ok([y[1], 5.0 * (1.0 - y[0] * y[0]) * y[1] - y[0]]) };
    let solver = DormandPrince {
        relative: 1e-11,
        absolute: 1e-11,
        ..Default::default()
    };
    let (_, y, cost) = solver
        .integrate(rate, 0.0, &[2.0, 0.0], 20.0, |_| ControlFlow::Continue(()))
        .unwrap();
    std::println!("van der Pol: {y:?} {cost:?}");
    assert!((y[0] - VAN_DER_POL[0]).abs() < 1e-8 && (y[1] - VAN_DER_POL[1]).abs() < 1e-8);
}

#[test]
fn backwards_and_stopped_and_empty() {
    let solver = DormandPrince {
        relative: 1e-10,
        absolute: 1e-10,
        ..Default::default()
    };
    let go = |_: &Segment<f64, [f64; 2]>| ControlFlow::Continue(());
    let (_, there, _) = solver
        .integrate(oscillator, 0.0, &[1.0, 0.0], 5.0, go)
        .unwrap();
    let (t, back, _) = solver.integrate(oscillator, 5.0, &there, 0.0, go).unwrap();
    assert!(t == 0.0 && (back[0] - 1.0).abs() < 1e-8 && back[1].abs() < 1e-8);

    let mut count = 0;
    let (t, _, cost) = solver
        .integrate(oscillator, 0.0, &[1.0, 0.0], 5.0, |_| {
            count += 1;
            if count == 3 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })
        .unwrap();
    assert!(cost.accepted == 3 && t < 5.0);

    let (t, y, cost) = solver
        .integrate(oscillator, 1.0, &[1.0, 0.0], 1.0, go)
        .unwrap();
    assert_eq!((t, y, cost.accepted), (1.0, [1.0, 0.0], 0));
    let nothing = |_: f64, y: &[f64; 0]| Ok::<_, Infallible>(*y);
    let all = |_: &Segment<f64, [f64; 0]>| ControlFlow::Continue(());
    assert_eq!(
        solver.integrate(nothing, 0.0, &[], 1.0, all).unwrap().0,
        1.0
    );
}

#[test]
fn samples_are_equidistant_and_complete() {
    let solver = DormandPrince {
        relative: 1e-10,
        absolute: 1e-10,
        ..Default::default()
    };
    for (end, interval, expected) in [
        (1.0, 0.1, 11),
        (0.95, 0.1, 10),
        (-1.0, 0.25, 5),
        (0.3, 0.1, 4),
        (1.0, 2.0, 1),
        (0.0, 0.1, 1),
    ] {
        let mut times = Vec::new();
        solver
            .sample(oscillator, 0.0, &[1.0, 0.0], end, interval, |t, y| {
                assert!((y[0] - t.cos()).abs() < 1e-8);
                times.push(t);
            })
            .unwrap();
        assert_eq!(times.len(), expected, "{end} {interval}: {times:?}");
        for (k, t) in times.iter().enumerate() {
            assert!((t - k as f64 * interval * f64::signum(end)).abs() < 1e-15);
        }
    }
}

#[test]
fn single_precision_and_dual_numbers() {
    let rate = |_: f32, y: &[f32; 2]| Ok::<_, Infallible>([y[1], -y[0]]);
    let (_, y, _) = DormandPrince::<f32>::default()
        .integrate(rate, 0.0, &[1.0, 0.0], 3.0, |_| ControlFlow::Continue(()))
        .unwrap();
    assert!((y[0] - 3.0_f32.cos()).abs() < 5e-3);

    // ∂y(t)/∂y0 of the decay is exp(−t).
    let decay = |_: Dual<f64, 1>, y: &[Dual<f64, 1>; 1]| Ok::<_, Infallible>([-y[0]]);
    let h = Dual::constant(0.01);
    let y = (0..100).fold([Dual::variable(2.0, 0)], |y, _| {
        rk4_step(decay, Dual::constant(0.0), &y, h).unwrap()
    });
    assert!((y[0].eps[0] - (-1.0_f64).exp()).abs() < 1e-10);
}

#[test]
fn a_jump_is_passed() {
    // dy/dt jumps at t = 1; y(2) = 1 + 3.
    let rate = |t: f64, _: &[f64; 1]| Ok::<_, Infallible>([if t < 1.0 { 1.0 } else { 3.0 }]);
    let solver = DormandPrince {
        relative: 1e-9,
        absolute: 1e-9,
        ..Default::default()
    };
    let (_, y, cost) = solver
        .integrate(rate, 0.0, &[0.0], 2.0, |_| ControlFlow::Continue(()))
        .unwrap();
    assert!(
        (y[0] - 4.0).abs() < 1e-6 && cost.rejected > 0,
        "{y:?} {cost:?}"
    );
}

#[test]
fn every_error_says_what_and_how_to_mend() {
    let go = |_: &Segment<f64, [f64; 1]>| ControlFlow::Continue(());
    let default = DormandPrince::<f64>::default();
    let run = |solver: DormandPrince<f64>, f: fn(f64, &[f64; 1]) -> f64, t0: f64, t1: f64| {
        let f = |t: f64, y: &[f64; 1]| {
            let rate = f(t, y);
            if rate == -77.0 {
                Err("the model broke")
            } else {
                Ok([rate])
            }
        };
        solver
            .integrate(f, t0, &[1.0], t1, go)
            .unwrap_err()
            .to_string()
    };
    let one: fn(f64, &[f64; 1]) -> f64 = |_, _| 1.0;
    let message = run(default, |t, _| if t > 0.5 { -77.0 } else { 0.0 }, 0.0, 1.0);
    assert!(
        message.starts_with("at t = ") && message.ends_with("the model broke"),
        "{message}"
    );
    let message = run(default, |_, y| y[0] * y[0], 0.0, 2.0); // y = 1/(1 − t)
    assert!(
        message.contains("0.99") || message.contains("t = 1"),
        "{message}"
    );
    let message = run(default, |t, _| (0.5 - t).sqrt(), 0.0, 1.0);
    assert!(
        message.contains("NaN or infinite just after t = 0."),
        "{message}"
    );
    let message = run(default, |_, _| f64::NAN, 3.0, 4.0);
    assert!(message.contains("t = 3 s"), "{message}");
    let message = run(
        DormandPrince {
            max_steps: 5,
            ..default
        },
        |t, _| (50.0 * t).cos(),
        0.0,
        9.0,
    );
    assert!(message.contains("5 steps reached only"), "{message}");
    // Slides along y = 1; no step is short enough for the tolerance.
    let chatter = |_: f64, y: &[f64; 1]| if y[0] > 1.0 { -1.0 } else { 1.0 };
    let tight = DormandPrince {
        relative: 0.0,
        absolute: 1e-30,
        ..default
    };
    let message = run(tight, chatter, 1e6, 1e6 + 1.0);
    assert!(
        message.contains("below the resolution of time"),
        "{message}"
    );
    let cases = [
        (
            DormandPrince {
                relative: -1.0,
                ..default
            },
            0.0,
            1.0,
            "relative tolerance is -1",
        ),
        (
            DormandPrince {
                absolute: f64::NAN,
                ..default
            },
            0.0,
            1.0,
            "absolute tolerance is NaN",
        ),
        (
            DormandPrince {
                absolute: 0.0,
                relative: 0.0,
                ..default
            },
            0.0,
            1.0,
            "above 0",
        ),
        (
            DormandPrince {
                first_step: Some(0.0),
                ..default
            },
            0.0,
            1.0,
            "first step is 0",
        ),
        (
            DormandPrince {
                max_step: Some(-1.0),
                ..default
            },
            0.0,
            1.0,
            "longest step is -1",
        ),
        (default, f64::NAN, 1.0, "start time is NaN"),
        (default, 0.0, f64::INFINITY, "end time is inf"),
    ];
    for (solver, t0, t1, words) in cases {
        let message = run(solver, one, t0, t1);
        assert!(message.contains(words), "{message}");
    }
    let f = |_: f64, y: &[f64; 1]| Ok::<_, Infallible>(*y);
    let error = default
        .sample(f, 0.0, &[1.0], 1.0, 0.0, |_, _| ())
        .unwrap_err();
    assert!(error.to_string().contains("interval is 0"));
}
