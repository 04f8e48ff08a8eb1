//! Robots that float by their twists, in Rust, in C and on the tape: Pinocchio's figures in its own
//! convention (`pinocchio/floating.py`); and a body that tumbles.

use dynamics::integrate::{DormandPrince, State};
use dynamics::nalgebra::{Quaternion, SMatrix, UnitQuaternion, Vector3};
use dynamics::{Dynamics, Point, Simulation, System, moved};
use dynamics_codegen::Tape;
use dynamics_codegen::derive::{Expansion, Item};
use dynamics_codegen::emit::Emission;
use integration_tests::c_program;
use integration_tests::compiler::Precision;
use integration_tests::floating::{Floating, QUANTITIES, ROBOTS, TOLERANCE};
use std::collections::BTreeSet;

/// What is generated in C; the derives ask for the same.
const FUNCTIONS: &str = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, \
                         forward_dynamics_derivatives";

/// Of each robot a frame, and the function that is its Jacobian.
const FRAMES: [(&str, &str); 2] = [
    ("FL_FOOT", "frame_jacobian_of_fl_foot"),
    (
        "right_wrist_yaw_link",
        "frame_jacobian_of_right_wrist_yaw_link",
    ),
];

#[derive(Dynamics)]
#[dynamics(
    model = "pinocchio/floating/solo12.model",
    functions = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives, frame_jacobian_of_FL_FOOT"
)]
struct Solo12;

#[derive(Dynamics)]
#[dynamics(
    model = "pinocchio/floating/humanoid.model",
    functions = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives, frame_jacobian_of_right_wrist_yaw_link"
)]
struct Humanoid;

#[derive(Dynamics)]
#[dynamics(model = "data/models/tumbling.model")]
struct Tumbling;

#[test]
fn the_tape_agrees_with_pinocchio() {
    for mut robot in ROBOTS.map(Floating::read) {
        let mut expansion = Expansion::new(&robot.compiled);
        let quantities = QUANTITIES.map(|(name, ..)| {
            let item = Item::parse(name).expect("an item");
            (name, expansion.entries(item).unwrap())
        });
        let mut arguments = dynamics_codegen::emit::arguments(&expansion.model);
        arguments.extend(&expansion.acceleration);
        for (name, entries) in quantities {
            let tape = Tape::new(&expansion.model.graph, &entries, &arguments);
            for state in robot.states() {
                let found = tape.evaluate(&robot.arguments(&state));
                assert!(robot.check_quantity(&state, name, &found));
            }
        }
        println!("{}", robot.summary());
    }
}

#[test]
fn c_agrees_with_pinocchio() {
    if left_out::too_slow() {
        return;
    }
    for (mut robot, (frame, jacobian)) in ROBOTS.map(Floating::read).into_iter().zip(FRAMES) {
        let folder = tempfile::tempdir().unwrap();
        let compiled = robot.compiled.clone();
        let functions = format!("{FUNCTIONS}, {jacobian}").parse().unwrap();
        let emission = Emission::new(&compiled, "floating.model", &functions).unwrap();
        let program = c_program::build(&emission, &compiled, folder.path(), Precision::Double);
        let mut checked = BTreeSet::new();
        for state in robot.states() {
            let printed = c_program::run(&program, &robot.arguments(&state));
            let mut printed = printed.into_iter();
            for quantity in emission.functions().flat_map(|(_, quantities)| quantities) {
                let length = quantity.shape().iter().product();
                let found: Vec<f64> = printed.by_ref().take(length).collect();
                let known = if quantity.name == jacobian {
                    robot.check_jacobian(&state, frame, &found);
                    true
                } else {
                    robot.check_quantity(&state, &quantity.name, &found)
                };
                if known {
                    checked.insert(quantity.name.as_str());
                }
            }
            assert_eq!(printed.next(), None);
        }
        assert_eq!(checked.len(), QUANTITIES.len() + 1, "{checked:?}");
        println!("{}", robot.summary());
    }
}

/// Rows one behind the other.
fn rows<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// The same checks for either robot, whose sizes are known when this is compiled.
macro_rules! rust_agrees {
    ($name:literal, $system:ident, $n:literal, $q:literal, $u:literal, $frame:literal, $jacobian:ident) => {{
        let mut robot = Floating::read($name);
        let system = $system;
        for state in robot.states() {
            let x: Point<f64, $n, $u, 0, $q> = Point {
                t: 0.0,
                q: robot.positions(&state, "q").try_into().unwrap(),
                v: robot.velocities(&state, "v").try_into().unwrap(),
                u: robot.inputs(&state).try_into().unwrap(),
                z: [],
            };
            let given: [f64; $n] = robot.velocities(&state, "a_in").try_into().unwrap();
            let mass = System::mass_matrix(&system, &x);
            let slopes = system.inverse_dynamics_derivatives(&x, &given);
            let motion = system.forward_dynamics_derivatives(&x);
            robot.check(&state, "M", &rows(&mass));
            robot.check(&state, "bias", &system.bias_force(&x).map(|x| -x));
            robot.check(&state, "tau_id", &system.inverse_dynamics(&x, &given));
            robot.check(&state, "a", &system.forward_dynamics(&x));
            robot.check(&state, "a", &motion.forward_dynamics);
            for (key, matrix) in [
                ("dtau_dq", slopes.inverse_dynamics_by_position),
                ("dtau_dv", slopes.inverse_dynamics_by_velocity),
                ("da_dq", motion.forward_dynamics_by_position),
                ("da_dv", motion.forward_dynamics_by_velocity),
            ] {
                robot.check(&state, key, &matrix.concat());
            }
            robot.check_jacobian(&state, $frame, &system.$jacobian(&x).concat());
            let step: [f64; $n] = robot.velocities(&state, "step").try_into().unwrap();
            let found = moved(&<$system>::POSES, &x.q, &step, 1.0);
            same_place(&found, &robot.positions(&state, "moved"));
        }
        println!("{}", robot.summary());
    }};
}

