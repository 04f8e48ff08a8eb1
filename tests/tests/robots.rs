//! Robot descriptions through the whole pipeline against Pinocchio's numbers
//! (`tests/pinocchio/`), and the Wheelbot, written with frames and bodies, against an
//! independent derivation.

use dynamics_codegen::derive::Variable;
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::{Compiled, Library, System, Tape, compile};
use identify::machine::{Machine, States};
use integration_tests::{files::root, models, reference::Deviations};
use serde_json::Value;
use std::path::Path;

const VALUES: f64 = 1e-10;
const DERIVATIVES: f64 = 1e-8;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

fn texts(value: &Value) -> Vec<String> {
    let items = value.as_array().expect("a list").iter();
    let text = |item: &Value| item.as_str().expect("a text").to_string();
    items.map(text).collect()
}

fn read(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A model on top of a URDF, with the position of each of `links` as outputs. Losses
/// are left out and nothing is rounded: Pinocchio's figures are of the rigid bodies,
/// digit by digit.
fn on_top_of(urdf: &Path, floating: bool, links: &[String]) -> Compiled {
    let base = if floating { "floating" } else { "fixed" };
    let mut text = format!(
        "model robot; urdf {:?} {{ losses: ignore; snap: off; base: {base} }}",
        urdf.file_name().expect("a file").to_string_lossy()
    );
    for (index, link) in links.iter().enumerate() {
        text.push_str(&format!("output p{index} = position({link:?});"));
    }
    let mut library = Library::builtin();
    library.look_in(urdf.parent().expect("a folder"));
    compile("robot.model", &text, &library).unwrap_or_else(|report| panic!("{report}"))
}

/// Where each of Pinocchio's joints stands among our coordinates.
fn order(compiled: &Compiled, joints: &[String]) -> Vec<usize> {
    let names: Vec<&str> = (compiled.model.coordinates.iter())
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(names.len(), joints.len(), "{names:?} {joints:?}");
    let place = |joint: &String| names.iter().position(|name| name == joint);
    joints
        .iter()
        .map(|joint| place(joint).unwrap_or_else(|| panic!("no coordinate {joint}")))
        .collect()
}

/// Values in Pinocchio's order as values in ours.
fn to_ours(order: &[usize], theirs: &[f64]) -> Vec<f64> {
    let mut ours = vec![0.0; theirs.len()];
    for (&place, &value) in order.iter().zip(theirs) {
        ours[place] = value;
    }
    ours
}

struct Robot {
    compiled: Compiled,
    order: Vec<usize>,
    worst: Deviations,
}

impl Robot {
    fn tape(&self, outputs: &[ExprId]) -> Tape {
        let model = &self.compiled.model;
        Tape::new(&model.graph, outputs, &System::arguments(model))
    }

    /// Values of `outputs` at a state of Pinocchio's file.
    fn evaluate(&self, tape: &Tape, state: &Value) -> Vec<f64> {
        let of = |key: &str| to_ours(&self.order, &numbers(&state[key]));
        let inputs = vec![0.0; self.compiled.model.inputs.len()];
        let arguments = [vec![0.0], of("q"), of("v"), inputs].concat();
        tape.evaluate(&arguments)
    }

    /// Rows and columns in our order as Pinocchio's.
    fn square(&self, ours: &[f64]) -> Vec<f64> {
        let n = self.order.len();
        let rows = self.order.iter();
        rows.flat_map(|&i| self.order.iter().map(move |&j| ours[i * n + j]))
            .collect()
    }
}

fn check(urdf: &Path, expected: &Value) {
    let name = urdf.display().to_string();
    let links = texts(&expected["links"]);
    let compiled = on_top_of(urdf, false, &links);
    let joints = texts(&expected["joints"]);
    let mut robot = Robot {
        order: order(&compiled, &joints),
        compiled,
        worst: Deviations::default(),
    };
    let system = &robot.compiled.system;
    let mass_matrix = robot.tape(&system.mass_matrix.concat());
    let bias = robot.tape(&system.bias_force);
    let jacobian = robot.tape(&system.output_jacobian.concat());
    let output_bias = robot.tape(&system.output_bias);
    let n = joints.len();
    for (index, state) in expected["states"]
        .as_array()
        .expect("states")
        .iter()
        .enumerate()
    {
        let place = format!("{name}, state {index}");
        let m = robot.square(&robot.evaluate(&mass_matrix, state));
        let ours = robot.evaluate(&bias, state);
        // Pinocchio's bias stands on the left.
        let q_c: Vec<f64> = robot.order.iter().map(|&i| -ours[i]).collect();
        let ours = robot.evaluate(&jacobian, state);
        let j: Vec<f64> = (0..3 * links.len())
            .flat_map(|row| robot.order.iter().map(move |&i| (row, i)))
            .map(|(row, i)| ours[row * n + i])
            .collect();
        let drift = robot.evaluate(&output_bias, state);
        // Of six rows per link the first three are linear.
        let linear: Vec<f64> = (state["J"].as_array().expect("links").iter())
            .flat_map(|link| link.as_array().expect("rows")[..3].iter().flat_map(numbers))
            .collect();
        let linear_drift: Vec<f64> = (state["Jdot_v"].as_array().expect("links").iter())
            .flat_map(|link| numbers(link)[..3].to_vec())
            .collect();
        let at = |what| (place.as_str(), what);
        robot
            .worst
            .check(at("M"), &m, &numbers(&state["M"]), VALUES);
        let bias = numbers(&state["bias"]);
        robot.worst.check(at("bias"), &q_c, &bias, VALUES);
        robot.worst.check(at("J"), &j, &linear, VALUES);
        // Where nothing turns this is the rounding of a zero.
        let with_floor = |values: &[f64]| [values, &[1e-3]].concat();
        let (drift, expected) = (with_floor(&drift), with_floor(&linear_drift));
        robot.worst.check(at("J̇v"), &drift, &expected, VALUES);
    }
    println!("{name}: {}", robot.worst.summary());
    check_motion(urdf, expected);
}

/// Accelerations and their derivatives, through the machine that traces and simulates.
fn check_motion(urdf: &Path, expected: &Value) {
    let name = urdf.display().to_string();
    let compiled = on_top_of(urdf, false, &[]);
    let order = order(&compiled, &texts(&expected["joints"]));
    let n = order.len();
    let mut machine = Machine::new(compiled);
    assert_eq!(machine.input_count(), n, "{name}: every joint is driven");
    let variables: Vec<Variable> = (order.iter().map(|&i| Variable::Position(i)))
        .chain(order.iter().map(|&i| Variable::Velocity(i)))
        .chain(order.iter().map(|&i| Variable::Input(i)))
        .collect();
    let tape = machine.sensitivity(&variables);
    let mut worst = Deviations::default();
    for (index, state) in expected["states"]
        .as_array()
        .expect("states")
        .iter()
        .enumerate()
    {
        let place = format!("{name}, state {index}");
        let of = |key: &str| -> Vec<Vec<f64>> {
            let values = to_ours(&order, &numbers(&state[key]));
            values.into_iter().map(|x| vec![x]).collect()
        };
        let states = States {
            t: vec![0.0],
            q: of("q"),
            v: of("v"),
            u: of("tau"),
            ..States::default()
        };
        let motions = machine
            .motion(&states, &[])
            .unwrap_or_else(|e| panic!("{place}: {e}"));
        let a: Vec<f64> = order.iter().map(|&i| motions[0].acceleration[i]).collect();
        // Its digits depend on how well M can be inverted; Pinocchio's own a has no more.
        worst.check((&place, "a"), &a, &numbers(&state["a"]), 1e-9);
        let slopes = &tape.evaluate(&states, &[], &motions)[0].0;
        for (key, first) in [("da_dq", 0), ("da_dv", n), ("da_dtau", 2 * n)] {
            let ours: Vec<f64> = (order.iter())
                .flat_map(|&row| (0..n).map(move |column| slopes[(row, first + column)]))
                .collect();
            worst.check((&place, key), &ours, &numbers(&state[key]), DERIVATIVES);
        }
    }
    println!("{name}: {}", worst.summary());
}

/// Every robot of others' that is here, save those that must be refused.
#[test]
fn robots_of_others_agree_with_pinocchio() {
    let folder = root().join("tests/pinocchio/expected");
    let mut compared = 0;
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .expect("expected figures")
        .map(|entry| entry.expect("readable").path())
        .collect();
    names.sort();
    for path in names {
        let expected = read(&path);
        // One file has the two fingers of a gripper apart; a URDF ties them.
        if expected["mimic"] == "independent" {
            continue;
        }
        let urdf = expected["urdf"].as_str().expect("a file name");
        let Some(urdf) = left_out::shared(&format!("data/urdf/{urdf}")) else {
            continue;
        };
        check(&urdf, &expected);
        compared += 1;
    }
    println!("{compared} robots");
    assert!(compared >= 12 || std::env::var_os("CI").is_none());
}

/// What is wrong with them is said, with the line.
#[test]
fn faulty_robots_are_refused() {
    let Some(folder) = left_out::shared("data/urdf/reject") else {
        return;
    };
    let mut texts = Vec::new();
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .expect("a folder")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|e| e == "urdf"))
        .collect();
    files.sort();
    for file in files {
        let name = file
            .file_name()
            .expect("a file")
            .to_string_lossy()
            .into_owned();
        let text = std::fs::read_to_string(&file).expect("readable");
        let report = compile(&name, &text, &Library::empty()).expect_err("refused");
        let shown = report.to_string();
        assert!(shown.contains(&format!("--> {name}:")), "{shown}");
        texts.push(shown);
    }
    assert_eq!(texts.len(), 2);
    insta::assert_snapshot!("refused_robots", texts.join("\n"));
}

