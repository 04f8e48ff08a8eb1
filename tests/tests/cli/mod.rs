//! What the tests of the command line share.
#![allow(dead_code, reason = "no test file uses everything")]

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

/// `|a - b|`, as a share of their size.
pub fn gap(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let gaps = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs() / (1.0 + b.abs()));
    gaps.fold(0.0, f64::max)
}
