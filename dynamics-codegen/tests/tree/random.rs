//! Trees with branches, general axes, and planar and floating roots, against
//! Pinocchio (`data/random_trees.py`), in every layout, regrouped or not.

use crate::support::{Loaded, deviation, numbers, symbols};
use dynamics_codegen::graph::{ExprId, Graph};
use dynamics_codegen::tree::{
    Body, Coordinate, Floating, Frame, Inertia, Joint, Layout, Mechanism, Options, Placement, Tree,
};
use serde_json::Value;

pub fn triple(value: &Value) -> [f64; 3] {
    numbers(value).try_into().expect("three numbers")
}

pub fn matrix(value: &Value) -> [[f64; 3]; 3] {
    let rows = value.as_array().expect("rows");
    std::array::from_fn(|i| triple(&rows[i]))
}

/// The listed bodies, each on its joint.
pub fn bodies_of(graph: &mut Graph, bodies: &[Value], joints: Vec<Joint>) -> Vec<Body> {
    (bodies.iter().zip(joints).enumerate())
        .map(|(i, (body, joint))| Body {
            name: format!("body{i}"),
            parent: body["parent"].as_u64().map(|p| p as usize),
            placement: Placement {
                rotation: matrix(&body["rotation"]),
                translation: triple(&body["translation"]).map(|x| graph.constant(x)),
            },
            joint,
            inertia: Inertia {
                mass: graph.constant(body["mass"].as_f64().expect("a number")),
                center: triple(&body["center"]).map(|x| graph.constant(x)),
                tensor: matrix(&body["tensor"]).map(|row| row.map(|x| graph.constant(x))),
            },
        })
        .collect()
}

fn load(tree: &Value) -> Loaded {
    let size = tree["states"][0]["q"].as_array().expect("a list").len();
    let mut graph = Graph::new();
    let [q, v, a, u] = symbols(&mut graph, size);
    let mut next = 0;
    let mut coordinate = || {
        next += 1;
        let index = next - 1;
        let (q, v) = (graph.var(q[index]), graph.var(v[index]));
        Coordinate {
            q,
            v,
            index,
            ratio: 1.0,
        }
    };
    let bodies = tree["bodies"].as_array().expect("bodies");
    let mut joints = Vec::new();
    for body in bodies {
        let axis = triple(&body["axis"]);
        joints.push(match body["kind"].as_str().expect("a kind") {
            "fixed" => Joint::Fixed,
            "revolute" => Joint::Revolute {
                axis,
                coordinate: coordinate(),
            },
            "prismatic" => Joint::Prismatic {
                axis,
                coordinate: coordinate(),
            },
            "planar" => Joint::Planar {
                normal: [0.0, 0.0, 1.0],
                coordinates: std::array::from_fn(|_| coordinate()),
            },
            "floating" => Joint::Floating(Floating {
                position: std::array::from_fn(|_| coordinate()),
                quaternion: std::array::from_fn(|_| coordinate()),
            }),
            other => panic!("{other}"),
        });
    }
    let bodies = bodies_of(&mut graph, bodies, joints);
    let tree = Tree {
        gravity: triple(&tree["gravity"]).map(|x| graph.constant(x)),
        coordinates: size,
        bodies,
    };
    let names = tree.bodies.iter().map(|b| b.name.clone()).collect();
    Loaded {
        graph,
        tree,
        q,
        v,
        a,
        u,
        names,
    }
}

struct Case<'a> {
    tree: &'a Value,
    loaded: Loaded,
    label: String,
}

impl Case<'_> {
    fn compare(
        &self,
        outputs: &[ExprId],
        key: &str,
        tolerance: f64,
        adjust: impl Fn(&Value, &mut [f64]),
    ) {
        for state in self.tree["states"].as_array().expect("states") {
            let [q, v, a, u] = ["q", "v", "a", "u"].map(|name| numbers(&state[name]));
            let mut ours = self.loaded.evaluate(outputs, [&q, &v, &a, &u]);
            adjust(state, &mut ours);
            let gap = deviation(&ours, &numbers(&state[key]));
            assert!(gap < tolerance, "{} {key}: {gap:e}", self.label);
        }
    }

    fn check(&self, outputs: &[ExprId], key: &str, tolerance: f64) {
        self.compare(outputs, key, tolerance, |_, _| {});
    }
}

/// Takes the part along the quaternion (columns 3 to 6) out of rows of `size`.
fn project(q: &[f64], row: &mut [f64]) {
    let along: f64 = (3..7).map(|i| q[i] * row[i]).sum();
    for i in 3..7 {
        row[i] -= along * q[i];
    }
}

