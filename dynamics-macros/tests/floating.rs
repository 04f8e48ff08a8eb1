//! Robots that float by their twists, in Rust: Pinocchio's figures in its own convention
//! (`tests/pinocchio/floating.py`); and a body that tumbles.

use dynamics::integrate::{DormandPrince, State};
use dynamics::{Dynamics, Point, Simulation, System, moved};
use serde_json::Value;

/// Of the largest entry.
const TOLERANCE: f64 = 1e-9;

#[derive(Dynamics)]
#[dynamics(
    model = "tests/models/solo12_floating.model",
    functions = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives"
)]
struct Solo12;

#[derive(Dynamics)]
#[dynamics(
    model = "tests/models/humanoid_floating.model",
    functions = "inverse_dynamics, forward_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives"
)]
struct Humanoid;

#[derive(Dynamics)]
#[dynamics(model = "tests/models/tumbling.model")]
struct Tumbling;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// Pinocchio's figures of a robot.
struct Robot {
    name: &'static str,
    figures: Value,
    /// Where each of Pinocchio's velocities stands among ours; positions are one further behind
    /// the base.
    order: Vec<usize>,
    /// Where each input acts among the velocities.
    driven: Vec<usize>,
}

impl Robot {
    fn new(name: &'static str, velocities: &[&str], inputs: &[&str]) -> Self {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/pinocchio/floating");
        let text = std::fs::read_to_string(format!("{folder}/{name}.json")).expect("figures");
        let figures: Value = serde_json::from_str(&text).expect("valid");
        let place = |joint: &str| velocities.iter().position(|name| joint == *name).unwrap();
        let joints = figures["joints"].as_array().expect("joints").iter();
        let joints = joints.map(|joint| place(joint.as_str().expect("a name")));
        Self {
            name,
            order: (0..6).chain(joints).collect(),
            driven: inputs.iter().map(|input| place(input)).collect(),
            figures,
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
    fn check(&self, state: &Value, key: &str, ours: &[f64]) {
        self.near(key, &self.theirs(ours), &numbers(&state[key]));
    }

    fn near(&self, what: &str, ours: &[f64], theirs: &[f64]) {
        assert_eq!(ours.len(), theirs.len(), "{} {what}", self.name);
        let size = theirs.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (x, y) in ours.iter().zip(theirs) {
            let near = (x - y).abs() <= TOLERANCE * size;
            assert!(near, "{} {what}: {x} {y}, of {size}", self.name);
        }
    }

    /// Torques of the joints, in the order of the inputs.
    fn efforts(&self, state: &Value) -> Vec<f64> {
        let tau = self.velocities(&numbers(&state["tau"]));
        self.driven.iter().map(|&place| tau[place]).collect()
    }
}

/// Rows one behind the other.
fn rows<const N: usize>(matrix: &dynamics::nalgebra::SMatrix<f64, N, N>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// The same checks for either robot, whose sizes are known when this is compiled.
macro_rules! rust_agrees {
    ($name:literal, $system:ident, $n:literal, $q:literal, $u:literal) => {{
        let robot = Robot::new($name, &<$system>::COORDINATE_NAMES, &<$system>::INPUT_NAMES);
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
            robot.check(state, "M", &rows(&mass));
            robot.check(state, "bias", &bias);
            robot.check(state, "tau_id", &system.inverse_dynamics(&x, &given));
            robot.check(state, "a", &system.forward_dynamics(&x));
            let slopes = system.inverse_dynamics_derivatives(&x, &given);
            let by = slopes.inverse_dynamics_by_position.concat();
            robot.check(state, "dtau_dq", &by);
            let by = slopes.inverse_dynamics_by_velocity.concat();
            robot.check(state, "dtau_dv", &by);
            let motion = system.forward_dynamics_derivatives(&x);
            let by = motion.forward_dynamics_by_position.concat();
            robot.check(state, "da_dq", &by);
            let by = motion.forward_dynamics_by_velocity.concat();
            robot.check(state, "da_dv", &by);
            let step = robot.velocities(&numbers(&state["step"]));
            let step: [f64; $n] = step.try_into().unwrap();
            let poses = &<$system>::POSES;
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
            robot.near("integrate", &found, &expected);
        }
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
