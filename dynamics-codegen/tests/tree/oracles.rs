//! Trees against Pinocchio's numbers (conventions: `meta` in the files).

use crate::support::{Loaded, deviation, load, numbers};
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::tree::{Frame, Mechanism, Options};
use serde_json::Value;

struct Case {
    oracle: Value,
    loaded: Loaded,
    mechanism: Mechanism,
}

fn case(name: &str, urdf: &str, snap: Option<f64>) -> Option<Case> {
    let oracle = left_out::shared(&format!("oracles/oracle_{name}.json"))?;
    let urdf = left_out::shared(&format!("oracles/{urdf}.urdf"))?;
    let text = std::fs::read_to_string(oracle).expect("readable");
    let oracle: Value = serde_json::from_str(&text).expect("valid");
    let robot = urdf_rs::read_file(urdf).expect("a robot");
    let order: Vec<String> = (oracle["meta"]["joint_order"]
        .as_array()
        .expect("a list")
        .iter())
    .map(|n| n.as_str().expect("a name").to_owned())
    .collect();
    let mut loaded = load(&robot, Some(&order));
    let options = Options {
        snap,
        ..Options::default()
    };
    let mechanism = Mechanism::new(&mut loaded.graph, &loaded.tree, options).expect("a tree");
    Some(Case {
        oracle,
        loaded,
        mechanism,
    })
}

impl Case {
    /// The worst deviation over all states. `sign` multiplies ours.
    fn worst(&self, outputs: &[ExprId], key: &str, a_or_u: [&str; 2]) -> f64 {
        let states = self.oracle["states"].as_array().expect("states");
        assert_eq!(states.len(), 50);
        states.iter().fold(0.0, |worst: f64, state| {
            let [q, v, a, u] = ["q", "qd", a_or_u[0], a_or_u[1]].map(|name| numbers(&state[name]));
            let ours = self.loaded.evaluate(outputs, [&q, &v, &a, &u]);
            worst.max(deviation(&ours, &numbers(&state[key])))
        })
    }

    fn check(&self, outputs: &[ExprId], key: &str, tolerance: f64) {
        let worst = self.worst(outputs, key, ["qdd_in", "tau"]);
        println!("{key}: {worst:.1e}");
        assert!(worst < tolerance, "{key}: {worst:e}");
    }

    fn check_dynamics(&mut self) {
        let (a, u) = (
            self.loaded.vars(&self.loaded.a),
            self.loaded.vars(&self.loaded.u),
        );
        let g = &mut self.loaded.graph;
        let m = self.mechanism.mass_matrix(g).concat();
        let bias: Vec<ExprId> = self.mechanism.bias_force(g);
        let bias: Vec<ExprId> = bias.into_iter().map(|x| g.neg(x)).collect();
        let inverse = self.mechanism.inverse_dynamics(g, &a);
        let forward = self.mechanism.forward_dynamics(g, &u);
        let minv = self.mechanism.factor(g).inverse(g).concat();
        self.check(&m, "M", 1e-10);
        self.check(&bias, "bias", 1e-10);
        self.check(&inverse, "tau_id", 1e-10);
        self.check(&forward, "qdd", 1e-10);
        self.check(&minv, "Minv", 1e-10);
    }

    fn check_kinematics(&mut self) {
        let body = self
            .loaded
            .body(self.oracle["meta"]["ee_frame"].as_str().expect("a name"));
        let g = &mut self.loaded.graph;
        let frame = Frame::of_body(g, body);
        let pose = self.mechanism.pose(g, &frame);
        let jacobian = self.mechanism.jacobian(g, &frame).concat();
        let rate = self.mechanism.jacobian_rate(g, &frame).concat();
        let drift = self.mechanism.jacobian_rate_times_velocity(g, &frame);
        self.check(&pose.rotation.concat(), "ee_R", 1e-10);
        self.check(&pose.position, "ee_p", 1e-10);
        self.check(&jacobian, "J", 1e-10);
        self.check(&rate, "Jdot", 1e-10);
        self.check(&drift, "Jdot_qd", 1e-10);
    }

    fn check_derivatives(&mut self) {
        let (a, u) = (
            self.loaded.vars(&self.loaded.a),
            self.loaded.vars(&self.loaded.u),
        );
        let g = &mut self.loaded.graph;
        let inverse = self.mechanism.inverse_dynamics_derivatives(g, &a);
        let forward = self.mechanism.forward_dynamics_derivatives(g, &u);
        self.check(&inverse.position.concat(), "dtau_dq", 1e-8);
        self.check(&inverse.velocity.concat(), "dtau_dqd", 1e-8);
        self.check(&forward.position.concat(), "dqdd_dq", 1e-8);
        self.check(&forward.velocity.concat(), "dqdd_dqd", 1e-8);
        self.check(&forward.force.concat(), "Minv", 1e-10);
    }

    fn check_all(mut self) {
        self.check_derivatives();
        self.check_dynamics();
        self.check_kinematics();
    }
}

#[test]
fn iiwa() {
    if let Some(case) = case("iiwa", "iiwa", None) {
        case.check_all();
    }
}

#[test]
fn iiwa_snapped() {
    if let Some(case) = case("iiwa_snap", "iiwa", Some(1e-9)) {
        assert!(!case.mechanism.report().snapped.is_empty());
        case.check_all();
    }
}

#[test]
fn cartpole() {
    if let Some(case) = case("cartpole", "cartpole", None) {
        case.check_all();
    }
}

#[test]
fn double_pendulum() {
    if let Some(case) = case("double_pendulum", "double_pendulum", None) {
        case.check_all();
    }
}
