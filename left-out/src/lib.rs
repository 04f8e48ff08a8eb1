//! What tests need that is not everywhere: the measured logs beside the repository, compilers and
//! emulators for microcontrollers, and time.
//!
//! A test that lacks one of them passes without having looked, and is put on a list, which
//! `cargo test --workspace` prints towards its end (`tests/tests/what_was_left_out.rs`).
//!
//! | variable | effect |
//! |---|---|
//! | `CI` | what lies in `../shared` must be there |
//! | `DYNAMICS_SLOW_TESTS` | tests that take long run, too |
//! | `DYNAMICS_FIRMWARE_REQUIRED` | programs for these must be there: `host`, `cortex_m4`, `atmega32u4`, `rust`, `misra`, with commas between |
//!
//! `.ci/run` sets all of them: the first if there is a `../shared`, the last to the machines whose
//! programs it could install.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The workspace's folder.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// A file or folder of `../shared`; `None`, noted, where it is not there.
///
/// # Panics
/// If it is missing and `CI` is set: then a test may not be left out.
#[must_use]
pub fn shared(path: &str) -> Option<PathBuf> {
    let found = found(path, std::env::var_os("CI").is_some());
    if found.is_none() {
        note(&format!("needs ../shared/{path}"));
    }
    found
}

fn found(path: &str, must_be_there: bool) -> Option<PathBuf> {
    let full = root().join("../shared").join(path);
    let there = full.exists();
    assert!(
        there || !must_be_there,
        "../shared/{path} is missing, and CI is set"
    );
    there.then_some(full)
}

/// Whether the test that calls takes too long for now, which is noted; never where
/// `DYNAMICS_SLOW_TESTS` is set.
#[must_use]
pub fn too_slow() -> bool {
    let slow = std::env::var_os("DYNAMICS_SLOW_TESTS").is_some();
    if !slow {
        note("takes long; runs with DYNAMICS_SLOW_TESTS=1");
    }
    !slow
}

/// Names the machines whose tests may not be left out.
const FIRMWARE: &str = "DYNAMICS_FIRMWARE_REQUIRED";

/// Whether a test of firmware on a machine (or with a tool) has to be left out, which is noted, because
/// one of these programs is not on the path.
///
/// # Panics
/// If that is so and `DYNAMICS_FIRMWARE_REQUIRED` names the machine.
#[must_use]
pub fn lacks_programs(machine: &str, programs: &[&str]) -> bool {
    let required = std::env::var(FIRMWARE).unwrap_or_default();
    let required = required.split(',').any(|name| name == machine);
    let missing = missing(machine, programs, required);
    if let Some(missing) = &missing {
        note(&format!("needs {missing} on the path"));
    }
    missing.is_some()
}

fn missing(machine: &str, programs: &[&str], must_be_there: bool) -> Option<String> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let there = |name: &str| folders.iter().any(|folder| folder.join(name).is_file());
    let missing = programs.iter().copied().filter(|name| !there(name));
    let missing = missing.collect::<Vec<_>>().join(", ");
    assert!(
        missing.is_empty() || !must_be_there,
        "{FIRMWARE} names {machine}, but there is no {missing}"
    );
    (!missing.is_empty()).then_some(missing)
}

/// Where the list is.
fn list() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    root().join(target).join("left_out.txt")
}

/// Puts the test that calls, which is called like its thread, on the list.
fn note(why: &str) {
    let thread = std::thread::current();
    let line = format!("{}: {why}\n", thread.name().unwrap_or("a test"));
    let file = OpenOptions::new().create(true).append(true).open(list());
    // One call, so that lines of tests that run at once do not mix.
    let written = file.and_then(|mut file: File| file.write_all(line.as_bytes()));
    written.unwrap_or_else(|error| panic!("{}: {error}", list().display()));
}

/// Takes the list: what was left out since it was taken last, in order, each once.
///
/// # Panics
/// If it cannot be read or removed.
#[must_use]
pub fn take() -> Vec<String> {
    let path = list();
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Vec::new(),
        Err(error) => panic!("{}: {error}", path.display()),
    };
    std::fs::remove_file(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines.sort();
    lines.dedup();
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "is missing, and CI is set")]
    fn missing_data_is_a_failure_in_ci() {
        let _ = found("no/such/file", true);
    }

    #[test]
    #[should_panic(expected = "names avr, but there is no no-such-compiler")]
    fn a_missing_compiler_is_a_failure_where_it_is_required() {
        let _ = missing("avr", &["no-such-compiler"], true);
    }

    #[test]
    fn missing_compilers_are_named() {
        let found = missing("avr", &["cargo", "no-such-compiler"], false);
        assert_eq!(found.as_deref(), Some("no-such-compiler"));
        assert_eq!(missing("avr", &["cargo"], true), None);
    }

    #[test]
    fn missing_data_is_left_out_elsewhere() {
        assert_eq!(found("no/such/file", false), None);
    }
}
