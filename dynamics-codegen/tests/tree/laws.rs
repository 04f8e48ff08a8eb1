//! Laws that hold for any tree, and what its description may not contain.

use crate::support::{self, deviation, load, multiply, rotation};
use dynamics_codegen::graph::{ExprId, Graph, SymbolId};
use dynamics_codegen::tree::{
    Body, Coordinate, Floating, Frame, Inertia, Joint, Layout, Mechanism, Options, Placement, Tree,
    TreeError,
};
use proptest::prelude::*;

/// A tree with its symbols; `values` holds what is not `q`, `v`, `a`.
struct Sample {
    graph: Graph,
    tree: Tree,
    q: Vec<SymbolId>,
    v: Vec<SymbolId>,
    a: Vec<SymbolId>,
    parameters: Vec<(SymbolId, f64)>,
}

impl Sample {
    fn evaluate(&self, outputs: &[ExprId], blocks: [&[f64]; 3]) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.graph.symbol_count()];
        for (symbols, block) in [&self.q, &self.v, &self.a].into_iter().zip(blocks) {
            for (symbol, &value) in symbols.iter().zip(block) {
                values[symbol.index()] = value;
            }
        }
        for &(symbol, value) in &self.parameters {
            values[symbol.index()] = value;
        }
        self.graph.evaluate(outputs, &values)
    }
}

/// An arm with a gripper whose second finger mimics the first, a link whose
/// mass is a parameter, and a link length that is one: nothing may be folded
/// that is not constant.
fn gripper(constant: bool) -> Sample {
    let mut g = Graph::new();
    let [q, v, a, _] = support::symbols(&mut g, 3);
    let mass = g.symbol("payload");
    let length = g.symbol("length");
    let value = |g: &mut Graph, symbol: SymbolId, number: f64| {
        if constant {
            g.constant(number)
        } else {
            g.var(symbol)
        }
    };
    let (payload, reach) = (value(&mut g, mass, 0.7), value(&mut g, length, 0.45));
    let coordinate = |g: &mut Graph, index: usize, ratio: f64, offset: f64| {
        let moved = g.var(q[index]);
        let (moved, offset) = (g.scale(ratio, moved), g.constant(offset));
        let rate = g.var(v[index]);
        Coordinate {
            q: g.add(moved, offset),
            v: g.scale(ratio, rate),
            index,
            ratio,
        }
    };
    let joints = [
        Joint::Revolute {
            axis: [0.0, 0.0, 2.0],
            coordinate: coordinate(&mut g, 0, 1.0, 0.0),
        },
        Joint::Revolute {
            axis: [0.0, 1.0, 1.0],
            coordinate: coordinate(&mut g, 1, 1.0, 0.0),
        },
        Joint::Prismatic {
            axis: [1.0, 0.0, 0.0],
            coordinate: coordinate(&mut g, 2, 1.0, 0.0),
        },
        Joint::Prismatic {
            axis: [0.0, 1.0, 0.0],
            coordinate: coordinate(&mut g, 2, -0.6, 0.02),
        },
    ];
    let parents = [None, Some(0), Some(1), Some(1)];
    let bodies = joints
        .into_iter()
        .zip(parents)
        .enumerate()
        .map(|(i, (joint, parent))| {
            let i = i as f64;
            let zero = g.zero();
            let translation = [
                if i == 1.0 { reach } else { zero },
                zero,
                g.constant(0.1 * i),
            ];
            Body {
                name: format!("link {i}"),
                parent,
                placement: Placement {
                    rotation: rotation([0.3 * i, -0.2, 0.5 * i]),
                    translation,
                },
                joint,
                inertia: Inertia {
                    mass: if i == 1.0 {
                        payload
                    } else {
                        g.constant(1.0 + i)
                    },
                    center: [0.02, -0.03 * i, 0.05].map(|x| g.constant(x)),
                    tensor: [
                        [0.03, 0.001, 0.002],
                        [0.001, 0.04, -0.003],
                        [0.002, -0.003, 0.05],
                    ]
                    .map(|row| row.map(|x| g.constant(x))),
                },
            }
        });
    let bodies = bodies.collect();
    let gravity = [0.4, -0.2, -9.81].map(|x| g.constant(x));
    Sample {
        tree: Tree {
            bodies,
            gravity,
            coordinates: 3,
        },
        graph: g,
        q,
        v,
        a,
        parameters: vec![(mass, 0.7), (length, 0.45)],
    }
}

