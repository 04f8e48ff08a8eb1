//! A base that floats by its twist: six velocities for seven positions, the same machine as
//! with seven rates.

use dynamics_codegen::derive::{Expansion, Group, Item, Term};
use dynamics_codegen::{Library, compile};
use std::collections::BTreeMap;

const ARM: &str = r#"<robot name="arm">
  <link name="base"><inertial><origin xyz="0.1 0.2 -0.1"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0.01" ixz="0.02" iyy="0.2" iyz="0.01" izz="0.15"/></inertial></link>
  <link name="tip"><inertial><origin xyz="0.1 0 -0.1"/><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0.02" iyy="0.12" iyz="0.01" izz="0.15"/></inertial></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/>
    <origin xyz="0.3 0.1 0" rpy="0.3 0.2 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"#;

/// The position of the base, its orientation, and the elbow.
const Q: [f64; 8] = [0.3, -0.2, 0.9, 0.1, -0.5, 0.7, 0.5, 0.4];
/// The twist of the base, and the elbow's rate.
const V: [f64; 7] = [0.5, -0.8, 0.3, 1.1, -0.6, 0.9, -1.3];

/// A model on the arm, with `rest` behind it; names of all symbols for [`values`].
struct Machine(Expansion);

impl Machine {
    fn new(velocities: &str, rest: &str) -> Self {
        let mut library = Library::builtin();
        library.add_file("arm.urdf", "arm.urdf", ARM);
        let text = format!(
            "model arm; urdf \"arm.urdf\" {{ base: floating; velocities: {velocities}; }} {rest}"
        );
        let compiled = compile("arm.model", &text, &library).unwrap_or_else(|e| panic!("{e}"));
        Self(Expansion::new(&compiled))
    }

    /// An item where symbols of these names have these values.
    fn at(&mut self, item: Item, values: &BTreeMap<String, f64>) -> Vec<f64> {
        let entries = self.0.entries(item).unwrap_or_else(|e| panic!("{e}"));
        let graph = &self.0.model.graph;
        let mut given = vec![f64::NAN; graph.symbol_count()];
        for symbol in graph.symbols_in(&entries) {
            let name = graph.symbol_name(symbol);
            given[symbol.index()] = *values.get(name).unwrap_or_else(|| panic!("no {name}"));
        }
        graph.evaluate(&entries, &given)
    }
}

/// The quaternion of [`Q`], made a unit.
fn quaternion() -> [f64; 4] {
    let length = Q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
    std::array::from_fn(|k| Q[3 + k] / length)
}

/// `R a`
fn turned([x, y, z, w]: [f64; 4], a: [f64; 3]) -> [f64; 3] {
    let u = [x, y, z];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    };
    let once = cross(u, a);
    let twice = cross(u, once);
    [0, 1, 2].map(|k| a[k] + 2.0 * (w * once[k] + twice[k]))
}

/// `½ η ⊗ (ω, 0)`
fn quaternion_rate([x, y, z, w]: [f64; 4], [a, b, c]: [f64; 3]) -> [f64; 4] {
    [
        w * a + y * c - z * b,
        w * b - x * c + z * a,
        w * c + x * b - y * a,
        -x * a - y * b - z * c,
    ]
    .map(|x| x / 2.0)
}

/// The state, for models of either kind.
fn state() -> BTreeMap<String, f64> {
    let eta = quaternion();
    let mut values = BTreeMap::from([("t".to_string(), 0.0), ("u_elbow".to_string(), 0.7)]);
    let mut set = |names: [&str; 7], prefix: &str, numbers: [f64; 7]| {
        for (name, number) in names.iter().zip(numbers) {
            values.insert(format!("{prefix}_base_{name}"), number);
        }
    };
    let [x, y, z, qx, qy, qz, qw, elbow] = Q;
    let _ = (qx, qy, qz, qw);
    let pose = ["x", "y", "z", "qx", "qy", "qz", "qw"];
    set(pose, "q", [x, y, z, eta[0], eta[1], eta[2], eta[3]]);
    let [vx, vy, vz, wx, wy, wz, elbow_rate] = V;
    let rates = turned(eta, [vx, vy, vz]);
    let turning = quaternion_rate(eta, [wx, wy, wz]);
    let rates = [
        rates[0], rates[1], rates[2], turning[0], turning[1], turning[2], turning[3],
    ];
    set(pose, "dq", rates);
    for (name, number) in ["vx", "vy", "vz", "wx", "wy", "wz"].iter().zip(V) {
        values.insert(format!("dq_base_{name}"), number);
        values.insert(format!("ddq_base_{name}"), 0.0);
    }
    values.insert("q_elbow".into(), elbow);
    values.insert("dq_elbow".into(), elbow_rate);
    values.insert("ddq_elbow".into(), 0.0);
    values
}

fn near(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (x, y)) in found.iter().zip(expected).enumerate() {
        assert!((x - y).abs() < 1e-11, "{what}, entry {k}: {x} {y}");
    }
}

