//! Robots that float by their twists: Pinocchio's figures in its own convention
//! (`pinocchio/floating.py`), in Rust, C and on the tape; and a body that tumbles.

use dynamics::integrate::{DormandPrince, State};
use dynamics::{Dynamics, Point, Simulation, System, moved};
use dynamics_codegen::derive::{Expansion, Item};
use dynamics_codegen::emit::Emission;
use dynamics_codegen::{Compiled, Tape};
use identify::machine::{Lineariser, Machine, Rollout, RolloutOptions, Simulated, States};
use integration_tests::compiler::Precision;
use integration_tests::{c_program, files::root, models, reference::Deviations};
use serde_json::Value;
use std::fmt::Write as _;

const TOLERANCE: f64 = 1e-9;

/// What is compared, with Pinocchio's names for it, and whether Pinocchio has the other sign.
const QUANTITIES: [(&str, &str, f64); 8] = [
    ("mass_matrix", "M", 1.0),
    ("bias_force", "bias", -1.0),
    ("inverse_dynamics", "tau_id", 1.0),
    ("forward_dynamics", "a", 1.0),
    ("inverse_dynamics_by_position", "dtau_dq", 1.0),
    ("inverse_dynamics_by_velocity", "dtau_dv", 1.0),
    ("forward_dynamics_by_position", "da_dq", 1.0),
    ("forward_dynamics_by_velocity", "da_dv", 1.0),
];

const FUNCTIONS: &str = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, \
                         forward_dynamics_derivatives";

#[derive(Dynamics)]
#[dynamics(
    model = "data/models/solo12_floating.model",
    functions = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives"
)]
struct Solo12;

#[derive(Dynamics)]
#[dynamics(
    model = "data/models/humanoid_floating.model",
    functions = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives"
)]
struct Humanoid;

#[derive(Dynamics)]
#[dynamics(model = "data/models/tumbling.model")]
struct Tumbling;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// A robot with Pinocchio's figures of it.
struct Robot {
    name: &'static str,
    compiled: Compiled,
    figures: Value,
    /// Where each of Pinocchio's velocities stands among ours; positions are one further behind
    /// the base.
    order: Vec<usize>,
}

impl Robot {
    fn new(name: &'static str) -> Self {
        let compiled = models::read(&format!("tests/data/models/{name}_floating.model"));
        let path = root().join(format!("tests/pinocchio/floating/{name}.json"));
        let text = std::fs::read_to_string(path).expect("figures");
        let figures: Value = serde_json::from_str(&text).expect("valid");
        let names: Vec<&str> = compiled
            .model
            .coordinates
            .iter()
            .map(|c| c.name.as_str())
            .collect();
        let joints = figures["joints"].as_array().expect("joints").iter();
        let place = |joint: &Value| {
            names
                .iter()
                .position(|name| joint == name)
                .expect("a joint")
        };
        let order: Vec<usize> = (0..6).chain(joints.map(place)).collect();
        assert_eq!(order.len(), names.len());
        Self {
            name,
            compiled,
            figures,
            order,
        }
    }

    fn states(&self) -> &[Value] {
        self.figures["states"].as_array().expect("states")
    }

    fn velocities(&self, theirs: &[f64]) -> Vec<f64> {
        let mut ours = vec![0.0; theirs.len()];
        for (&place, &value) in self.order.iter().zip(theirs) {
            ours[place] = value;
        }
        ours
    }

    fn positions(&self, theirs: &[f64]) -> Vec<f64> {
        let mut ours = theirs.to_vec();
        for (&place, &value) in self.order[6..].iter().zip(&theirs[7..]) {
            ours[place + 1] = value;
        }
        ours
    }

    /// A vector or a matrix over velocities in Pinocchio's order.
    fn theirs(&self, ours: &[f64]) -> Vec<f64> {
        let n = self.order.len();
        let rows = self.order.iter();
        if ours.len() == n {
            return rows.map(|&i| ours[i]).collect();
        }
        rows.flat_map(|&i| self.order.iter().map(move |&j| ours[i * n + j]))
            .collect()
    }

    fn joints(&self, state: &Value) -> (Vec<f64>, Vec<f64>) {
        let q = self.positions(&numbers(&state["q"]));
        (q, self.velocities(&numbers(&state["v"])))
    }

