//! Operation counts, each shared subexpression once: the goals are figures of
//! published tools after the same elimination.

use crate::support::{Loaded, load};
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::tree::{Frame, Layout, Mechanism, Options};

struct Counted {
    loaded: Loaded,
    mechanism: Mechanism,
}

impl Counted {
    fn new(path: &str, layout: Layout) -> Option<Self> {
        let robot = urdf_rs::read_file(left_out::shared(path)?).expect("a robot");
        let mut loaded = load(&robot, None);
        let options = Options {
            layout,
            ..Options::default()
        };
        let mechanism = Mechanism::new(&mut loaded.graph, &loaded.tree, options).expect("a tree");
        Some(Self { loaded, mechanism })
    }

    fn count(&self, name: &str, outputs: &[ExprId], limit: usize) {
        // As they are emitted.
        let mut graph = self.loaded.graph.clone();
        let outputs = graph.settle_signs(outputs, |_| false);
        let count = graph.operation_count(&outputs);
        println!("{name}: {count} (at most {limit})");
        assert!(count <= limit, "{name}: {count} > {limit}");
    }

    /// Mass matrix, bias force, both, forward dynamics, and the derivatives of
    /// inverse and forward dynamics.
    fn check(&mut self, limits: [usize; 6]) {
        let (a, u) = (
            self.loaded.vars(&self.loaded.a),
            self.loaded.vars(&self.loaded.u),
        );
        let g = &mut self.loaded.graph;
        let m = self.mechanism.mass_matrix(g).concat();
        let bias = self.mechanism.bias_force(g);
        let both = [m.clone(), self.mechanism.bias_force_beside_mass(g)].concat();
        let forward = self.mechanism.forward_dynamics(g, &u);
        let slopes = self.mechanism.inverse_dynamics_derivatives(g, &a);
        let inverse_slopes = [slopes.position.concat(), slopes.velocity.concat()].concat();
        let slopes = self.mechanism.forward_dynamics_derivatives(g, &u);
        let forward_slopes = [
            slopes.position.concat(),
            slopes.velocity.concat(),
            slopes.force.concat(),
        ]
        .concat();
        self.count("mass matrix", &m, limits[0]);
        self.count("bias force", &bias, limits[1]);
        self.count("both", &both, limits[2]);
        self.count("forward dynamics", &forward, limits[3]);
        self.count(
            "derivatives of inverse dynamics",
            &inverse_slopes,
            limits[4],
        );
        self.count(
            "derivatives of forward dynamics",
            &forward_slopes,
            limits[5],
        );
    }
}

/// The figures reached; the goals were 285, 450, 720, 950, 3500 and 5500.
#[test]
fn iiwa() {
    let Some(mut c) = Counted::new("oracles/iiwa.urdf", Layout::Cheapest) else {
        return;
    };
    c.check([212, 368, 555, 770, 1842, 3662]);
    let body = c.loaded.body("lbr_iiwa_link_7");
    let u = c.loaded.vars(&c.loaded.u);
    let g = &mut c.loaded.graph;
    let frame = Frame::of_body(g, body);
    let jacobian = c.mechanism.jacobian(g, &frame);
    let rate = c.mechanism.jacobian_rate(g, &frame).concat();
    let drift = c.mechanism.jacobian_rate_times_velocity(g, &frame);
    let bias = g.neg(drift[2]);
    let contact = c
        .mechanism
        .constrained_forward_dynamics(g, &u, &[jacobian[2].clone()], &[bias]);
    let jacobian = jacobian.concat();
    c.count("Jacobian", &jacobian, 143);
    c.count(
        "Jacobian and its rate",
        &[jacobian.clone(), rate].concat(),
        359,
    );
    let contact = [contact.acceleration, contact.multipliers].concat();
    c.count("forward dynamics with one contact normal", &contact, 1017);
}

/// Nine joints; the goals were 638, 822, 1444, 1869 and 8000, and the peers'
/// derivative of the forward dynamics 13662.
#[test]
fn panda() {
    let Some(mut c) = Counted::new("data/urdf/panda.urdf", Layout::Cheapest) else {
        return;
    };
    c.check([425, 623, 934, 1289, 3355, 6636]);
}

/// Three of its joints are parallel, and are passed by the sum of their angles: one by one, mass matrix
/// and bias force took 145 and 252.
#[test]
fn ur5() {
    let Some(mut c) = Counted::new("data/urdf/ur5_robot.urdf", Layout::Cheapest) else {
        return;
    };
    c.check([102, 207, 280, 501, 1177, 2221]);
}

/// Each of the three measures pays, on its own.
#[test]
fn every_measure_saves_operations() {
    let Some(path) = left_out::shared("oracles/iiwa.urdf") else {
        return;
    };
    let robot = urdf_rs::read_file(path).expect("a robot");
    let count = |options: Options| {
        let mut loaded = load(&robot, None);
        let g = &mut loaded.graph;
        let mechanism = Mechanism::new(g, &loaded.tree, options).expect("a tree");
        let bias = mechanism.bias_force(g);
        g.operation_count(&bias)
    };
    let all = Options::default();
    let best = count(all);
    assert!(best < count(Options { snap: None, ..all }));
    assert!(
        best < count(Options {
            regroup: false,
            ..all
        })
    );
    assert!(
        best < count(Options {
            layout: Layout::AsGiven,
            ..all
        })
    );
}
