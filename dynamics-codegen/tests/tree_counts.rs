//! Operation counts, each shared subexpression once: the goals are figures of
//! published tools after the same elimination.

mod support;

use dynamics_codegen::graph::ExprId;
use dynamics_codegen::tree::{Frame, Layout, Mechanism, Options};
use support::{Loaded, load, shared};

struct Counted {
    loaded: Loaded,
    mechanism: Mechanism,
}

impl Counted {
    fn new(path: &str, layout: Layout) -> Option<Self> {
        let robot = urdf_rs::read_file(shared(path)?).expect("a robot");
        let mut loaded = load(&robot, None);
        let options = Options {
            layout,
            ..Options::default()
        };
        let mechanism = Mechanism::new(&mut loaded.graph, &loaded.tree, options).expect("a tree");
        Some(Self { loaded, mechanism })
    }

    fn count(&mut self, name: &str, outputs: &[ExprId]) -> usize {
        let count = self.loaded.graph.operation_count(outputs);
        println!("{name}: {count}");
        count
    }

    fn dynamics(&mut self) -> [usize; 4] {
        println!("{:?}", self.mechanism.report().layout);
        let u = self.loaded.vars(&self.loaded.u);
        let g = &mut self.loaded.graph;
        let m = self.mechanism.mass_matrix(g).concat();
        let bias = self.mechanism.bias_force(g);
        let a = self.loaded.vars(&self.loaded.a);
        let g = &mut self.loaded.graph;
        let d = self.mechanism.inverse_dynamics_derivatives(g, &a);
        let dn = [d.position.concat(), d.velocity.concat()].concat();
        println!("d id {}", g.operation_count(&dn));
        let d = self.mechanism.forward_dynamics_derivatives(g, &u);
        let dn = [d.position.concat(), d.velocity.concat(), d.force.concat()].concat();
        println!("d fd {}", g.operation_count(&dn));
        let forward = self.mechanism.forward_dynamics(g, &u);
        let both = [m.clone(), bias.clone()].concat();
        [
            self.count("mass matrix", &m),
            self.count("bias force", &bias),
            self.count("both", &both),
            self.count("forward dynamics", &forward),
        ]
    }
}

#[test]
fn iiwa() {
    for layout in [Layout::Distal, Layout::Proximal, Layout::AsGiven, Layout::Cheapest] {
        let Some(mut c) = Counted::new("oracles/iiwa.urdf", layout) else { return };
        c.dynamics();
        let body = c.loaded.body("lbr_iiwa_link_7");
        let g = &mut c.loaded.graph;
        let frame = Frame::of_body(g, body);
        let j = c.mechanism.jacobian(g, &frame).concat();
        let jd = c.mechanism.jacobian_rate(g, &frame).concat();
        c.count("J", &j);
        c.count("J and Jdot", &[j.clone(), jd].concat());
    }
}
#[test]
fn panda() {
    for layout in [Layout::Distal, Layout::Proximal, Layout::AsGiven, Layout::Cheapest] {
        let Some(mut c) = Counted::new("data/urdf/panda.urdf", layout) else { return };
        c.dynamics();
    }
}
