//! Free bodies whose velocities are their twists: against Pinocchio in its own convention
//! (`data/free_trees.py`), and against the form with seven rates.

use crate::random::{bodies_of, matrix, triple};
use crate::support::{Loaded, deviation, numbers};
use dynamics_codegen::graph::{ExprId, Graph, SymbolId};
use dynamics_codegen::tree::{
    Coordinate, Floating, Frame, Free, Joint, Layout, Mechanism, Options, Tree,
};
use serde_json::Value;

fn file() -> Value {
    serde_json::from_str(include_str!("../data/free_trees.json")).expect("valid")
}

fn length(tree: &Value, key: &str) -> usize {
    tree["states"][0][key].as_array().expect("a list").len()
}

/// The tree with a position per `q` and a velocity per `v` of the file.
fn load(tree: &Value) -> Loaded {
    let mut graph = Graph::new();
    let mut symbols = |kind: &str, key: &str| -> Vec<SymbolId> {
        let names = (0..length(tree, key)).map(|i| format!("{kind}{i}"));
        names.map(|name| graph.symbol(name)).collect()
    };
    let [q, v, a, u] = [("q", "q"), ("v", "v"), ("a", "v"), ("u", "v")].map(|(k, n)| symbols(k, n));
    let (mut position, mut velocity) = (0, 0);
    let joints = tree["bodies"]
        .as_array()
        .expect("bodies")
        .iter()
        .map(|body| {
            let axis = triple(&body["axis"]);
            let kind = body["kind"].as_str().expect("a kind");
            let coordinate = Coordinate {
                q: graph.var(q[position.min(q.len() - 1)]),
                v: graph.var(v[velocity.min(v.len() - 1)]),
                index: velocity,
                ratio: 1.0,
            };
            let (joint, [positions, velocities]) = match kind {
                "fixed" => (Joint::Fixed, [0, 0]),
                "revolute" => (Joint::Revolute { axis, coordinate }, [1, 1]),
                "prismatic" => (Joint::Prismatic { axis, coordinate }, [1, 1]),
                "floating" => {
                    let free = Free {
                        position: std::array::from_fn(|k| graph.var(q[position + k])),
                        quaternion: std::array::from_fn(|k| graph.var(q[position + 3 + k])),
                        twist: std::array::from_fn(|k| graph.var(v[velocity + k])),
                        indices: std::array::from_fn(|k| velocity + k),
                    };
                    (Joint::Free(free), [7, 6])
                }
                other => panic!("{other}"),
            };
            position += positions;
            velocity += velocities;
            joint
        });
    let joints: Vec<Joint> = joints.collect();
    let bodies = bodies_of(
        &mut graph,
        tree["bodies"].as_array().expect("bodies"),
        joints,
    );
    let gravity = triple(&tree["gravity"]).map(|x| graph.constant(x));
    Loaded {
        names: bodies.iter().map(|b| b.name.clone()).collect(),
        tree: Tree {
            coordinates: v.len(),
            bodies,
            gravity,
        },
        graph,
        q,
        v,
        a,
        u,
    }
}

struct Case<'a> {
    tree: &'a Value,
    loaded: Loaded,
    label: String,
}

impl Case<'_> {
    fn check(&self, outputs: &[ExprId], key: &str) {
        for state in self.tree["states"].as_array().expect("states") {
            let [q, v, a, u] = ["q", "v", "a", "u"].map(|name| numbers(&state[name]));
            let ours = self.loaded.evaluate(outputs, [&q, &v, &a, &u]);
            let gap = deviation(&ours, &numbers(&state[key]));
            assert!(gap < 1e-11, "{} {key}: {gap:e}", self.label);
        }
    }
}

fn check(tree: &Value, options: Options) {
    let mut loaded = load(tree);
    let (a, u) = (loaded.vars(&loaded.a), loaded.vars(&loaded.u));
    let v = loaded.vars(&loaded.v);
    let g = &mut loaded.graph;
    let mechanism = Mechanism::new(g, &loaded.tree, options).expect("a tree");
    let m = mechanism.mass_matrix(g).concat();
    let force = mechanism.bias_force(g);
    let bias: Vec<ExprId> = force.into_iter().map(|x| g.neg(x)).collect();
    let tau = mechanism.inverse_dynamics(g, &a);
    let forward = mechanism.forward_dynamics(g, &u);
    let inverse = mechanism.factor(g).inverse(g).concat();
    let slopes = mechanism.inverse_dynamics_derivatives(g, &a);
    let motion = mechanism.forward_dynamics_derivatives(g, &u);
    let frame = Frame {
        body: loaded.tree.bodies.len() - 1,
        rotation: matrix(&tree["tool"]["rotation"]),
        translation: triple(&tree["tool"]["translation"]).map(|x| g.constant(x)),
    };
    let pose = mechanism.pose(g, &frame);
    let jacobian = mechanism.jacobian(g, &frame);
    let velocity = mechanism.velocity(g, &frame);
    let drift = mechanism.jacobian_rate_times_velocity(g, &frame);
    let rate = mechanism.jacobian_rate(g, &frame);
    let rate_times_v: Vec<ExprId> = rate.iter().map(|row| g.inner_product(row, &v)).collect();
    let case = Case {
        tree,
        loaded,
        label: format!(
            "{} bodies, {options:?}",
            tree["bodies"].as_array().unwrap().len()
        ),
    };
    case.check(&m, "M");
    case.check(&bias, "bias");
    case.check(&tau, "tau");
    case.check(&forward, "qdd");
    case.check(&inverse, "Minv");
    case.check(&slopes.position.concat(), "dtau_dq");
    case.check(&slopes.velocity.concat(), "dtau_dv");
    case.check(&motion.acceleration, "qdd");
    case.check(&motion.position.concat(), "dqdd_dq");
    case.check(&motion.velocity.concat(), "dqdd_dv");
    case.check(&motion.force.concat(), "Minv");
    case.check(&pose.position, "position");
    case.check(&pose.rotation.concat(), "R");
    case.check(&jacobian.concat(), "J");
    case.check(&velocity, "velocity");
    case.check(&drift, "Jdot_v");
    case.check(&rate_times_v, "Jdot_v");
}

