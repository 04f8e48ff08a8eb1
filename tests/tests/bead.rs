//! A model with everything that remembers or rubs: generated code moves as the machine of
//! `identify` does.

use dynamics::constrained::{Baumgarte, Tolerance};
use dynamics::integrate::State;
use dynamics::{Point, Simulation, System as _, acceleration, acceleration_full_rank};
use generated::bead::{self, Bead};
use identify::machine::{Hold, Machine, Memory, Rollout, RolloutOptions, Simulated, States};
use integration_tests::models;

/// On the wire, with a velocity along it.
fn places() -> Vec<([f64; 2], [f64; 2], f64, f64)> {
    let at = |x: f64, v: f64, u: f64, z: f64| ([x, 0.8 * x * x], [v, 1.6 * x * v], u, z);
    vec![
        at(0.3, 0.7, 1.0, -0.5),
        at(-0.9, 0.02, -2.0, 1.5),
        at(0.0, -1.4, 0.3, 0.1),
        at(1.2, 0.0, 0.0, 4.0),
    ]
}

#[test]
fn accelerations_and_multipliers_agree() {
    let machine = Machine::new(models::one("bead.model"));
    let values = machine.nominal_parameters();
    let bead = Bead::<f64>::nominal();
    assert_eq!(bead.multipliers_at(), Some(2));
    assert_eq!(bead::DELAYED_INPUTS, [(1, 0)]);
    for (q, v, u, z) in places() {
        let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
        let states = States {
            t: vec![0.0],
            q: column(&q),
            v: column(&v),
            u: vec![vec![u]],
            history: None,
            memory: Memory {
                delayed: vec![vec![0.4]],
                delay_rate: vec![vec![0.0]],
                z: vec![vec![z]],
                slopes: Vec::new(),
            },
        };
        let motion = machine.motion(&states, &values).unwrap().remove(0);
        let x = Point {
            t: 0.0,
            q,
            v,
            u: [u, 0.4, 0.0],
            z: [z],
        };
        let checked = acceleration(&bead, &x, None, &Tolerance::default()).unwrap();
        let blind = acceleration_full_rank(&bead, &x, None);
        for solution in [checked, blind] {
            for (a, b) in solution.a.iter().zip(motion.acceleration.iter()) {
                assert!((a - b).abs() < 1e-10 * (1.0 + b.abs()), "{a} {b}");
            }
            let (a, b) = (solution.lambda[0], motion.multiplier[0]);
            assert!((a - b).abs() < 1e-10 * (1.0 + b.abs()), "{a} {b}");
        }
        // Friction as the formula has it, from the multiplier that was found.
        let speed = v[0].hypot(v[1]);
        let normal = motion.multiplier[0].abs() * (1.6 * q[0]).hypot(1.0);
        let share = -0.3 * normal * (speed / 0.05).tanh() / speed.max(1e-9);
        let lambda = motion.multiplier[0];
        let by_hand = [
            z - 1.6 * q[0] * lambda + share * v[0],
            -0.2 * 9.81 + lambda + share * v[1],
        ];
        for (a, force) in motion.acceleration.iter().zip(by_hand) {
            assert!((0.2 * a - force).abs() < 1e-9, "{a} {force}");
        }
        let rate = (0.4 - z) / 0.04;
        assert!((bead.state_rate(&x)[0] - rate).abs() < 1e-12);
        assert_eq!(bead::initial_state(&bead.parameters, &x), [u]);
    }
}

/// A second of a sine: the drive's past is kept by hand here, from the log there.
#[test]
fn motions_agree() {
    let machine = Machine::new(models::one("bead.model"));
    let values = machine.nominal_parameters();
    let command = |t: f64| 0.8 * (7.0 * t).sin();
    let late = |t: f64| if t < 0.015 { 0.0 } else { command(t - 0.015) };
    let step = 1e-3;
    let t: Vec<f64> = (0..=1000).map(|k| f64::from(k) * step).collect();
    let u = vec![t.iter().map(|&t| command(t)).collect::<Vec<f64>>()];
    let [starts, ends] = machine.inputs_over(&t, &u, Hold::Linear, &values);
    let options = RolloutOptions {
        max_step: step,
        stabilisation: 20.0,
    };
    let rollout = Rollout::new(&machine, &values, options);
    let mut moved = Simulated {
        q: vec![vec![0.5], vec![0.2]],
        v: vec![vec![0.0], vec![0.0]],
        z: Vec::new(),
    };
    let bead = Bead::<f64>::nominal();
    let simulation = Simulation::new(&bead).with_baumgarte(Baumgarte::critical(20.0));
    let mut state = State {
        q: [0.5, 0.2],
        v: [0.0; 2],
        z: [command(0.0)],
    };
    for k in 0..1000 {
        let at = |columns: &[Vec<f64>]| columns.iter().map(|u| vec![u[k]]).collect::<Vec<_>>();
        rollout
            .advance(&mut moved, &[t[k]], step, &at(&starts), &at(&ends))
            .unwrap();
        state = simulation
            .rk4_step(t[k], &state, step, |t, _| [command(t), late(t), 0.0])
            .unwrap();
    }
    let way = (state.q[0] - 0.5).abs();
    assert!(way > 0.05, "{way}");
    for i in 0..2 {
        assert!(
            (moved.q[i][0] - state.q[i]).abs() < 1e-5,
            "{} {}",
            moved.q[i][0],
            state.q[i]
        );
    }
    assert!((moved.z[0][0] - state.z[0]).abs() < 1e-5);
    assert!((state.q[1] - 0.8 * state.q[0].powi(2)).abs() < 1e-6);
}
