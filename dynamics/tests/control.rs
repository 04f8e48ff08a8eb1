//! Sampled feedback against the transition of a body that inputs push: with constant force `u`
//! and weight over an interval `h`, `q₊ = q + h v + h²/2 (u − g)`, `v₊ = v + h (u − g)`.

mod common;

use std::ops::ControlFlow;

use common::{GRAVITY, Lift};
use dynamics::integrate::{DormandPrince, IntegrationError, State};
use dynamics::{Control, Simulation};

const H: f64 = 0.05;
const START: State<f64, 1, 0> = State {
    q: [1.0],
    v: [0.0],
    z: [],
};

fn law(_: f64, y: &State<f64, 1, 0>) -> [f64; 1] {
    [-8.0 * y.q[0] - 4.0 * y.v[0]]
}

/// `(q, v)` at every tick.
fn by_hand(ticks: usize, delay: usize, limit: f64) -> Vec<[f64; 2]> {
    let mut late = vec![0.25; delay];
    let (mut q, mut v) = (1.0_f64, 0.0_f64);
    let mut passed = vec![[q, v]];
    for _ in 0..ticks {
        late.push((-8.0 * q - 4.0 * v).clamp(-limit, limit));
        let u = late.remove(0) - GRAVITY;
        (q, v) = (q + H * v + H * H / 2.0 * u, v + H * u);
        passed.push([q, v]);
    }
    passed
}

fn check<const D: usize>(limit: f64) {
    let mut control = Control::new(H, law)
        .with_limits([-limit], [limit])
        .with_delay([[0.25]; D]);
    let expected = by_hand(100, D, limit);
    let mut worst = 0.0_f64;
    let (end, y, _) = Simulation::new(&Lift::<1>)
        .integrate_controlled(
            &DormandPrince::default(),
            (0.0, &START),
            100.0 * H,
            &mut control,
            |step, command| {
                let tick = step.end_time() / H;
                if (tick - tick.round()).abs() < 1e-9 {
                    let [q, v] = expected[tick.round() as usize];
                    let off = (step.end().q[0] - q).abs().max((step.end().v[0] - v).abs());
                    worst = worst.max(off);
                }
                assert!(command[0].abs() <= limit);
                ControlFlow::Continue(())
            },
        )
        .unwrap();
    assert_eq!(end, 100.0 * H);
    assert!((y.q[0] - expected[100][0]).abs() < 1e-12);
    assert!(worst < 1e-12, "{worst:.1e}");
}

#[test]
fn commands_are_held_late_and_limited() {
    check::<0>(1e9);
    check::<0>(11.0);
    check::<1>(11.0);
    check::<3>(1e9);
}

#[test]
fn odd_ends_and_intervals() {
    let simulation = Simulation::new(&Lift::<1>);
    let run = |interval: f64, t1: f64| {
        let mut samples = 0;
        let mut control = Control::new(interval, |_: f64, _: &State<f64, 1, 0>| {
            samples += 1;
            [0.0]
        });
        let solver = DormandPrince::default();
        let end =
            simulation.integrate_controlled(&solver, (0.0, &START), t1, &mut control, |_, _| {
                ControlFlow::Continue(())
            });
        end.map(|(t, _, _)| (t, samples))
    };
    // Three intervals, whatever rounding makes of 0.3; and a part of a fourth.
    assert_eq!(run(0.1, 0.3).unwrap(), (0.3, 3));
    assert_eq!(run(0.1, 0.35).unwrap(), (0.35, 4));
    for (interval, t1, name) in [(0.0, 1.0, "interval"), (0.1, -1.0, "end time")] {
        let error = run(interval, t1).unwrap_err();
        let IntegrationError::Argument { name: found, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(found, name);
    }
}

#[test]
fn the_sink_may_stop() {
    let mut steps = 0;
    let mut control = Control::new(H, law);
    let (end, _, _) = Simulation::new(&Lift::<1>)
        .integrate_controlled(
            &DormandPrince::default(),
            (0.0, &START),
            1.0,
            &mut control,
            |step, _| {
                steps += 1;
                match step.end_time() >= 3.0 * H {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                }
            },
        )
        .unwrap();
    assert!((end - 3.0 * H).abs() < 1e-12 && steps >= 3);
}
