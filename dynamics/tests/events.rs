//! Events against closed forms: their times, directions, and what happens at them.

mod common;

use std::convert::Infallible;
use std::f64::consts::PI;
use std::ops::ControlFlow;

use common::{CartesianPendulum, GRAVITY, Lift};
use dynamics::Simulation;
use dynamics::constrained::Baumgarte;
use dynamics::integrate::{Direction, DormandPrince, Events, State};

const TIGHT: DormandPrince<f64> = DormandPrince {
    relative: 1e-13,
    absolute: 1e-13,
    first_step: None,
    max_step: None,
    max_steps: 1_000_000,
};

const KEPT: f64 = 0.8;
const HEIGHT: f64 = 1.0;

/// `t₀ (1 + 2e + 2e² + …)`, with the fall from rest `t₀`.
fn bounce(k: usize) -> f64 {
    let fall = (2.0 * HEIGHT / GRAVITY).sqrt();
    let hops: f64 = (1..=k).map(|i| KEPT.powi(i as i32)).sum();
    fall * (1.0 + 2.0 * hops)
}

/// Whatever steps the integrator takes.
#[test]
fn a_ball_bounces_when_the_closed_form_says() {
    for solver in [DormandPrince::default(), TIGHT] {
        let mut times = Vec::new();
        let events = Events {
            directions: [Direction::Falling],
            functions: |_: f64, y: &State<f64, 1, 0>| [y.q[0]],
            action: |event: usize, t: f64, y: &mut State<f64, 1, 0>| {
                assert_eq!(event, 0);
                times.push(t);
                y.v[0] *= -KEPT;
                match times.len() {
                    30 => ControlFlow::Break(()),
                    _ => ControlFlow::Continue(()),
                }
            },
        };
        let start = State {
            q: [HEIGHT],
            v: [0.0],
            z: [],
        };
        let mut last = 0.0;
        let (end, _, cost) = Simulation::new(&Lift::<0>)
            .integrate_with_events(
                &solver,
                (0.0, &start),
                100.0,
                |_, _| [],
                events,
                |step| {
                    assert_eq!(step.start_time(), last, "steps leave no gap");
                    last = step.end_time();
                    ControlFlow::Continue(())
                },
            )
            .unwrap();
        assert_eq!(times.len(), 30);
        assert_eq!(end, times[29]);
        assert!(cost.evaluations > 0);
        for (k, t) in times.iter().enumerate() {
            assert!((t - bounce(k)).abs() < 1e-12, "bounce {k}: {t}");
        }
    }
}

