//! Constrained systems over time: energy, drift, agreement with other descriptions.

mod common;

use std::convert::Infallible;
use std::ops::ControlFlow;

use common::{CartesianPendulum, GRAVITY, Unicycle};
use dynamics::constrained::{Baumgarte, SolveError};
use dynamics::integrate::{DormandPrince, IntegrationError, State};
use dynamics::{Dual, Point, Simulation, acceleration_full_rank};

const TIGHT: DormandPrince<f64> = DormandPrince {
    relative: 1e-12,
    absolute: 1e-12,
    first_step: None,
    max_step: None,
    max_steps: 1_000_000,
};

/// Rod horizontal, at rest.
const START: State<f64, 2, 0> = State {
    q: [1.0, 0.0],
    v: [0.0, 0.0],
    z: [],
};

/// Energy per mass of [`CartesianPendulum`], J/kg.
fn energy(q: [f64; 2], v: [f64; 2]) -> f64 {
    0.5 * (v[0] * v[0] + v[1] * v[1]) + GRAVITY * q[1]
}

/// Largest energy error and largest |c| over 10 s.
fn worst<const R: usize>(baumgarte: Option<Baumgarte<f64>>) -> (f64, f64) {
    let mut simulation = Simulation::new(&CartesianPendulum::<R>);
    simulation.baumgarte = baumgarte;
    let (mut energy_error, mut violation) = (0.0_f64, 0.0_f64);
    let before = energy(START.q, START.v);
    simulation
        .integrate(
            &TIGHT,
            (0.0, &START),
            10.0,
            |_, _| [],
            |segment| {
                let State { q, v, .. } = segment.end();
                energy_error = energy_error.max((energy(*q, *v) - before).abs());
                violation = violation.max(0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0).abs());
                ControlFlow::Continue(())
            },
        )
        .unwrap();
    (energy_error, violation)
}

#[test]
fn cartesian_pendulum_keeps_energy_and_rod() {
    let (energy_error, drift) = worst::<1>(None);
    println!("without stabilisation: energy {energy_error:.1e} J, |c| {drift:.1e} m²");
    assert!(energy_error < 1e-8);
    let (energy_error, violation) = worst::<1>(Some(Baumgarte::critical(20.0)));
    println!("Baumgarte 20/s: energy {energy_error:.1e} J, |c| {violation:.1e} m²");
    assert!(energy_error < 1e-8 && violation < 1e-10);
}

#[test]
fn doubled_rod_moves_alike() {
    let (energy_error, violation) = worst::<2>(Some(Baumgarte::critical(20.0)));
    assert!(
        energy_error < 1e-8 && violation < 1e-10,
        "{energy_error} {violation}"
    );
}

#[test]
fn cartesian_pendulum_agrees_with_the_angle() {
    let simulation =
        Simulation::new(&CartesianPendulum::<1>).with_baumgarte(Baumgarte::critical(20.0));
    let (end, _) = simulation
        .sample(&TIGHT, (0.0, &START), (5.0, 0.5), |_, _| [], |_, _| ())
        .unwrap();
    // φ'' = −g sin φ from the hanging position, φ(0) = π/2.
    let swing = |_: f64, y: &[f64; 2]| Ok::<_, Infallible>([y[1], -GRAVITY * y[0].sin()]);
    let (_, angle, _) = TIGHT
        .integrate(swing, 0.0, &[std::f64::consts::FRAC_PI_2, 0.0], 5.0, |_| {
            ControlFlow::Continue(())
        })
        .unwrap();
    assert!((end.q[0] - angle[0].sin()).abs() < 1e-9);
    assert!((end.q[1] + angle[0].cos()).abs() < 1e-9);
    // Tension: m (v² + g cos φ), along the rod.
    let x = simulation.acceleration(5.0, &end, []).unwrap();
    let tension = angle[1] * angle[1] + GRAVITY * angle[0].cos();
    assert!(
        (x.lambda[0] + tension).abs() < 1e-7,
        "{} {tension}",
        x.lambda[0]
    );
}

#[test]
fn baumgarte_removes_an_initial_violation_at_its_rate() {
    let omega = 20.0;
    let simulation =
        Simulation::new(&CartesianPendulum::<1>).with_baumgarte(Baumgarte::critical(omega));
    let start = State {
        q: [1.001, 0.0],
        ..START
    };
    let c0: f64 = 0.5 * (1.001 * 1.001 - 1.0);
    simulation
        .sample(
            &TIGHT,
            (0.0, &start),
            (2.0, 0.05),
            |_, _| [],
            |t, y| {
                let c = 0.5 * (y.q[0] * y.q[0] + y.q[1] * y.q[1] - 1.0);
                // c̈ + 2ω ċ + ω² c = 0 from rest: c = c0 (1 + ωt) exp(−ωt).
                let exact = c0 * (1.0 + omega * t) * (-omega * t).exp();
                assert!((c - exact).abs() < 1e-10, "{t}: {c} {exact}");
            },
        )
        .unwrap();
}