/// The Wheelbot against a derivation that shares nothing with ours.
#[test]
fn the_wheelbot_agrees_with_an_independent_derivation() {
    let Some(path) = left_out::shared("oracles/wheelbot.json") else {
        return;
    };
    let oracle = read(&path);
    let mut machine = Machine::new(models::one("wheelbot.model"));
    let names: Vec<String> = (machine.compiled.model.parameters.iter())
        .map(|p| p.name.clone())
        .collect();
    assert_eq!(names, texts(&oracle["param_names"]));
    let variables: Vec<Variable> = (0..7)
        .map(Variable::Position)
        .chain((0..7).map(Variable::Velocity))
        .chain((0..2).map(Variable::Input))
        .collect();
    let tape = machine.sensitivity(&variables);
    let mut worst = Deviations::default();
    let cases = oracle["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 20);
    for case in cases {
        let place = format!("wheelbot, case {}", case["id"]);
        let set = &oracle["param_sets"][case["params"].as_str().expect("a name")];
        let parameters: Vec<f64> = names.iter().map(|name| numbers(&set[name])[0]).collect();
        let columns = |key: &str| numbers(&case[key]).into_iter().map(|x| vec![x]).collect();
        let states = States {
            t: vec![0.0],
            q: columns("q"),
            v: columns("qd"),
            u: columns("u"),
            ..States::default()
        };
        let motions = machine.motion(&states, &parameters);
        let motions = motions.unwrap_or_else(|e| panic!("{place}: {e}"));
        let terms = &motions[0].terms;
        let by_rows = |m: &dynamics::nalgebra::DMatrix<f64>| m.transpose().as_slice().to_vec();
        let mut check = |name: &str, ours: &[f64], tolerance: f64| {
            let expected = numbers(&case[name]);
            let size = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            // What is zero comes out as rounding of what it is a difference of.
            let floor = if size < 1e-9 { 1.0 } else { 0.0 };
            let (ours, expected) = (
                [ours, &[floor]].concat(),
                [&expected[..], &[floor]].concat(),
            );
            worst.check((&place, name), &ours, &expected, tolerance);
        };
        check("M", &by_rows(&terms.mass_matrix), 1e-9);
        check("Q_C", terms.bias_force.as_slice(), 1e-9);
        check("A", &by_rows(&terms.constraint_matrix), 1e-9);
        check("b", terms.constraint_bias.as_slice(), 1e-9);
        check("qdd", motions[0].acceleration.as_slice(), 1e-9);
        check("lambda_", motions[0].multiplier.as_slice(), 1e-9);
        let slopes = &tape.evaluate(&states, &parameters, &motions)[0].0;
        for (key, first, count) in [("dqdd_dq", 0, 7), ("dqdd_dqd", 7, 7), ("dqdd_du", 14, 2)] {
            let ours: Vec<f64> = (0..7)
                .flat_map(|row| (0..count).map(move |column| slopes[(row, first + column)]))
                .collect();
            check(key, &ours, 1e-7);
        }
    }
    println!("wheelbot: {}", worst.summary());
}