/// Hops of nanoseconds behind hops of a second.
#[test]
fn bounces_that_pile_up_are_all_seen() {
    for direction in [Direction::Falling, Direction::Either] {
        let fall = |_: f64, y: &[f64; 2]| Ok::<_, Infallible>([y[1], -GRAVITY]);
        let mut times = Vec::new();
        let events = Events {
            directions: [direction],
            functions: |_: f64, y: &[f64; 2]| [y[0]],
            action: |_: usize, t: f64, y: &mut [f64; 2]| {
                times.push(t);
                y[1] *= -0.5;
                match y[1] > 1e-8 {
                    true => ControlFlow::Continue(()),
                    false => ControlFlow::Break(()),
                }
            },
        };
        TIGHT
            .integrate_with_events(fall, (0.0, &[1.0, 0.0]), 100.0, events, |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
        let fall = (2.0 / GRAVITY).sqrt();
        assert_eq!(times.len(), 29);
        for (k, t) in times.iter().enumerate() {
            let expected = fall * (3.0 - 2.0 * 0.5_f64.powi(k as i32));
            assert!((t - expected).abs() < 1e-12, "bounce {k}: {t}");
        }
    }
}

/// Two functions of which one is twice the other are due at one time, in their order.
#[test]
fn events_at_one_time_all_happen() {
    let line = |_: f64, _: &[f64; 1]| Ok::<_, Infallible>([1.0]);
    let mut seen = Vec::new();
    let events = Events {
        directions: [Direction::Either; 3],
        functions: |_: f64, y: &[f64; 1]| [2.0 * y[0], y[0], y[0] - 1e-9],
        action: |event: usize, t: f64, _: &mut [f64; 1]| {
            seen.push((event, t));
            ControlFlow::Continue(())
        },
    };
    TIGHT
        .integrate_with_events(line, (0.0, &[-1.0 / 3.0]), 1.0, events, |_| {
            ControlFlow::Continue(())
        })
        .unwrap();
    let (order, times): (Vec<usize>, Vec<f64>) = seen.into_iter().unzip();
    assert_eq!(order, [0, 1, 2]);
    assert_eq!(times[0], times[1]);
    assert!((times[2] - times[0] - 1e-9).abs() < 1e-15);
}

/// Every quarter of a large swing, whose period is `2π √(l/g) / agm(1, cos(θ₀/2))`: on the
/// constrained pendulum, with rising and falling crossings told apart.
#[test]
fn a_pendulum_passes_the_bottom_when_the_period_says() {
    let simulation =
        Simulation::new(&CartesianPendulum::<1>).with_baumgarte(Baumgarte::critical(10.0));
    // From the horizontal.
    let (mut a, mut g) = (1.0_f64, (PI / 4.0).cos());
    for _ in 0..10 {
        (a, g) = ((a + g) / 2.0, (a * g).sqrt());
    }
    let period = 2.0 * PI / GRAVITY.sqrt() / a;
    let start = State {
        q: [1.0, 0.0],
        v: [0.0, 0.0],
        z: [],
    };
    let mut seen = Vec::new();
    let events = Events {
        directions: [Direction::Either, Direction::Rising, Direction::Falling],
        functions: |_: f64, y: &State<f64, 2, 0>| [y.q[0]; 3],
        action: |event: usize, t: f64, _: &mut State<f64, 2, 0>| {
            seen.push((event, t));
            ControlFlow::Continue(())
        },
    };
    simulation
        .integrate_with_events(
            &TIGHT,
            (0.0, &start),
            2.0 * period,
            |_, _| [],
            events,
            |_| ControlFlow::Continue(()),
        )
        .unwrap();
    let quarters = [1.0, 3.0, 5.0, 7.0];
    let expected: Vec<(usize, f64)> = quarters
        .iter()
        .enumerate()
        .flat_map(|(k, quarter)| {
            let t = quarter / 4.0 * period;
            [(0, t), (if k % 2 == 0 { 2 } else { 1 }, t)]
        })
        .collect();
    assert_eq!(seen.len(), expected.len(), "{seen:?}");
    for (found, expected) in seen.iter().zip(&expected) {
        assert_eq!(found.0, expected.0, "{seen:?}");
        assert!(
            (found.1 - expected.1).abs() < 1e-10,
            "{found:?} {expected:?}"
        );
    }
}

/// Of a motion that no step of the method follows exactly, an event's state fulfils its
/// equation, and it is that of a step: tightening the tolerance closes in on the closed form.
#[test]
fn an_event_lies_on_a_step_of_the_integrator() {
    let growth = |_: f64, y: &[f64; 1]| Ok::<_, Infallible>([y[0]]);
    let found = |solver: DormandPrince<f64>| {
        let events = Events {
            directions: [Direction::Rising],
            functions: |_: f64, y: &[f64; 1]| [y[0] - 7.0],
            action: |_: usize, _: f64, _: &mut [f64; 1]| ControlFlow::Break(()),
        };
        let (t, y, _) = solver
            .integrate_with_events(growth, (0.0, &[1.0]), 5.0, events, |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
        assert!((y[0] - 7.0).abs() < 1e-13, "{}", y[0]);
        (t - 7.0_f64.ln()).abs()
    };
    assert!(found(TIGHT) < 1e-12);
    assert!(found(DormandPrince::default()) < 1e-7);
}

/// Backwards in time, from behind; and with nothing to find.
#[test]
fn direction_is_that_of_the_integration() {
    let line = |_: f64, _: &[f64; 1]| Ok::<_, Infallible>([1.0]);
    let count = |direction, t1: f64| {
        let mut times = Vec::new();
        let events = Events {
            directions: [direction],
            functions: |_: f64, y: &[f64; 1]| [y[0]],
            action: |_: usize, t: f64, _: &mut [f64; 1]| {
                times.push(t);
                ControlFlow::Continue(())
            },
        };
        let from = if t1 > 0.0 { -0.3 } else { 0.3 };
        TIGHT
            .integrate_with_events(line, (0.0, &[from]), t1, events, |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
        times
    };
    assert_eq!(count(Direction::Falling, 1.0).len(), 0);
    assert_eq!(count(Direction::Rising, -1.0).len(), 0);
    for (direction, t1) in [(Direction::Rising, 1.0), (Direction::Falling, -1.0)] {
        let times = count(direction, t1);
        assert!((times[0].abs() - 0.3).abs() < 1e-15 && times.len() == 1);
    }
}