#[test]
fn there_is_one_velocity_less_and_no_constraint() {
    let machine = Machine::new("twist", "");
    let model = &machine.0.model;
    let velocities: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
    let of_base = ["vx", "vy", "vz", "wx", "wy", "wz"].map(|c| format!("base_{c}"));
    assert_eq!(velocities[..6], of_base);
    assert_eq!(velocities[6..], ["elbow"]);
    let positions: Vec<String> = model.positions().into_iter().map(|p| p.name).collect();
    let of_base = ["x", "y", "z", "qx", "qy", "qz", "qw"].map(|c| format!("base_{c}"));
    assert_eq!(positions[..7], of_base);
    assert_eq!(positions[7..], ["elbow".to_string()]);
    assert!(model.constraints.is_empty());
    assert_eq!(model.pose_places(), [[0, 0]]);
    // Where the base is makes no difference to the inertia seen from it.
    let mass = machine.0.system().mass_matrix.concat();
    let read = model.graph.symbols_in(&mass);
    assert!(
        model.poses[0]
            .symbols()
            .all(|symbol| !read.contains(&symbol))
    );
}

#[test]
fn positions_change_by_the_twist() {
    let mut machine = Machine::new("twist", "output h = base_z; output r = dot(base_qx);");
    let values = state();
    let rates = machine.at(Item::of(Term::PositionRate), &values);
    let pose = ["x", "y", "z", "qx", "qy", "qz", "qw"];
    let mut expected: Vec<f64> = pose
        .iter()
        .map(|c| values[&format!("dq_base_{c}")])
        .collect();
    expected.push(V[6]);
    near(&rates, &expected, "rates");
    let outputs = machine.at(Item::of(Term::Outputs), &values);
    near(&outputs, &[Q[2], expected[3]], "outputs");
    let rate = machine.at(Item::of(Term::OutputRates), &values);
    near(&rate[..1], &expected[2..3], "rate of an output");
}

/// Slopes by recursion are those of the expressions, along the tangent.
#[test]
fn slopes_are_along_the_tangent() {
    let mut machine = Machine::new("twist", "");
    let values = state();
    for group in [Group::Position, Group::Velocity] {
        let recursion = machine.at(Item::slope(Term::InverseDynamics, group), &values);
        let expressions = machine.at(Item::slope(Term::BiasForce, group), &values);
        let opposite: Vec<f64> = expressions.iter().map(|x| -x).collect();
        near(&recursion, &opposite, group.name());
    }
}

/// A point mass is a body, or its energies: Boltzmann's and Hamel's terms are all there.
#[test]
fn energies_may_be_stated() {
    let bodies = "frame hand = tip * translate(0.1, -0.2, 0.3);
                  body ball { frame: hand; mass: 0.8; }";
    let energies = "frame hand = tip * translate(0.1, -0.2, 0.3);
        constant m: kg = 0.8; constant g: m/s^2 = 9.81;
        kinetic m/2*(velocity(hand).x^2 + velocity(hand).y^2 + velocity(hand).z^2);
        potential m*g*position(hand).z;";
    let values = state();
    let found = [bodies, energies].map(|rest| {
        let mut machine = Machine::new("twist", rest);
        [Term::MassMatrix, Term::BiasForce, Term::ForwardDynamics]
            .map(|term| machine.at(Item::of(term), &values))
            .concat()
    });
    near(&found[0], &found[1], "terms");
}

/// A hand that is held accelerates the elbow, and is held, as with seven rates.
#[test]
fn constraints_hold_the_same() {
    let rest = "frame hand = tip * translate(0.1, -0.2, 0.3);
        constraint px: position(hand).x == 0.1; constraint pz: position(hand).z == base_x + 0.2;
        force at(hand) = (1, 2, 3);";
    let values = state();
    let found = ["twist", "rates"].map(|velocities| {
        let mut machine = Machine::new(velocities, rest);
        let a = machine.at(Item::of(Term::ConstrainedAcceleration), &values);
        let lambda = machine.at(Item::of(Term::ConstrainedMultipliers), &values);
        let constraints = &machine.0.model.constraints;
        let hand = constraints.iter().zip(&lambda);
        let hand = hand.filter(|(c, _)| c.name.starts_with('p'));
        let mut found: Vec<f64> = hand.map(|(_, &lambda)| lambda).collect();
        found.push(a[a.len() - 1]);
        found
    });
    near(
        &found[0],
        &found[1],
        "multipliers and the elbow's acceleration",
    );
}

/// With rates a body has the components of its twist by their names, too: expressions of its pose and its rates.
#[test]
fn a_twist_has_its_names_with_rates_too() {
    let rest = "output a = base_vx; output b = base_vy; output c = base_vz;
        output d = base_wx; output e = base_wy; output f = base_wz;";
    let values = state();
    for velocities in ["twist", "rates"] {
        let found = Machine::new(velocities, rest).at(Item::of(Term::Outputs), &values);
        near(&found, &V[..6], velocities);
    }
}

fn refused(options: &str, rest: &str) -> String {
    let mut library = Library::builtin();
    library.add_file("arm.urdf", "arm.urdf", ARM);
    let text = format!("model arm;\nurdf \"arm.urdf\" {{ {options} }}\n{rest}\n");
    match compile("arm.model", &text, &library) {
        Ok(_) => panic!("{text}"),
        Err(report) => report.to_string(),
    }
}

#[test]
fn mistakes_have_a_mend() {
    let text = refused("base: floating; velocities: body;", "");
    assert!(
        text.contains("`velocities` are `rates` or `twist`"),
        "{text}"
    );
    let twist = "base: floating; velocities: twist;";
    let text = refused(twist, "measured base_wx = base_wx + 0.1;");
    assert!(text.contains("`base_wx` is a velocity"), "{text}");
    let text = refused(twist, "output a = dot(base_wx);");
    assert!(text.contains("already contains `base_wx`"), "{text}");
    let text = refused("velocities: twist;", "");
    assert!(text.contains("nothing floats"), "{text}");
}