#[test]
fn free_trees_agree_with_pinocchio() {
    for tree in file()["trees"].as_array().expect("trees") {
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

/// `2 E(η)`: the angular velocity in the body's frame is `2 E η̇`.
fn map([x, y, z, w]: [f64; 4]) -> [[f64; 4]; 3] {
    [[w, z, -y, -x], [-z, w, x, -y], [y, -x, w, -z]].map(|row| row.map(|x| 2.0 * x))
}

/// With `T` the map from seven rates to the twist, `M₇ = Tᵀ M₆ T` but along the quaternion, and
/// both accelerate alike.
#[test]
fn twists_are_the_seven_rates_by_another_name() {
    let file = file();
    let tree = &file["trees"][1];
    let mut six = load(tree);
    let g = &mut six.graph;
    let mechanism = Mechanism::new(g, &six.tree, Options::default()).expect("a tree");
    let m_six = mechanism.mass_matrix(g).concat();
    // The same tree with a coordinate for every rate.
    let mut seven = load(tree);
    let count = seven.q.len();
    let rates: Vec<SymbolId> = (0..count)
        .map(|i| seven.graph.symbol(format!("rate{i}")))
        .collect();
    let coordinate = |index: usize| Coordinate {
        q: seven.graph.var(seven.q[index]),
        v: seven.graph.var(rates[index]),
        index,
        ratio: 1.0,
    };
    for body in &mut seven.tree.bodies {
        match &mut body.joint {
            joint @ Joint::Free(_) => {
                *joint = Joint::Floating(Floating {
                    position: std::array::from_fn(coordinate),
                    quaternion: std::array::from_fn(|k| coordinate(3 + k)),
                });
            }
            Joint::Revolute {
                coordinate: own, ..
            }
            | Joint::Prismatic {
                coordinate: own, ..
            } => {
                *own = coordinate(own.index + 1);
            }
            _ => {}
        }
    }
    seven.tree.coordinates = count;
    let g = &mut seven.graph;
    let mechanism = Mechanism::new(g, &seven.tree, Options::default()).expect("a tree");
    let m_seven = mechanism.mass_matrix(g).concat();
    for state in tree["states"].as_array().expect("states") {
        let q = numbers(&state["q"]);
        let n = count - 1;
        let (m, m_seven) = (
            six.evaluate(&m_six, [&q, &[], &[], &[]]),
            seven.evaluate(&m_seven, [&q, &[], &[], &[]]),
        );
        let rotation = rotation_of([q[3], q[4], q[5], q[6]]);
        let turn = map([q[3], q[4], q[5], q[6]]);
        let t = |row: usize, column: usize| -> f64 {
            match (row, column) {
                (0..=2, 0..=2) => rotation[column][row],
                (3..=5, 3..=6) => turn[row - 3][column - 3],
                (6.., 7..) => f64::from(u8::from(row + 1 == column)),
                _ => 0.0,
            }
        };
        for i in 0..count {
            for j in 0..count {
                let mut expected = 0.0;
                for k in 0..n {
                    for l in 0..n {
                        expected += t(k, i) * m[k * n + l] * t(l, j);
                    }
                }
                // Along the quaternion the seven rates have inertia of their own.
                let mut found = m_seven[i * count + j];
                if (3..7).contains(&i) && (3..7).contains(&j) {
                    let along: f64 = (3..7)
                        .flat_map(|a| (3..7).map(move |b| (a, b)))
                        .map(|(a, b)| q[a] * m_seven[a * count + b] * q[b])
                        .sum();
                    found -= along * q[i] * q[j];
                }
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{i} {j}: {found} {expected}"
                );
            }
        }
    }
}

/// The rotation of a unit quaternion.
fn rotation_of([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    [
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
    ]
}
