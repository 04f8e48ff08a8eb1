//! Robots that float by their twists, on the tape: Pinocchio's figures in its own convention
//! (`tests/pinocchio/floating.py`), and how many operations they take.

use dynamics_codegen::derive::{Expansion, Item};
use dynamics_codegen::{Compiled, Library, Tape, compile};
use serde_json::Value;
use std::path::Path;

/// Of the largest entry.
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
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let folder = match name {
            "humanoid" => root.join("tests/pinocchio"),
            _ => root.join("models"),
        };
        let mut library = Library::empty();
        library.look_in(&folder);
        let text = format!(
            "model robot; urdf \"{name}.urdf\" {{ base: floating; velocities: twist; losses: ignore; snap: off; }}"
        );
        let compiled = compile("robot.model", &text, &library).unwrap_or_else(|e| panic!("{e}"));
        let path = root.join(format!("tests/pinocchio/floating/{name}.json"));
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
    fn check(&self, state: &Value, key: &str, ours: &[f64]) {
        let (ours, theirs) = (self.theirs(ours), numbers(&state[key]));
        assert_eq!(ours.len(), theirs.len(), "{} {key}", self.name);
        let size = theirs.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (x, y) in ours.iter().zip(&theirs) {
            let near = (x - y).abs() <= TOLERANCE * size;
            assert!(near, "{} {key}: {x} {y}, of {size}", self.name);
        }
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
                robot.check(state, key, &found);
            }
        }
    }
}

/// Operations of `M`, of the bias force, and of both.
#[test]
fn operations() {
    let counts = [
        ("solo12", [621, 1087, 1684]),
        ("humanoid", [3068, 3293, 6303]),
    ];
    for (name, expected) in counts {
        let compiled = Robot::new(name).compiled;
        let (graph, system) = (&compiled.model.graph, &compiled.system);
        let (mass, bias) = (system.mass_matrix.concat(), system.bias_force.clone());
        let both = [mass.clone(), bias.clone()].concat();
        let found = [mass, bias, both].map(|entries| graph.operation_count(&entries));
        assert_eq!(found, expected, "{name}");
    }
}
