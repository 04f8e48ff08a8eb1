//! Robots that float by their twists, with Pinocchio's figures of them in its own convention
//! (`pinocchio/floating.py`).

use crate::files::root;
use crate::models;
use crate::reference::Deviations;
use dynamics_codegen::Compiled;
use serde_json::Value;

/// The robots: a quadruped of twelve joints and a humanoid of 29.
pub const ROBOTS: [&str; 2] = ["solo12", "humanoid"];

/// How far figures may be apart, of the largest entry.
pub const TOLERANCE: f64 = 1e-9;

/// What is compared, with Pinocchio's names for it, and the sign that Pinocchio gives it.
pub const QUANTITIES: [(&str, &str, f64); 8] = [
    ("mass_matrix", "M", 1.0),
    ("bias_force", "bias", -1.0),
    ("inverse_dynamics", "tau_id", 1.0),
    ("forward_dynamics", "a", 1.0),
    ("inverse_dynamics_by_position", "dtau_dq", 1.0),
    ("inverse_dynamics_by_velocity", "dtau_dv", 1.0),
    ("forward_dynamics_by_position", "da_dq", 1.0),
    ("forward_dynamics_by_velocity", "da_dv", 1.0),
];

/// A robot with its figures.
#[derive(Debug)]
pub struct Floating {
    /// The robot's name.
    pub name: &'static str,
    /// The model.
    pub compiled: Compiled,
    figures: Value,
    /// Where each of Pinocchio's velocities stands among ours; positions are one further behind
    /// the base.
    order: Vec<usize>,
    worst: Deviations,
}

impl Floating {
    /// Reads the model and the figures of one of [`ROBOTS`].
    ///
    /// # Panics
    /// If a file is missing, or the joints are not those of the model.
    pub fn read(name: &'static str) -> Self {
        let folder = "tests/pinocchio/floating";
        let compiled = models::read(&format!("{folder}/{name}.model"));
        let path = root().join(format!("{folder}/{name}.json"));
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let figures: Value = serde_json::from_str(&text).expect("figures are JSON");
        let coordinates = &compiled.model.coordinates;
        let place = |joint: &Value| {
            let found = coordinates.iter().position(|c| joint == &c.name);
            found.unwrap_or_else(|| panic!("{name}: no coordinate {joint}"))
        };
        let joints = figures["joints"].as_array().expect("a list of joints");
        let order: Vec<usize> = (0..6).chain(joints.iter().map(place)).collect();
        assert_eq!(order.len(), coordinates.len(), "{name}: joints");
        Self {
            name,
            compiled,
            figures,
            order,
            worst: Deviations::default(),
        }
    }

    /// The states, for [`check`](Self::check).
    pub fn states(&self) -> Vec<Value> {
        self.figures["states"]
            .as_array()
            .expect("a list of states")
            .clone()
    }

    /// Figures along velocities, in our order.
    pub fn velocities(&self, state: &Value, key: &str) -> Vec<f64> {
        let theirs = numbers(&state[key]);
        assert_eq!(
            theirs.len(),
            self.order.len(),
            "{}: size of {key}",
            self.name
        );
        let mut ours = vec![0.0; theirs.len()];
        for (&place, value) in self.order.iter().zip(theirs) {
            ours[place] = value;
        }
        ours
    }

    /// Positions, in our order.
    pub fn positions(&self, state: &Value, key: &str) -> Vec<f64> {
        let theirs = numbers(&state[key]);
        assert_eq!(
            theirs.len(),
            self.order.len() + 1,
            "{}: size of {key}",
            self.name
        );
        let mut ours = theirs.clone();
        for (&place, &value) in self.order[6..].iter().zip(&theirs[7..]) {
            ours[place + 1] = value;
        }
        ours
    }

    /// Torques of the joints, in the order of the inputs.
    pub fn inputs(&self, state: &Value) -> Vec<f64> {
        let torques = self.velocities(state, "tau");
        let model = &self.compiled.model;
        let torque = |input: &str| {
            let place = model.coordinates.iter().position(|c| c.name == input);
            torques[place.expect("inputs have the names of joints")]
        };
        model.inputs.iter().map(|u| torque(&u.name)).collect()
    }

    /// What emitted functions take: `t, q, v, u, a`.
    pub fn arguments(&self, state: &Value) -> Vec<f64> {
        let (q, v) = (self.positions(state, "q"), self.velocities(state, "v"));
        let a = self.velocities(state, "a_in");
        [vec![0.0], q, v, self.inputs(state), a].concat()
    }

    /// Asserts that a vector, or a matrix row by row, is the figure of this key.
    ///
    /// # Panics
    /// If it is not, within [`TOLERANCE`].
    pub fn check(&mut self, state: &Value, key: &str, ours: &[f64]) {
        let n = self.order.len();
        let rows = self.order.iter();
        let ours: Vec<f64> = if ours.len() == n {
            rows.map(|&i| ours[i]).collect()
        } else {
            rows.flat_map(|&i| self.order.iter().map(move |&j| ours[i * n + j]))
                .collect()
        };
        let expected = numbers(&state[key]);
        self.worst
            .check((self.name, key), &ours, &expected, TOLERANCE);
    }

    /// Asserts that the first rows of a link's Jacobian are these, all six or those of its velocity.
    ///
    /// # Panics
    /// If they are not, or there are no figures of the link.
    pub fn check_jacobian(&mut self, state: &Value, link: &str, ours: &[f64]) {
        let links = self.figures["links"].as_array().expect("a list of links");
        let place = links.iter().position(|known| known == link);
        let place = place.unwrap_or_else(|| panic!("{}: no figures of {link}", self.name));
        let rows = ours.chunks(self.order.len());
        let ours: Vec<f64> = rows
            .flat_map(|row| self.order.iter().map(|&j| row[j]))
            .collect();
        let expected = numbers(&state["J"][place]);
        let expected = &expected[..ours.len()];
        self.worst
            .check((self.name, link), &ours, expected, TOLERANCE);
    }

    /// Asserts that these are accelerations by inputs: a row per velocity, a column per input.
    ///
    /// # Panics
    /// If they are not, within [`TOLERANCE`].
    pub fn check_by_input(&mut self, state: &Value, ours: &[f64]) {
        let (n, model) = (self.order.len(), &self.compiled.model);
        let torques = numbers(&state["da_dtau"]);
        let driven: Vec<usize> = (model.inputs.iter())
            .map(|u| {
                self.order
                    .iter()
                    .position(|&i| model.coordinates[i].name == u.name)
            })
            .map(|place| place.expect("inputs have the names of joints"))
            .collect();
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        for (row, &place) in self.order.iter().enumerate() {
            found.extend(&ours[place * driven.len()..][..driven.len()]);
            expected.extend(driven.iter().map(|column| torques[row * n + column]));
        }
        self.worst
            .check((self.name, "da_dtau"), &found, &expected, TOLERANCE);
    }

    /// As [`check`](Self::check) for the quantity of a name, if it is one of [`QUANTITIES`]; whether it is.
    ///
    /// # Panics
    /// If it is one and differs.
    pub fn check_quantity(&mut self, state: &Value, name: &str, found: &[f64]) -> bool {
        let known = QUANTITIES.iter().find(|(known, ..)| *known == name);
        let Some((_, key, sign)) = known else {
            return false;
        };
        let found: Vec<f64> = found.iter().map(|x| sign * x).collect();
        self.check(state, key, &found);
        true
    }

    /// The robot's name, and how far each quantity was apart at most.
    pub fn summary(&self) -> String {
        format!("{}: {}", self.name, self.worst.summary())
    }
}

/// All numbers of a value, row by row.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}