/// Of positions whose first seven are a pose: a quaternion and its negative are one orientation.
fn same_place(found: &[f64], expected: &[f64]) {
    let along: f64 = (3..7).map(|k| found[k] * expected[k]).sum();
    for (k, (x, y)) in found.iter().zip(expected).enumerate() {
        let sign = if (3..7).contains(&k) {
            along.signum()
        } else {
            1.0
        };
        assert!((sign * x - y).abs() < TOLERANCE, "position {k}: {x} {y}");
    }
}

#[test]
fn rust_agrees_with_pinocchio() {
    rust_agrees!(
        "solo12",
        Solo12,
        18,
        19,
        12,
        "FL_FOOT",
        frame_jacobian_of_fl_foot
    );
    rust_agrees!(
        "humanoid",
        Humanoid,
        35,
        36,
        29,
        "right_wrist_yaw_link",
        frame_jacobian_of_right_wrist_yaw_link
    );
}

/// Energy, and the angular momentum in the world's axes, of the box at a state.
fn invariants(state: &State<f64, 6, 0, 7>) -> [f64; 4] {
    const INERTIA: [f64; 3] = [
        0.00833333333333333,
        0.02833333333333333,
        0.03333333333333333,
    ];
    let v = |k: usize| Vector3::new(state.v[k], state.v[k + 1], state.v[k + 2]);
    let (velocity, turning) = (v(0), v(3));
    let momentum = Vector3::from(INERTIA).component_mul(&turning);
    let energy = velocity.norm_squared() + 0.5 * momentum.dot(&turning);
    let [x, y, z, w] = [state.q[3], state.q[4], state.q[5], state.q[6]];
    let attitude = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    let world = attitude * momentum;
    [energy, world.x, world.y, world.z]
}

/// About its middle axis: it tumbles, and turns over again and again.
const TUMBLING: State<f64, 6, 0, 7> = State {
    q: [0.0, 0.0, 0.0, 0.1, -0.3, 0.9, 0.3],
    v: [0.4, -0.2, 0.1, 0.02, 2.0, 0.01],
    z: [],
};

/// For 100 s nothing is lost and nothing gained, whichever way time is cut.
#[test]
fn a_tumbling_body_keeps_energy_and_momentum() {
    let start = State {
        q: moved(&Tumbling::POSES, &TUMBLING.q, &[0.0; 6], 0.0),
        ..TUMBLING
    };
    let expected = invariants(&start);
    let near = |state: &State<f64, 6, 0, 7>, t: f64| {
        let length: f64 = state.q[3..].iter().map(|x| x * x).sum();
        assert!((length - 1.0).abs() < 1e-10, "{t} s: length {length}");
        for (found, expected) in invariants(state).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{t} s: {found} {expected}");
        }
    };
    let simulation = Simulation::new(&Tumbling);
    let solver = DormandPrince {
        relative: 1e-13,
        absolute: 1e-13,
        ..Default::default()
    };
    let mut turned_over = 0;
    let mut last = 1.0;
    let (end, _) = simulation
        .sample(
            &solver,
            (0.0, &start),
            (100.0, 0.1),
            |_, _| [],
            |t, state| {
                near(state, t);
                if state.v[4] * last < 0.0 {
                    (turned_over, last) = (turned_over + 1, state.v[4]);
                }
            },
        )
        .unwrap();
    assert!(turned_over >= 4, "it only spins: {turned_over}");
    let (mut state, h) = (start, 1e-3);
    for step in 0..100_000 {
        let t = f64::from(step) * h;
        state = simulation.rk4_step(t, &state, h, |_, _| []).unwrap();
        if step % 100 == 0 {
            near(&state, t);
        }
    }
    for (a, b) in end.q.into_iter().zip(state.q) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

/// Operations of what is emitted for `M`, for the bias force, for both, and for the forward
/// dynamics.
#[test]
fn operations() {
    let counts = [
        ("solo12", [544, 1021, 1383, 2460]),
        ("humanoid", [2774, 3174, 5366, 7445]),
    ];
    let functions = "mass_matrix+bias_force,forward_dynamics".parse().unwrap();
    for (name, expected) in counts {
        let compiled = Floating::read(name).compiled;
        let emission = Emission::new(&compiled, name, &functions).unwrap();
        let functions = [
            "mass_matrix",
            "bias_force",
            "mass_matrix_and_bias_force",
            "forward_dynamics",
        ];
        let found = functions.map(|wanted: &str| -> usize {
            let mut functions = emission.functions();
            let (_, quantities) = functions.find(|(name, _)| *name == wanted).unwrap();
            let entries: Vec<_> = quantities
                .iter()
                .flat_map(|q| &q.entries)
                .copied()
                .collect();
            emission.graph().operation_count(&entries)
        });
        assert_eq!(found, expected, "{name}");
    }
}
