//! MJCF files of our own against MuJoCo's figures of them (`tests/mujoco/mjcf.py`).

use dynamics_codegen::graph::ExprId;
use dynamics_codegen::{Compiled, Library, System, Tape, compile};
use serde_json::Value;

const MODELS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/mujoco/models");
const FIGURES: &str = include_str!("../../tests/mujoco/mjcf.json");
/// Speed at which Coulomb friction has reached 76 %, rad/s or m/s.
const SLOW: f64 = 0.01;
const TOLERANCE: f64 = 1e-10;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

/// A file of the folder as the base of a model; nothing is rounded.
fn on_top_of(name: &str, options: &str) -> Compiled {
    let mut library = Library::builtin();
    library.look_in(MODELS);
    let model = format!("model robot; mjcf \"{name}.xml\" {{ snap: off; {options} }}");
    compile("robot.model", &model, &library).unwrap_or_else(|report| panic!("{report}"))
}

/// `outputs` at a state of MuJoCo's, without inputs.
fn evaluate(compiled: &Compiled, outputs: &[ExprId], state: &Value) -> Vec<f64> {
    let model = &compiled.model;
    let tape = Tape::new(&model.graph, outputs, &System::arguments(model));
    let inputs = vec![0.0; model.inputs.len()];
    let arguments = [
        vec![0.0],
        numbers(&state["q"]),
        numbers(&state["v"]),
        inputs,
    ]
    .concat();
    tape.evaluate(&arguments)
}

/// `Tᵀ x` with the rates `T` of our coordinates by MuJoCo's velocities, row by row.
fn along(rates: &[f64], forces: &[f64]) -> Vec<f64> {
    let count = rates.len() / forces.len();
    let column = |j: usize| {
        forces
            .iter()
            .enumerate()
            .map(move |(i, x)| x * rates[i * count + j])
    };
    (0..count).map(|j| column(j).sum()).collect()
}

/// `Tᵀ M T`.
fn both_sides(rates: &[f64], matrix: &[f64]) -> Vec<f64> {
    let n = matrix.len().isqrt();
    let count = rates.len() / n;
    // Rows of M T, then its columns by Tᵀ.
    let right: Vec<f64> = matrix.chunks(n).flat_map(|row| along(rates, row)).collect();
    let column = |j: usize| {
        right
            .iter()
            .skip(j)
            .step_by(count)
            .copied()
            .collect::<Vec<f64>>()
    };
    (0..count).flat_map(|j| along(rates, &column(j))).collect()
}

fn compare(place: &str, ours: &[f64], theirs: &[f64]) {
    assert_eq!(ours.len(), theirs.len(), "{place}");
    let scale = theirs.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    for (ours, theirs) in ours.iter().zip(theirs) {
        let off = (ours - theirs).abs() / scale;
        assert!(off < TOLERANCE, "{place}: {ours} for {theirs}");
    }
}

fn check(name: &str, robot: &Value) {
    let compiled = on_top_of(name, "equalities: hold;");
    let model = &compiled.model;
    let names: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
    let expected: Vec<&str> = list(&robot["coordinates"]).iter().map(text).collect();
    assert_eq!(names, expected, "{name}");
    let system = &compiled.system;
    let friction = numbers(&robot["friction"]);
    for (index, state) in list(&robot["states"]).iter().enumerate() {
        let of = |what: &str| format!("{name}, state {index}: {what}");
        let rates = numbers(&state["rates"]);
        let mass = evaluate(&compiled, &system.mass_matrix.concat(), state);
        compare(&of("M"), &both_sides(&rates, &mass), &numbers(&state["M"]));
        // Q_C is on the other side than MuJoCo's bias, and springs are part of it.
        let forces = along(&rates, &evaluate(&compiled, &system.bias_force, state));
        let springs = numbers(&state["spring"]);
        let bias: Vec<f64> = forces.iter().zip(springs).map(|(q, s)| s - q).collect();
        compare(&of("bias"), &bias, &numbers(&state["bias"]));
        let applied = along(&rates, &evaluate(&compiled, &system.applied_force, state));
        let velocity = numbers(&state["velocity"]);
        let losses = numbers(&state["damper"])
            .into_iter()
            .zip(&friction)
            .zip(velocity);
        let losses: Vec<f64> = losses
            .map(|((d, f), v)| d - f * (v / SLOW).tanh())
            .collect();
        compare(&of("losses"), &applied, &losses);
    }
    check_drives(name, robot, &compiled);
    check_equalities(name, robot, &compiled);
}