fn iiwa() -> Option<Sample> {
    let robot = urdf_rs::read_file(left_out::shared("oracles/iiwa.urdf")?).expect("a robot");
    let loaded = load(&robot, None);
    Some(Sample {
        graph: loaded.graph,
        tree: loaded.tree,
        q: loaded.q,
        v: loaded.v,
        a: loaded.a,
        parameters: Vec::new(),
    })
}

/// Mass matrix, bias force and derivatives as Lagrange's equations give them
/// from the energies, against the recursions.
fn check_laws(mut sample: Sample, states: &[[Vec<f64>; 3]]) {
    let g = &mut sample.graph;
    let mechanism = Mechanism::new(g, &sample.tree, Options::default()).expect("a tree");
    let (q, v, a) = (sample.q.clone(), sample.v.clone(), sample.a.clone());
    let vars = |g: &Graph, s: &[SymbolId]| s.iter().map(|&s| g.var(s)).collect::<Vec<_>>();
    let (rates, accelerations) = (vars(g, &v), vars(g, &a));
    let matrix = mechanism.mass_matrix(g);
    for (i, row) in matrix.iter().enumerate() {
        for (j, &entry) in row.iter().enumerate() {
            assert_eq!(entry, matrix[j][i], "symmetric node by node");
        }
    }
    let bias = mechanism.bias_force(g);
    let needed = mechanism.inverse_dynamics(g, &accelerations);
    let sum: Vec<ExprId> = (matrix.iter().zip(&bias))
        .map(|(row, &bias)| {
            let inertial = g.inner_product(row, &accelerations);
            g.sub(inertial, bias)
        })
        .collect();
    let kinetic = mechanism.kinetic_energy(g);
    let potential = mechanism.potential_energy(g);
    let momenta: Vec<ExprId> = v.iter().map(|&s| g.derivatives(&[kinetic], s)[0]).collect();
    let from_energy = g.jacobian(&momenta, &v);
    let mut seeds: Vec<(SymbolId, ExprId)> = q.iter().copied().zip(rates.clone()).collect();
    seeds.extend(v.iter().copied().zip(accelerations.clone()));
    let momentum_rates = g.directional(&momenta, &seeds);
    let lagrange: Vec<ExprId> = (q.iter().zip(momentum_rates))
        .map(|(&s, rate)| {
            let slopes = g.derivatives(&[kinetic, potential], s);
            let less = g.sub(rate, slopes[0]);
            g.add(less, slopes[1])
        })
        .collect();
    let energy = g.add(kinetic, potential);
    let energy_rate = g.directional(&[energy], &seeds)[0];
    let power = g.inner_product(&rates, &needed);
    let slopes = mechanism.inverse_dynamics_derivatives(g, &accelerations);
    let by_graph = [
        g.jacobian(&needed, &q).concat(),
        g.jacobian(&needed, &v).concat(),
    ]
    .concat();
    let by_recursion = [slopes.position.concat(), slopes.velocity.concat()].concat();
    let size = q.len();
    for [q, v, a] in states {
        let at = |outputs: &[ExprId]| sample.evaluate(outputs, [q, v, a]);
        let inertia = at(&matrix.concat());
        assert!(deviation(&inertia, &at(&from_energy.concat())) < 1e-12);
        assert!(positive_definite(&inertia, size));
        assert!(deviation(&at(&needed), &at(&sum)) < 1e-12);
        assert!(deviation(&at(&needed), &at(&lagrange)) < 1e-12);
        assert!(deviation(&at(&by_recursion), &at(&by_graph)) < 1e-11);
        let (rate, power) = (at(&[energy_rate])[0], at(&[power])[0]);
        assert!(
            (rate - power).abs() < 1e-11 * (1.0 + power.abs()),
            "{rate} {power}"
        );
    }
}

