//! Frames by their names, in Rust, in C and on the tape: places, Jacobians and their rates as Pinocchio
//! has them (`pinocchio/frames.py`).

use dynamics::{Dynamics, Point};
use dynamics_codegen::Tape;
use dynamics_codegen::emit::Emission;
use integration_tests::compiler::Precision;
use integration_tests::{c_program, files::root, models, reference::Deviations};
use serde_json::Value;

const MODEL: &str = "tests/data/models/tool.model";
const FUNCTIONS: &str = "frame_position_of_tool, frame_rotation_of_tool, frame_jacobian_of_link_4, \
                         frame_jacobian_of_tool+frame_bias_of_tool";

/// Functions with Pinocchio's names for what they compute.
const FIGURES: [(&str, &str); 5] = [
    ("frame_position_of_tool", "tool position"),
    ("frame_rotation_of_tool", "tool rotation"),
    ("frame_jacobian_of_link_4", "link_4 J"),
    ("frame_jacobian_of_tool", "tool J"),
    ("frame_bias_of_tool", "tool Jdot_v"),
];

/// Of the largest entry.
const TOLERANCE: f64 = 1e-12;

#[derive(Dynamics)]
#[dynamics(
    model = "data/models/tool.model",
    functions = "frame_position_of_tool, frame_rotation_of_tool, frame_jacobian_of_link_4, frame_jacobian_of_tool+frame_bias_of_tool"
)]
struct Arm;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// The states of Pinocchio's file, whose joints are ours.
fn states() -> Vec<Value> {
    let path = root().join("tests/pinocchio/frames.json");
    let figures: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(figures["joints"], serde_json::json!(Arm::COORDINATE_NAMES));
    figures["states"].as_array().unwrap().clone()
}

/// What has been found of a state, by names of functions.
fn check(worst: &mut Deviations, state: &Value, found: &[(&str, Vec<f64>)]) {
    for (function, key) in FIGURES {
        let (_, values) = found.iter().find(|(name, _)| *name == function).unwrap();
        worst.check((function, key), values, &numbers(&state[key]), TOLERANCE);
    }
}

#[test]
fn rust_agrees_with_pinocchio() {
    let mut worst = Deviations::default();
    for state in states() {
        let x: Point<f64, 7, 7, 0> = Point {
            q: numbers(&state["q"]).try_into().unwrap(),
            v: numbers(&state["v"]).try_into().unwrap(),
            ..Point::zero()
        };
        let both = Arm.frame_jacobian_of_tool_and_frame_bias_of_tool(&x);
        let found = [
            (
                "frame_position_of_tool",
                Arm.frame_position_of_tool(&x).to_vec(),
            ),
            (
                "frame_rotation_of_tool",
                Arm.frame_rotation_of_tool(&x).concat(),
            ),
            (
                "frame_jacobian_of_link_4",
                Arm.frame_jacobian_of_link_4(&x).concat(),
            ),
            (
                "frame_jacobian_of_tool",
                both.frame_jacobian_of_tool.concat(),
            ),
            ("frame_bias_of_tool", both.frame_bias_of_tool.to_vec()),
        ];
        check(&mut worst, &state, &found);
    }
    println!("{}", worst.summary());
}

#[test]
fn c_and_the_tape_agree_with_pinocchio() {
    let compiled = models::read(MODEL);
    let emission = Emission::new(&compiled, MODEL, &FUNCTIONS.parse().unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let program = c_program::build(&emission, &compiled, folder.path(), Precision::Double);
    let mut worst = Deviations::default();
    for state in states() {
        let of = |key: &str| numbers(&state[key]);
        let rest = vec![0.0; emission.arguments().len() - 15];
        let arguments = [vec![0.0], of("q"), of("v"), rest].concat();
        let mut printed = c_program::run(&program, &arguments).into_iter();
        let (mut in_c, mut on_tape) = (Vec::new(), Vec::new());
        for quantity in emission.functions().flat_map(|(_, quantities)| quantities) {
            let name = quantity.name.as_str();
            let length = quantity.shape().iter().product();
            in_c.push((name, printed.by_ref().take(length).collect()));
            let tape = Tape::new(emission.graph(), &quantity.entries, &emission.arguments());
            on_tape.push((name, tape.evaluate(&arguments)));
        }
        check(&mut worst, &state, &in_c);
        check(&mut worst, &state, &on_tape);
    }
    println!("{}", worst.summary());
}