/// Residuals and rows of the equalities, by our rates and by MuJoCo's velocities. What no coordinate changes is no
/// constraint of ours.
fn check_equalities(name: &str, robot: &Value, compiled: &Compiled) {
    let constraints = &compiled.model.constraints;
    let rows: Vec<&str> = list(&robot["equalities"]).iter().map(text).collect();
    let ours = constraints.iter().filter(|c| !c.name.ends_with("_unit"));
    assert!(
        ours.into_iter().all(|c| rows.contains(&c.name.as_str())),
        "{name}"
    );
    for (index, state) in list(&robot["states"]).iter().enumerate() {
        let rates = numbers(&state["rates"]);
        for (row, equality) in rows.iter().enumerate() {
            let of = |what: &str| format!("{name}, state {index}, {equality}: {what}");
            let jacobian = numbers(&state["jacobian"][row]);
            let Some(own) = constraints.iter().position(|c| c.name == *equality) else {
                compare(&of("no row"), &jacobian, &vec![0.0; jacobian.len()]);
                continue;
            };
            let residual = evaluate(compiled, &[compiled.system.constraint_residual[own]], state);
            compare(
                &of("residual"),
                &residual,
                &[state["residual"][row].as_f64().unwrap()],
            );
            let ours = evaluate(compiled, &compiled.system.constraint_matrix[own], state);
            compare(&of("row"), &along(&rates, &ours), &jacobian);
        }
    }
}

/// Where the file has actuators, these are the inputs, with their gears.
fn check_drives(name: &str, robot: &Value, compiled: &Compiled) {
    let drives = list(&robot["drives"]);
    let model = &compiled.model;
    if drives.is_empty() {
        // One for every joint with one freedom; what turns by a quaternion has four coordinates and is not driven.
        let units = model
            .constraints
            .iter()
            .filter(|c| c.name.ends_with("_unit"));
        let single = model.coordinates.len() - 4 * units.count();
        assert_eq!(model.inputs.len(), single, "{name}");
        return;
    }
    assert_eq!(model.inputs.len(), drives.len(), "{name}");
    for drive in drives {
        let mut inputs = model.inputs.iter();
        let input = inputs.position(|input| input.name == text(&drive["name"]));
        let input = input.expect("an input of the drive's name");
        for (row, coordinate) in model.coordinates.iter().enumerate() {
            let entry = compiled.system.input_matrix[row][input];
            let gear = match coordinate.name == text(&drive["joint"]) {
                true => drive["gear"].as_f64(),
                false => Some(0.0),
            };
            assert_eq!(model.graph.as_constant(entry), gear, "{name}: {drive}");
        }
    }
}

#[test]
fn the_equations_are_those_of_mujoco() {
    let figures: Value = serde_json::from_str(FIGURES).expect("JSON");
    for name in [
        "chain", "several", "classes", "geoms", "walker", "balls", "loops",
    ] {
        check(name, &figures[name]);
    }
}

#[test]
fn a_file_is_a_model_by_itself_and_is_called_by_its_own_name() {
    let mut library = Library::builtin();
    library.look_in(MODELS);
    let path = format!("{MODELS}/walker.xml");
    let text = std::fs::read_to_string(&path).expect("a file");
    let compiled = compile(&path, &text, &library).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(compiled.model.name, "walker");
    let robot = compiled.model.robot.as_ref().expect("a robot");
    assert_eq!(robot.included.len(), 1);
    assert_eq!(robot.included[0].0, "walker_defaults.xml");
}

#[test]
fn the_model_says_which_joints_are_driven_lost_in_and_locked() {
    let inputs = |options: &str| -> Vec<String> {
        let compiled = on_top_of("classes", options);
        let inputs = compiled.model.inputs.iter();
        inputs.map(|input| input.name.clone()).collect()
    };
    assert_eq!(inputs(""), ["roll_drive", "pitch_drive", "knee_drive"]);
    // What has no actuator is driven by a force of its own name.
    assert_eq!(inputs("inputs: knee, ankle;"), ["knee_drive", "ankle"]);
    let all = ["roll_drive", "pitch_drive", "knee_drive", "ankle"];
    assert_eq!(inputs("inputs: all;"), all);
    assert!(inputs("inputs: none;").is_empty());
    assert_eq!(inputs("lock: knee = 0.3;"), ["roll_drive", "pitch_drive"]);
    let idle = on_top_of("classes", "losses: ignore;");
    let zero = |entry: &ExprId| idle.model.graph.as_constant(*entry) == Some(0.0);
    assert!(idle.system.applied_force.iter().all(zero));
}