/// By Gaussian elimination: all pivots positive.
fn positive_definite(matrix: &[f64], size: usize) -> bool {
    let mut m = matrix.to_vec();
    for k in 0..size {
        if m[k * size + k] <= 0.0 {
            return false;
        }
        for i in k + 1..size {
            let factor = m[i * size + k] / m[k * size + k];
            for j in k..size {
                m[i * size + j] -= factor * m[k * size + j];
            }
        }
    }
    true
}

fn states(size: usize) -> impl Strategy<Value = Vec<[Vec<f64>; 3]>> {
    let block = move || prop::collection::vec(-2.0..2.0f64, size);
    prop::collection::vec(
        (block(), block(), block()).prop_map(|(q, v, a)| [q, v, a]),
        8,
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2) })]

    #[test]
    fn recursions_obey_lagrange_and_keep_energy(three in states(3), seven in states(7)) {
        check_laws(gripper(false), &three);
        check_laws(gripper(true), &three);
        if let Some(sample) = iiwa() {
            check_laws(sample, &seven);
        }
    }
}

#[test]
fn constants_and_parameters_give_the_same_forces() {
    let mut results = Vec::new();
    for constant in [true, false] {
        let mut sample = gripper(constant);
        let g = &mut sample.graph;
        let mechanism = Mechanism::new(g, &sample.tree, Options::default()).expect("a tree");
        let a: Vec<ExprId> = sample.a.iter().map(|&s| g.var(s)).collect();
        let needed = mechanism.inverse_dynamics(g, &a);
        results.push(sample.evaluate(
            &needed,
            [&[0.3, 1.0, 0.1], &[1.0, -2.0, 0.5], &[2.0, 1.0, -1.0]],
        ));
    }
    assert!(deviation(&results[0], &results[1]) < 1e-14);
}

/// The accelerations obey the rows, and the multipliers are the forces that
/// the unconstrained equation lacks.
#[test]
fn constrained_accelerations_obey_the_rows() {
    let Some(mut sample) = iiwa() else { return };
    let g = &mut sample.graph;
    let mechanism = Mechanism::new(g, &sample.tree, Options::default()).expect("a tree");
    let force: Vec<ExprId> = (0..7).map(|i| g.constant(f64::from(i) - 2.0)).collect();
    let frame = Frame::of_body(g, sample.tree.bodies.len() - 1);
    let jacobian = mechanism.jacobian(g, &frame);
    let rows = vec![jacobian[2].clone(), jacobian[0].clone()];
    let bias = vec![g.constant(0.4), g.constant(-0.3)];
    let solution = mechanism.constrained_forward_dynamics(g, &force, &rows, &bias);
    let needed = mechanism.inverse_dynamics(g, &solution.acceleration);
    let mut outputs: Vec<ExprId> = Vec::new();
    for i in 0..7 {
        let column: Vec<ExprId> = rows.iter().map(|row| row[i]).collect();
        let push = g.inner_product(&column, &solution.multipliers);
        let applied = g.add(force[i], push);
        outputs.push(g.sub(needed[i], applied));
    }
    for (row, &b) in rows.iter().zip(&bias) {
        let demanded = g.inner_product(row, &solution.acceleration);
        outputs.push(g.sub(demanded, b));
    }
    outputs.extend(&solution.multipliers);
    let q = [0.3, -0.7, 1.1, 0.9, -0.2, 0.8, 0.5];
    let values = sample.evaluate(&outputs, [&q, &[0.4; 7], &[0.0; 7]]);
    assert!(values[..9].iter().all(|x| x.abs() < 1e-10), "{values:?}");
    assert!(values[9..].iter().all(|x| x.abs() > 1e-3), "{values:?}");
}