fn check(tree: &Value, options: Options) {
    let mut loaded = load(tree);
    let (a, u) = (loaded.vars(&loaded.a), loaded.vars(&loaded.u));
    let g = &mut loaded.graph;
    let mechanism = Mechanism::new(g, &loaded.tree, options).expect("a tree");
    let floating = mechanism.is_floating();
    let m = mechanism.mass_matrix(g).concat();
    let bias: Vec<ExprId> = mechanism
        .bias_force(g)
        .into_iter()
        .map(|x| g.neg(x))
        .collect();
    let inverse = mechanism.inverse_dynamics(g, &a);
    let forward = mechanism.forward_dynamics(g, &u);
    let frame = Frame {
        body: loaded.tree.bodies.len() - 1,
        rotation: matrix(&tree["tool"]["rotation"]),
        translation: triple(&tree["tool"]["translation"]).map(|x| g.constant(x)),
    };
    let pose = mechanism.pose(g, &frame);
    let jacobian = mechanism.jacobian(g, &frame).concat();
    let drift = mechanism.jacobian_rate_times_velocity(g, &frame);
    let rate = mechanism.jacobian_rate(g, &frame);
    let v: Vec<ExprId> = loaded.v.iter().map(|&s| g.var(s)).collect();
    let rate_times_v: Vec<ExprId> = rate.iter().map(|row| g.inner_product(row, &v)).collect();
    let slopes = mechanism.inverse_dynamics_derivatives(g, &a);
    let forward_slopes = mechanism.forward_dynamics_derivatives(g, &u);
    let case = Case {
        tree,
        loaded,
        label: format!("{} {options:?}", tree["root"]),
    };
    let size = a.len();
    case.compare(&m, "M", 1e-10, |state, m| {
        if floating {
            // What stands along the quaternion is ours to choose.
            let q = numbers(&state["q"]);
            let mut moved = vec![0.0; size];
            for row in 0..size {
                let along: f64 = (3..7).map(|j| m[row * size + j] * q[j]).sum();
                moved[row] = along;
                project(&q, &mut m[row * size..(row + 1) * size]);
            }
            let kappa: f64 = (3..7).map(|i| q[i] * moved[i]).sum();
            assert!(kappa > 0.0);
            for row in 0..size {
                let expected = if (3..7).contains(&row) {
                    kappa * q[row]
                } else {
                    0.0
                };
                assert!((moved[row] - expected).abs() < 1e-12 * kappa.max(1.0));
            }
        }
    });
    case.check(&bias, "bias", 1e-10);
    case.check(&inverse, "tau", 1e-10);
    case.check(&forward, "qdd", 1e-10);
    case.check(&forward_slopes.acceleration, "qdd", 1e-10);
    case.check(&pose.position, "position", 1e-10);
    case.check(&pose.rotation.concat(), "R", 1e-10);
    case.check(&jacobian, "J", 1e-10);
    case.check(&drift, "Jdot_v", 1e-10);
    case.check(&rate_times_v, "Jdot_v", 1e-10);
    if tree["states"][0].get("dtau_dq").is_some() {
        case.check(&slopes.position.concat(), "dtau_dq", 1e-8);
        case.check(&slopes.velocity.concat(), "dtau_dv", 1e-8);
        case.check(&forward_slopes.position.concat(), "dqdd_dq", 1e-8);
        case.check(&forward_slopes.velocity.concat(), "dqdd_dv", 1e-8);
    }
    derivatives_match_graph(case, inverse, forward, slopes, forward_slopes);
}

/// The recursive derivatives against forward mode through the functions.
fn derivatives_match_graph(
    mut case: Case<'_>,
    inverse: Vec<ExprId>,
    forward: Vec<ExprId>,
    slopes: dynamics_codegen::tree::InverseDerivatives,
    forward_slopes: dynamics_codegen::tree::ForwardDerivatives,
) {
    let (q, v, u) = (
        case.loaded.q.clone(),
        case.loaded.v.clone(),
        case.loaded.u.clone(),
    );
    let u_symbols = u.clone();
    let pairs = [
        (slopes.position, &inverse, &q),
        (slopes.velocity, &inverse, &v),
        (forward_slopes.position, &forward, &q),
        (forward_slopes.velocity, &forward, &v),
        (forward_slopes.force, &forward, &u),
    ];
    for (ours, function, symbols) in pairs {
        let direct = case.loaded.graph.jacobian(function, symbols).concat();
        let ours = ours.concat();
        for state in case.tree["states"].as_array().expect("states") {
            let [q, v, a, u] = ["q", "v", "a", "u"].map(|name| numbers(&state[name]));
            let blocks: [&[f64]; 4] = [&q, &v, &a, &u];
            let mut ours = case.loaded.evaluate(&ours, blocks);
            let mut direct = case.loaded.evaluate(&direct, blocks);
            if case.tree["root"] == "floating" && *symbols != u_symbols {
                // Off the unit sphere the functions are continued differently.
                for row in ours.chunks_mut(q.len()).chain(direct.chunks_mut(q.len())) {
                    project(&q, row);
                }
            }
            let gap = deviation(&ours, &direct);
            assert!(gap < 1e-10, "{}: {gap:e}", case.label);
        }
    }
}

#[test]
fn random_trees_agree_with_pinocchio() {
    let file: Value =
        serde_json::from_str(include_str!("../data/random_trees.json")).expect("valid");
    for tree in file["trees"].as_array().expect("trees") {
        for layout in [Layout::AsGiven, Layout::Distal, Layout::Proximal] {
            for regroup in [false, true] {
                check(
                    tree,
                    Options {
                        snap: None,
                        regroup,
                        layout,
                    },
                );
            }
        }
    }
}