    /// Compares what was found with the figures of this key.
    fn check(&self, worst: &mut Deviations, state: &Value, key: &str, ours: &[f64]) {
        let ours = self.theirs(ours);
        worst.check((self.name, key), &ours, &numbers(&state[key]), TOLERANCE);
    }

    /// The arguments of emitted functions.
    fn arguments(&self, state: &Value) -> Vec<f64> {
        let (q, v) = self.joints(state);
        let a = self.velocities(&numbers(&state["a_in"]));
        let u = self.efforts(state);
        [vec![0.0], q, v, u, a].concat()
    }

    /// Torques of the joints, in the order of the inputs.
    fn efforts(&self, state: &Value) -> Vec<f64> {
        let tau = self.velocities(&numbers(&state["tau"]));
        let inputs = self.compiled.model.inputs.iter();
        let place = |name: &str| {
            let mut coordinates = self.compiled.model.coordinates.iter();
            coordinates.position(|c| c.name == name).expect("a joint")
        };
        inputs.map(|u| tau[place(&u.name)]).collect()
    }
}

fn robots() -> [Robot; 2] {
    ["solo12", "humanoid"].map(Robot::new)
}

#[test]
fn the_tape_agrees_with_pinocchio() {
    for robot in robots() {
        let mut worst = Deviations::default();
        let mut expansion = Expansion::new(&robot.compiled);
        let mut tapes = Vec::new();
        for (name, key, sign) in QUANTITIES {
            let entries = expansion
                .entries(Item::parse(name).expect("an item"))
                .unwrap();
            tapes.push((entries, key, sign));
        }
        let mut arguments = dynamics_codegen::emit::arguments(&expansion.model);
        arguments.extend(&expansion.acceleration);
        for (entries, key, sign) in tapes {
            let tape = Tape::new(&expansion.model.graph, &entries, &arguments);
            for state in robot.states() {
                let found = tape.evaluate(&robot.arguments(state));
                let found: Vec<f64> = found.into_iter().map(|x| sign * x).collect();
                robot.check(&mut worst, state, key, &found);
            }
        }
        println!("{}: {}", robot.name, worst.summary());
    }
}

#[test]
fn c_agrees_with_pinocchio() {
    for robot in robots() {
        let mut worst = Deviations::default();
        let folder = tempfile::tempdir().unwrap();
        let functions = FUNCTIONS.parse().unwrap();
        let emission = Emission::new(&robot.compiled, "floating.model", &functions).unwrap();
        let program =
            c_program::build(&emission, &robot.compiled, folder.path(), Precision::Double);
        for state in robot.states() {
            let mut input = String::new();
            for value in robot.arguments(state) {
                let _ = writeln!(input, "{value:?}");
            }
            let mut printed = c_program::run(&program, &input).into_iter();
            for (_, quantities) in emission.functions() {
                for quantity in quantities {
                    let length = quantity.shape().iter().product();
                    let found: Vec<f64> = printed.by_ref().take(length).collect();
                    let wanted = QUANTITIES.iter().find(|(name, ..)| *name == quantity.name);
                    if let Some((_, key, sign)) = wanted {
                        let found: Vec<f64> = found.into_iter().map(|x| sign * x).collect();
                        robot.check(&mut worst, state, key, &found);
                    }
                }
            }
            assert_eq!(printed.next(), None);
        }
        println!("{}: {}", robot.name, worst.summary());
    }
}

