//! A model with everything that remembers or rubs: generated code moves as the machine of
//! `identify` does, and both as CasADi says.

use dynamics::constrained::{Baumgarte, Tolerance};
use dynamics::integrate::State;
use dynamics::{Point, Simulation, System as _, acceleration, acceleration_full_rank};
use dynamics_codegen::derive::Variable;
use generated::bead::{self, Bead};
use identify::machine::{Hold, Machine, Memory, Rollout, RolloutOptions, Simulated, States};
use integration_tests::models;
use integration_tests::reference::{Case, Deviations, Reference};

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
            memory: Memory {
                delayed: vec![vec![0.4]],
                delay_rate: vec![vec![0.0]],
                z: vec![vec![z]],
                slopes: Vec::new(),
            },
            ..States::default()
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

/// Relative to the largest entry of the quantity, or to what is differentiated.
const VALUES: f64 = 1e-10;
const DERIVATIVES: f64 = 1e-8;

fn array<const N: usize>(case: &Case, key: &str) -> [f64; N] {
    case.numbers(key)
        .try_into()
        .expect("as many as the model has")
}

/// What stands in `c`, `ċ` and in derivatives by what does not act is rounding.
fn check_above(
    worst: &mut Deviations,
    at: (&str, &str),
    found: &[f64],
    expected: &[f64],
    allowed: f64,
) {
    let with_floor = |values: &[f64]| [values, &[1e-2]].concat();
    worst.check(at, &with_floor(found), &with_floor(expected), allowed);
}

#[test]
fn generated_code_agrees_with_casadi() {
    let reference = Reference::read("bead");
    assert_eq!(reference.cases.len(), 50);
    assert_eq!(bead::PARAMETER_NAMES.as_slice(), reference.parameters);
    let mut worst = Deviations::default();
    for case in &reference.cases {
        let values: Vec<f64> = reference
            .parameters
            .iter()
            .map(|p| case.parameter(p))
            .collect();
        let parameters = bead::Parameters::from_array(values.try_into().expect("all of them"));
        let model = Bead { parameters };
        let p = &model.parameters;
        let ([u], [late], [lambda]) =
            (array(case, "u"), array(case, "late"), array(case, "lambda"));
        let x = Point {
            t: case.time(),
            q: array(case, "q"),
            v: array(case, "v"),
            u: [u, late, lambda],
            z: array(case, "z"),
        };
        let mut check = |name, found: &[f64]| {
            worst.check((case.place(), name), found, &case.numbers(name), VALUES);
        };
        check("M", &bead::mass_matrix(p, &x).concat());
        check("bias", &bead::bias_force(p, &x));
        check("Q", &bead::force(p, &x));
        check("A", &bead::constraint_jacobian(p, &x).concat());
        check("b", &bead::constraint_bias(p, &x));
        check("z_dot", &model.state_rate(&x));
        // The multipliers are found, not stated.
        let forgotten = Point {
            u: [u, late, 0.0],
            ..x
        };
        let motion = acceleration(&model, &forgotten, None, &Tolerance::default()).unwrap();
        check("a", motion.a.as_slice());
        check("lambda", motion.lambda.as_slice());
    }
    println!("bead, generated: {}", worst.summary());
}

#[test]
fn the_machine_agrees_with_casadi() {
    let reference = Reference::read("bead");
    let mut machine = Machine::new(models::one("bead.model"));
    let groups: [(&str, Vec<Variable>); 4] = [
        ("q", (0..2).map(Variable::Position).collect()),
        ("v", (0..2).map(Variable::Velocity).collect()),
        ("t", vec![Variable::Time]),
        ("p", (0..6).map(Variable::Parameter).collect()),
    ];
    let tapes = groups.map(|(group, variables)| (group, machine.sensitivity(&variables)));
    let mut worst = Deviations::default();
    for case in &reference.cases {
        let columns = |key: &str| case.numbers(key).into_iter().map(|x| vec![x]).collect();
        let states = States {
            t: vec![case.time()],
            q: columns("q"),
            v: columns("v"),
            u: columns("u"),
            // At a given past: what parameters did to it stays out.
            memory: Memory {
                delayed: columns("late"),
                delay_rate: vec![vec![0.0]],
                z: columns("z"),
                slopes: Vec::new(),
            },
            ..States::default()
        };
        let values: Vec<f64> = reference
            .parameters
            .iter()
            .map(|p| case.parameter(p))
            .collect();
        let motion = machine.motion(&states, &values).unwrap();
        let (a, lambda) = (&motion[0].acceleration, &motion[0].multiplier);
        let terms = &motion[0].terms;
        let parts = [
            ("a", a.as_slice()),
            ("lambda", lambda.as_slice()),
            ("M", terms.mass_matrix.as_slice()),
            ("A", terms.constraint_matrix.as_slice()),
            ("b", terms.constraint_bias.as_slice()),
        ];
        for (name, found) in parts {
            worst.check((case.place(), name), found, &case.numbers(name), VALUES);
        }
        for (name, found) in [
            ("c", &terms.constraint_residual),
            ("c_dot", &terms.constraint_rate),
        ] {
            let expected = case.numbers(name);
            check_above(
                &mut worst,
                (case.place(), name),
                found.as_slice(),
                &expected,
                VALUES,
            );
        }
        for (group, tape) in &tapes {
            let slopes = &tape.evaluate(&states, &values, &motion)[0];
            for (of, found) in [("a", &slopes.0), ("lambda", &slopes.1)] {
                let name = format!("d{of}_d{group}");
                let found = found.transpose();
                let expected = case.numbers(&name);
                check_above(
                    &mut worst,
                    (case.place(), &name),
                    found.as_slice(),
                    &expected,
                    DERIVATIVES,
                );
            }
        }
    }
    println!("bead, machine: {}", worst.summary());
}
