//! A floating base: derivatives by recursion are those of the expressions, also where the stated
//! acceleration does not keep the quaternion a unit, and along the quaternion itself.

use dynamics_codegen::derive::{Expansion, Group, Item, Term};
use dynamics_codegen::graph::{ExprId, SymbolId};
use dynamics_codegen::{Library, compile};

const ARM: &str = r#"<robot name="arm">
  <link name="base"><inertial><origin xyz="0.1 0.2 -0.1"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0.01" ixz="0.02" iyy="0.2" iyz="0.01" izz="0.15"/></inertial></link>
  <link name="tip"><inertial><origin xyz="0.1 0 -0.1"/><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0.02" iyy="0.12" iyz="0.01" izz="0.15"/></inertial></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/>
    <origin xyz="0.3 0.1 0" rpy="0.3 0.2 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"#;

/// Where the quaternion stands among the coordinates.
const QUATERNION: std::ops::Range<usize> = 3..7;

/// Made a unit, and its rate tangential.
fn on_the_sphere(q: &mut [f64], v: &mut [f64]) {
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.iter_mut().for_each(|x| *x /= length);
    let along: f64 = q.iter().zip(v.iter()).map(|(q, v)| q * v).sum();
    v.iter_mut().zip(q).for_each(|(v, q)| *v -= along * *q);
}

#[test]
fn slopes_by_recursion_are_those_of_the_expressions() {
    let mut library = Library::empty();
    library.add_file("arm.urdf", "arm.urdf", ARM);
    let text = "model arm; urdf \"arm.urdf\" { base: floating; }";
    let compiled = compile("arm.model", text, &library).unwrap_or_else(|e| panic!("{e}"));
    let mut expansion = Expansion::new(&compiled);
    let mut outputs: Vec<ExprId> = Vec::new();
    let coordinates = expansion.model.coordinates.clone();
    let positions: Vec<SymbolId> = coordinates.iter().map(|c| c.position).collect();
    let velocities: Vec<SymbolId> = coordinates.iter().map(|c| c.velocity).collect();
    let tau = expansion.entries(Item::of(Term::InverseDynamics)).unwrap();
    for (group, symbols) in [
        (Group::Position, &positions),
        (Group::Velocity, &velocities),
    ] {
        outputs.extend(
            expansion
                .entries(Item::slope(Term::InverseDynamics, group))
                .unwrap(),
        );
        outputs.extend(expansion.model.graph.jacobian(&tau, symbols).concat());
    }
    for round in 0..5 {
        let mut values: Vec<f64> = (0..expansion.model.graph.symbol_count())
            .map(|i| (1.7 * i as f64 + 0.9 * f64::from(round)).sin())
            .collect();
        let pick = |values: &[f64], symbols: &[SymbolId]| -> Vec<f64> {
            symbols[QUATERNION]
                .iter()
                .map(|s| values[s.index()])
                .collect()
        };
        let (mut q, mut v) = (pick(&values, &positions), pick(&values, &velocities));
        on_the_sphere(&mut q, &mut v);
        for (k, place) in QUATERNION.enumerate() {
            values[positions[place].index()] = q[k];
            values[velocities[place].index()] = v[k];
        }
        let found = expansion.model.graph.evaluate(&outputs, &values);
        let size = tau.len() * tau.len();
        for (what, pair) in ["position", "velocity"].iter().zip(found.chunks(2 * size)) {
            let (recursion, expressions) = pair.split_at(size);
            for (k, (x, y)) in recursion.iter().zip(expressions).enumerate() {
                assert!((x - y).abs() < 1e-12, "{what}, entry {k}: {x} {y}");
            }
        }
    }
}