/// Rows one behind the other.
fn rows<const N: usize>(matrix: &dynamics::nalgebra::SMatrix<f64, N, N>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// The same checks for either robot, whose sizes are known when this is compiled.
macro_rules! rust_agrees {
    ($name:literal, $system:expr, $n:literal, $q:literal, $u:literal) => {{
        let robot = Robot::new($name);
        let mut worst = Deviations::default();
        let system = $system;
        for state in robot.states() {
            let (q, v) = robot.joints(state);
            let x: Point<f64, $n, $u, 0, $q> = Point {
                t: 0.0,
                q: q.try_into().unwrap(),
                v: v.try_into().unwrap(),
                u: robot.efforts(state).try_into().unwrap(),
                z: [],
            };
            let given = robot.velocities(&numbers(&state["a_in"]));
            let given: [f64; $n] = given.try_into().unwrap();
            let bias = system.bias_force(&x).map(|x| -x);
            let mass = System::mass_matrix(&system, &x);
            robot.check(&mut worst, state, "M", &rows(&mass));
            robot.check(&mut worst, state, "bias", &bias);
            robot.check(
                &mut worst,
                state,
                "tau_id",
                &system.inverse_dynamics(&x, &given),
            );
            robot.check(&mut worst, state, "a", &system.forward_dynamics(&x));
            let slopes = system.inverse_dynamics_derivatives(&x, &given);
            let by = slopes.inverse_dynamics_by_position.concat();
            robot.check(&mut worst, state, "dtau_dq", &by);
            let by = slopes.inverse_dynamics_by_velocity.concat();
            robot.check(&mut worst, state, "dtau_dv", &by);
            let motion = system.forward_dynamics_derivatives(&x);
            let by = motion.forward_dynamics_by_position.concat();
            robot.check(&mut worst, state, "da_dq", &by);
            let by = motion.forward_dynamics_by_velocity.concat();
            robot.check(&mut worst, state, "da_dv", &by);
            let step = robot.velocities(&numbers(&state["step"]));
            let step: [f64; $n] = step.try_into().unwrap();
            let poses = <_ as System<f64, $n, $u, 0, 0, $q>>::poses(&system);
            let found = moved(poses, &x.q, &step, 1.0);
            let expected = robot.positions(&numbers(&state["moved"]));
            // A quaternion and its negative are one orientation.
            let same: f64 = (3..7).map(|k| found[k] * expected[k]).sum();
            let sign = |k: usize| {
                if (3..7).contains(&k) {
                    same.signum()
                } else {
                    1.0
                }
            };
            let found: Vec<f64> = (0..$q).map(|k| sign(k) * found[k]).collect();
            worst.check(($name, "integrate"), &found, &expected, TOLERANCE);
        }
        println!("{}: {}", $name, worst.summary());
    }};
}

#[test]
fn rust_agrees_with_pinocchio() {
    rust_agrees!("solo12", Solo12, 18, 19, 12);
    rust_agrees!("humanoid", Humanoid, 35, 36, 29);
}

/// Energy, and the angular momentum in the world's axes, of the box at a state.
fn invariants(state: &State<f64, 6, 0, 7>) -> [f64; 4] {
    const INERTIA: [f64; 3] = [
        0.00833333333333333,
        0.02833333333333333,
        0.03333333333333333,
    ];
    let [x, y, z, w] = [state.q[3], state.q[4], state.q[5], state.q[6]];
    let omega = [state.v[3], state.v[4], state.v[5]];
    let l: [f64; 3] = std::array::from_fn(|k| INERTIA[k] * omega[k]);
    let turning: f64 = (0..3).map(|k| 0.5 * l[k] * omega[k]).sum();
    let moving: f64 = state.v[..3].iter().map(|v| v * v).sum();
    let rotation = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    let world = rotation.map(|row| (0..3).map(|k| row[k] * l[k]).sum());
    let [lx, ly, lz]: [f64; 3] = world;
    [turning + moving, lx, ly, lz]
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
        q: moved(
            <Tumbling as System<f64, 6, 0, 0, 0, 7>>::poses(&Tumbling),
            &TUMBLING.q,
            &[0.0; 6],
            0.0,
        ),
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
    // The machine that simulates models known only now goes the same way.
    let machine = Machine::new(models::read("tests/data/models/tumbling.model"));
    let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect::<Vec<_>>();
    let mut rolled = Simulated {
        q: column(&start.q),
        v: column(&start.v),
        z: Vec::new(),
    };
    let options = RolloutOptions {
        max_step: 2e-3,
        ..RolloutOptions::default()
    };
    let rollout = Rollout::new(&machine, &[], options);
    rollout
        .advance(&mut rolled, &[0.0], 20.0, &[], &[])
        .unwrap();
    let there = State {
        q: std::array::from_fn(|i| rolled.q[i][0]),
        v: std::array::from_fn(|i| rolled.v[i][0]),
        z: [],
    };
    near(&there, 20.0);
}

/// First order of the motion, displacements seen from the body: what two motions are apart after a
/// moment.
#[test]
fn a_linearisation_is_along_the_twist() {
    let compiled = models::read("tests/data/models/solo12_floating.model");
    let lineariser = Lineariser::new(compiled.clone());
    let robot = Robot::new("solo12");
    let (q, v) = robot.joints(&robot.states()[0]);
    let u = robot.efforts(&robot.states()[0]);
    let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect::<Vec<_>>();
    let states = States {
        t: vec![0.0],
        q: column(&q),
        v: column(&v),
        u: column(&u),
        ..States::default()
    };
    let found = lineariser.at(&states, &[]).unwrap();
    let n = v.len();
    assert_eq!(found.a.nrows(), 2 * n);
    let machine = Machine::new(compiled);
    let options = RolloutOptions {
        max_step: 1e-4,
        ..RolloutOptions::default()
    };
    let poses = <Solo12 as System<f64, 18, 12, 0, 0, 19>>::poses(&Solo12);
    let (h, small) = (1e-4, 1e-5);
    let roll = |displacement: &[f64; 18], change: &[f64; 18]| -> ([f64; 19], [f64; 18]) {
        let from: [f64; 19] = q.clone().try_into().unwrap();
        let q = moved(poses, &from, displacement, 1.0);
        let v: Vec<f64> = v.iter().zip(change).map(|(v, dv)| v + dv).collect();
        let mut state = Simulated {
            q: column(&q),
            v: column(&v),
            z: Vec::new(),
        };
        let u = column(&u);
        let rollout = Rollout::new(&machine, &[], options);
        rollout.advance(&mut state, &[0.0], h, &u, &u).unwrap();
        (
            std::array::from_fn(|i| state.q[i][0]),
            std::array::from_fn(|i| state.v[i][0]),
        )
    };
    let still = roll(&[0.0; 18], &[0.0; 18]);
    for index in [0, 2, 3, 5, 9, 18, 20, 21, 23, 30] {
        let mut both = [[0.0; 18]; 2];
        both[index / n][index % n] = small;
        let there = roll(&both[0], &both[1]);
        let apart = displacement(&still.0, &there.0);
        let apart = apart
            .into_iter()
            .chain((0..n).map(|i| there.1[i] - still.1[i]));
        for (row, apart) in apart.enumerate() {
            let start = if row == index { small } else { 0.0 };
            let rate = (apart - start) / (h * small);
            let expected = found.a[(row, index)];
            // What is of second order in the time and in the size.
            let tolerance = 0.02 * (1.0 + found.a.column(index).amax());
            assert!(
                (rate - expected).abs() < tolerance,
                "{row} {index}: {rate} {expected}"
            );
        }
    }
}

/// The small displacement from one position to another, seen from the first.
fn displacement(from: &[f64; 19], to: &[f64; 19]) -> [f64; 18] {
    let [x, y, z, w] = [from[3], from[4], from[5], from[6]];
    let gap: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
    let rotation = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    let [a, b, c, d] = [to[3], to[4], to[5], to[6]];
    // Twice the vector part of the relative quaternion.
    let turn = [
        2.0 * (w * a - x * d - y * c + z * b),
        2.0 * (w * b + x * c - y * d - z * a),
        2.0 * (w * c - x * b + y * a - z * d),
    ];
    std::array::from_fn(|i| match i {
        0..=2 => (0..3).map(|k| rotation[k][i] * gap[k]).sum(),
        3..=5 => turn[i - 3],
        _ => to[i + 1] - from[i + 1],
    })
}

/// Operations of `M`, of the bias force, and of both.
#[test]
fn operations() {
    let counts = [("solo12", [0, 0, 0]), ("humanoid", [0, 0, 0])];
    for (name, expected) in counts {
        let compiled = Robot::new(name).compiled;
        let (graph, system) = (&compiled.model.graph, &compiled.system);
        let (mass, bias) = (system.mass_matrix.concat(), system.bias_force.clone());
        let both = [mass.clone(), bias.clone()].concat();
        let found = [mass, bias, both].map(|entries| graph.operation_count(&entries));
        assert_eq!(found, expected, "{name}");
    }
}