#[test]
fn unicycle_does_not_slip_and_lags() {
    let simulation = Simulation::new(&Unicycle).with_baumgarte(Baumgarte::critical(10.0));
    let start = State {
        q: [0.0; 3],
        v: [0.0; 3],
        z: [0.0],
    };
    let input = |t: f64, _: &State<f64, 3, 1>| [1.0, 0.05 * t.cos()];
    let (end, _) = simulation
        .sample(&TIGHT, (0.0, &start), (5.0, 0.1), input, |t, y| {
            let (s, c) = y.q[2].sin_cos();
            assert!((y.v[1] * c - y.v[0] * s).abs() < 1e-10);
            // z = 1 − exp(−10 t); speed is its integral.
            let speed = t - (1.0 - (-10.0 * t).exp()) / 10.0;
            assert!((y.z[0] - (1.0 - (-10.0 * t).exp())).abs() < 1e-10);
            assert!((y.v[0].hypot(y.v[1]) - speed).abs() < 1e-9);
            // 0.2 ψ'' = 0.05 cos t.
            assert!((y.q[2] - 0.25 * (1.0 - t.cos())).abs() < 1e-9);
        })
        .unwrap();
    // Fixed steps arrive at the same place.
    let mut y = start;
    for k in 0..5000 {
        y = simulation
            .rk4_step(f64::from(k) * 1e-3, &y, 1e-3, input)
            .unwrap();
    }
    assert!((y.q[0] - end.q[0]).abs() < 1e-8 && (y.q[1] - end.q[1]).abs() < 1e-8);
    let mut y = start;
    for k in 0..5000 {
        y = simulation
            .symplectic_euler_step(f64::from(k) * 1e-3, &y, 1e-3, input)
            .unwrap();
    }
    assert!((y.q[0] - end.q[0]).abs() < 2e-2 && (y.q[1] - end.q[1]).abs() < 2e-2);
}

#[test]
fn dual_numbers_through_a_system_agree_with_differences() {
    let at = |q: [f64; 2], v: [f64; 2]| Point {
        t: 0.0,
        q,
        v,
        u: [],
        z: [],
    };
    let model = CartesianPendulum::<1>;
    let (q, v) = ([0.6, -0.8], [0.4, 0.3]);
    let seeded = Dual::variables([q[0], q[1], v[0], v[1]]);
    let point = Point {
        t: Dual::constant(0.0),
        q: [seeded[0], seeded[1]],
        v: [seeded[2], seeded[3]],
        u: [],
        z: [],
    };
    let x = acceleration_full_rank::<Dual<f64, 4>, _, 2, 0, 1, 0, 2>(&model, &point, None);
    for d in 0..4 {
        let moved = |h: f64| {
            let mut s = [q[0], q[1], v[0], v[1]];
            s[d] += h;
            acceleration_full_rank::<f64, _, 2, 0, 1, 0, 2>(
                &model,
                &at([s[0], s[1]], [s[2], s[3]]),
                None,
            )
        };
        let h = 1e-6;
        for i in 0..2 {
            let difference = (moved(h).a[i] - moved(-h).a[i]) / (2.0 * h);
            assert!((x.a[i].eps[d] - difference).abs() < 1e-7);
        }
        let difference = (moved(h).lambda[0] - moved(-h).lambda[0]) / (2.0 * h);
        assert!((x.lambda[0].eps[d] - difference).abs() < 1e-7);
    }
}

#[test]
fn an_error_of_the_model_carries_its_time() {
    let simulation = Simulation::new(&Unicycle);
    let start = State {
        q: [0.0; 3],
        v: [0.0; 3],
        z: [0.0],
    };
    let input = |t: f64, _: &State<f64, 3, 1>| [if t > 1.0 { f64::NAN } else { 1.0 }, 0.0];
    let failed = simulation.sample(&TIGHT, (0.0, &start), (2.0, 0.1), input, |_, _| ());
    // The lag state turns NaN, and the force with it.
    match failed.unwrap_err() {
        IntegrationError::Rate {
            t,
            source: SolveError::NotFinite { .. },
        } => {
            assert!((1.0..1.2).contains(&t), "{t}");
        }
        other => panic!("{other}"),
    }
}

#[cfg(feature = "simd")]
#[test]
fn simd_lanes_are_separate_states() {
    use wide::f64x4;
    let model = CartesianPendulum::<1>;
    let lane = |i: usize| ([0.6 + 0.1 * i as f64, -0.8], [0.4, 0.3 - 0.2 * i as f64]);
    let pack = |f: &dyn Fn(usize) -> f64| f64x4::from(std::array::from_fn::<f64, 4, _>(f));
    let point = Point {
        t: f64x4::splat(0.0),
        q: [pack(&|i| lane(i).0[0]), pack(&|i| lane(i).0[1])],
        v: [pack(&|i| lane(i).1[0]), pack(&|i| lane(i).1[1])],
        u: [],
        z: [],
    };
    let x = acceleration_full_rank::<f64x4, _, 2, 0, 1, 0, 2>(&model, &point, None);
    for i in 0..4 {
        let (q, v) = lane(i);
        let single = Point {
            t: 0.0,
            q,
            v,
            u: [],
            z: [],
        };
        let y = acceleration_full_rank::<f64, _, 2, 0, 1, 0, 2>(&model, &single, None);
        assert!((x.a[0].to_array()[i] - y.a[0]).abs() < 1e-14);
        assert!((x.lambda[0].to_array()[i] - y.lambda[0]).abs() < 1e-14);
    }
}