/// At rest a floating body is where its placement says, also behind a joint: the whole
/// constant rotation stands in front of its quaternion.
#[test]
fn a_body_floats_from_its_placement() {
    let mut sample = gripper(true);
    let g = &mut sample.graph;
    let [q, v, _, _] = support::symbols(g, 10);
    let coordinate = |g: &Graph, index: usize| Coordinate {
        q: g.var(q[index]),
        v: g.var(v[index]),
        index,
        ratio: 1.0,
    };
    sample.tree.bodies.truncate(2);
    sample.tree.coordinates = 9;
    for (index, body) in sample.tree.bodies.iter_mut().enumerate() {
        if let Joint::Revolute { coordinate: c, .. } = &mut body.joint {
            *c = coordinate(g, index);
        }
    }
    sample.tree.bodies.push(Body {
        name: "afloat".to_string(),
        parent: Some(1),
        placement: Placement {
            rotation: rotation([0.4, -0.6, 1.2]),
            translation: [0.1, 0.2, -0.3].map(|x| g.constant(x)),
        },
        joint: Joint::Floating(Floating {
            position: [2, 3, 4].map(|index| coordinate(g, index)),
            quaternion: [5, 6, 7, 8].map(|index| coordinate(g, index)),
        }),
        inertia: sample.tree.bodies[0].inertia,
    });
    sample.q = q[..9].to_vec();
    let expected = sample
        .tree
        .bodies
        .iter()
        .fold(rotation([0.0; 3]), |turned, body| {
            multiply(&turned, &body.placement.rotation)
        });
    let at_rest = [[0.0; 8].as_slice(), &[1.0]].concat();
    for layout in [Layout::Distal, Layout::Proximal, Layout::AsGiven] {
        let g = &mut sample.graph;
        let options = Options {
            layout,
            ..Options::default()
        };
        let mechanism = Mechanism::new(g, &sample.tree, options).expect("a tree");
        let frame = Frame::of_body(g, 2);
        let pose = mechanism.pose(g, &frame);
        let found = sample.evaluate(&pose.rotation.concat(), [&at_rest, &[], &[]]);
        assert!(
            deviation(&found, &expected.concat()) < 1e-12,
            "{layout:?}: {found:?}"
        );
    }
}

#[test]
fn a_tree_that_is_none_is_refused() {
    let refuse = |change: fn(&mut Sample)| {
        let mut sample = gripper(true);
        change(&mut sample);
        Mechanism::new(&mut sample.graph, &sample.tree, Options::default()).expect_err("refused")
    };
    assert!(matches!(
        refuse(|s| s.tree.bodies[0].parent = Some(0)),
        TreeError::Order { .. }
    ));
    assert!(matches!(
        refuse(|s| s.tree.coordinates = 2),
        TreeError::Coordinate { index: 2, .. }
    ));
    let skewed = |s: &mut Sample| s.tree.bodies[1].placement.rotation[0][0] += 0.1;
    assert!(matches!(refuse(skewed), TreeError::Rotation { .. }));
    let mirrored = |s: &mut Sample| {
        s.tree.bodies[1].placement.rotation = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    };
    assert!(matches!(refuse(mirrored), TreeError::Rotation { .. }));
    let lost = |s: &mut Sample| {
        if let Joint::Revolute { axis, .. } = &mut s.tree.bodies[1].joint {
            *axis = [0.0; 3];
        }
    };
    assert!(matches!(refuse(lost), TreeError::Axis { .. }));
    let heavy = |s: &mut Sample| s.tree.bodies[1].inertia.mass = s.graph.constant(f64::NAN);
    let error = refuse(heavy);
    assert!(
        matches!(error, TreeError::NotFinite { what: "mass", .. }),
        "{error}"
    );
    let error = refuse(|s| s.tree.coordinates = 10_000);
    assert!(
        matches!(
            error,
            TreeError::TooLarge {
                coordinates: 10_000,
                ..
            }
        ),
        "{error}"
    );
}
