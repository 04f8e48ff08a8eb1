//! The C compiler, as strict as firmware people run it.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Every warning is an error.
const STRICT: [&str; 10] = [
    "-std=c99",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Wundef",
    "-Wvla",
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

fn compiler() -> String {
    std::env::var("CC").unwrap_or_else(|_| "cc".to_string())
}

fn command(precision: Precision) -> Command {
    let mut command = Command::new(compiler());
    command.args(STRICT);
    if precision == Precision::Single {
        command.arg("-DDYNAMICS_FLOAT");
    }
    command
}

fn run_with(mut command: Command, source: &Path) {
    command.arg(source);
    run(command);
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
    command.arg("-fsyntax-only");
    run_with(command, source);
}

/// As [`check`], with the file `first` included before anything else.
pub fn check_behind(first: &Path, source: &Path, precision: Precision) {
    let mut command = command(precision);
    command.arg("-fsyntax-only").arg("-include").arg(first);
    run_with(command, source);
}

/// The macros that are defined at the end of a file, as `#define` lines; `standard` is an
/// option such as `-std=c99`.
pub fn macros(source: &Path, standard: &str) -> String {
    let mut command = Command::new(compiler());
    command.args([standard, "-dM", "-E"]).arg(source);
    let output = command.output().expect("a C compiler is installed");
    assert!(output.status.success());
    String::from_utf8(output.stdout).expect("macros are ASCII")
}

/// Compiles one file.
pub fn object(source: &Path, object: &Path, precision: Precision) {
    let mut command = command(precision);
    command.arg("-c").arg("-o").arg(object);
    run_with(command, source);
}

/// Links a program; if that fails, what the linker says.
pub fn link(objects: &[PathBuf], program: &Path) -> Result<(), String> {
    let mut command = Command::new(compiler());
    command.args(objects).arg("-o").arg(program).arg("-lm");
    let output = command.output().expect("a C compiler is installed");
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
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
