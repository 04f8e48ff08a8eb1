//! The C compiler, as strict as firmware people run it.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Every warning is an error.
const STRICT: [&str; 6] = [
    "-std=c99",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Werror",
];

/// The number type that generated C computes with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// `float`
    Single,
    /// `double`
    Double,
}

fn command(precision: Precision) -> Command {
    let mut command = Command::new(std::env::var("CC").unwrap_or_else(|_| "cc".to_string()));
    command.args(STRICT);
    if precision == Precision::Single {
        command.arg("-DDYNAMICS_FLOAT");
    }
    command
}

fn run(mut command: Command) {
    let output = command
        .output()
        .expect("a C compiler is installed (`cc`, or name it in `CC`)");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Compiles without keeping the result.
pub fn check(source: &Path, precision: Precision) {
    let mut command = command(precision);
    command.arg("-fsyntax-only").arg(source);
    run(command);
}

/// Compiles and links a program.
pub fn build(sources: &[PathBuf], program: &Path, precision: Precision) {
    let mut command = command(precision);
    command
        .arg("-O1")
        .args(sources)
        .arg("-o")
        .arg(program)
        .arg("-lm");
    run(command);
}