/// A joint that is locked leaves the rows of the others as they are where it stands.
#[test]
fn a_locked_joint_stands_where_it_stood() {
    let free = on_top_of("several", "");
    let figures: Value = serde_json::from_str(FIGURES).expect("JSON");
    let state = &list(&figures["several"]["states"])[0];
    let q = numbers(&state["q"]);
    let locked = on_top_of("several", &format!("lock: turn = {};", q[3]));
    let whole = evaluate(&free, &free.system.mass_matrix.concat(), state);
    let without = |x: &[f64]| -> Vec<f64> {
        let kept = x.iter().enumerate().filter(|(index, _)| *index != 3);
        kept.map(|(_, x)| *x).collect()
    };
    let model = &locked.model;
    let outputs = locked.system.mass_matrix.concat();
    let tape = Tape::new(&model.graph, &outputs, &System::arguments(model));
    let still = vec![0.0; model.inputs.len() + model.coordinates.len()];
    let ours = tape.evaluate(&[vec![0.0], without(&q), still].concat());
    let rows = whole.chunks(q.len()).enumerate();
    let rows = rows.filter(|(row, _)| *row != 3);
    let expected: Vec<f64> = rows.flat_map(|(_, row)| without(row)).collect();
    compare("M without the locked joint", &ours, &expected);
}

/// A trunk that is held stands where the file puts it.
#[test]
fn a_free_joint_is_locked_at_home() {
    let held = on_top_of("walker", "lock: base;");
    assert_eq!(held.model.coordinates.len(), 4);
    let text = "output p = position(trunk);";
    let mut library = Library::builtin();
    library.look_in(MODELS);
    let model = format!("model held; mjcf \"walker.xml\" {{ lock: base; }} {text}");
    let held = compile("held.model", &model, &library).unwrap_or_else(|report| panic!("{report}"));
    let graph = &held.model.graph;
    let place: Vec<f64> = (held.system.outputs.iter())
        .map(|&output| graph.as_constant(output).expect("a constant"))
        .collect();
    compare("the trunk", &place, &[0.2, -0.1, 0.6]);
}

/// Damping has a law for a ball, dry friction none that is linear in the rates of a quaternion.
#[test]
fn dry_friction_of_a_ball_is_said_to_be_ignored() {
    let robot = "\
<robot name=\"bob\">
  <link name=\"hook\"/>
  <link name=\"rod\">
    <inertial>
      <origin xyz=\"0 0 -0.4\"/> <mass value=\"1.2\"/>
      <inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.004\"/>
    </inertial>
  </link>
  <joint name=\"swing\" type=\"spherical\">
    <parent link=\"hook\"/> <child link=\"rod\"/>
    <dynamics damping=\"0.02\" friction=\"0.1\"/>
  </joint>
</robot>
";
    let warnings = |robot: &str| {
        let compiled = compile("bob.urdf", robot, &Library::builtin());
        let compiled = compiled.unwrap_or_else(|report| panic!("{report}"));
        compiled.warnings.render()
    };
    insta::assert_snapshot!(warnings(robot), @r#"
    warning: the dry friction of the ball joint `swing` is ignored
      --> bob.urdf:11:5
       |
    11 |     <dynamics damping="0.02" friction="0.1"/>
       |     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ its damping is read
    "#);
    assert_eq!(warnings(&robot.replace("friction=\"0.1\"", "")), "");
}

/// Bodies in a plane don't leave it: of three equations for a point two say something.
#[test]
fn equalities_are_constraints_where_something_moves() {
    let names = |options: &str| -> Vec<String> {
        let compiled = on_top_of("loops", options);
        let constraints = compiled.model.constraints.iter();
        constraints.map(|c| c.name.clone()).collect()
    };
    let points = ["loop_x", "loop_z", "pin_x", "pin_y", "pin_z"];
    let all = [&["rod_unit", "follow", "hold"][..], &points].concat();
    assert_eq!(names("equalities: hold;"), all);
    assert_eq!(names(""), ["rod_unit"]);
    assert_eq!(names("equalities: ignore;"), ["rod_unit"]);
    let mut library = Library::builtin();
    library.look_in(MODELS);
    let model = "model robot; mjcf \"loops.xml\" { equalities: hold; lock: slider; }";
    let report = compile("robot.model", model, &library).unwrap_err();
    let told = "error: `slider` is locked, and the equality `follow` moves it";
    assert!(report.render().starts_with(told), "{report}");
    // A name that is a constraint's already.
    let loops = std::fs::read_to_string(format!("{MODELS}/loops.xml")).expect("a file");
    let doubled = loops.replace("name=\"hold\"", "name=\"rod_unit\"");
    library.add_file("doubled.xml", "doubled.xml", &doubled);
    let model = "model robot; mjcf \"doubled.xml\" { equalities: hold; }";
    let report = compile("robot.model", model, &library).unwrap_err();
    let told = "error: there are two constraints named `rod_unit`";
    assert!(report.render().starts_with(told), "{report}");
}
