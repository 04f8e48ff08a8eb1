//! What the tests of the command line share.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The root of the workspace: where commands run, so that paths in messages are short.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The program with arguments.
pub fn dynamics(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dynamics_under_test"));
    command.current_dir(root()).args(arguments);
    command
}

/// What the program prints when all is well, and says while it does so.
pub fn succeed(arguments: &[&str], input: &str) -> (String, String) {
    let output = dynamics(arguments).write_stdin(input).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{stderr}");
    (String::from_utf8(output.stdout).unwrap(), stderr)
}

/// What the program says about bad input: exit code 2, nothing on standard output.
pub fn refuse(arguments: &[&str], input: &str) -> String {
    let output = dynamics(arguments).write_stdin(input).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}\n{stderr}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "", "{arguments:?}");
    stderr
}

/// The answers of `eval --json`.
pub fn eval(model: &str, flags: &[&str], states: &str) -> Vec<Value> {
    let arguments = [&["eval", model, "--states", "-", "--json"], flags].concat();
    let (stdout, _) = succeed(&arguments, states);
    stdout
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// A vector out of an answer.
pub fn vector(value: &Value) -> Vec<f64> {
    let entries = value
        .as_array()
        .unwrap_or_else(|| panic!("{value} is no array"));
    entries.iter().map(|x| x.as_f64().unwrap()).collect()
}

/// A matrix out of an answer, by rows.
pub fn matrix(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(vector).collect()
}

/// A log: its heading and its rows.
pub fn read_log(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let heading = lines
        .next()
        .unwrap()
        .split(',')
        .map(str::to_string)
        .collect();
    let numbers = |line: &str| {
        line.split(',')
            .map(|entry| entry.parse().unwrap())
            .collect()
    };
    (heading, lines.map(numbers).collect())
}

/// A robot description: links one behind the other, each turning about another axis.
pub fn chain(links: usize) -> String {
    let mut text = String::from("<robot name=\"chain\"><link name=\"link_0\"/>\n");
    for k in 1..=links {
        let axis = ["1 0 0", "0 1 0", "0 0 1"][k % 3];
        let parent = k - 1;
        text += &format!(
            r#"<link name="link_{k}"><inertial><origin xyz="0.03 0.02 -0.1"/><mass value="1.{k}"/>
            <inertia ixx="0.02" ixy="0.001" ixz="0.002" iyy="0.021" iyz="0.001" izz="0.01"/></inertial></link>
            <joint name="joint_{k}" type="continuous"><parent link="link_{parent}"/><child link="link_{k}"/>
            <origin xyz="0.01 0.02 -0.2" rpy="0.1 0.2 0.3"/><axis xyz="{axis}"/></joint>"#,
        );
    }
    text + "</robot>"
}

/// `|a - b|`, as a share of their size.
pub fn gap(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let gaps = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs() / (1.0 + b.abs()));
    gaps.fold(0.0, f64::max)
}
