//! What inputs are given to: the readers, and what works with what was read.
//!
//! A target says whether it accepted its input. It panics where a promise is broken, or lets
//! the panic of the program through.

mod control;
mod effect;
mod equations;
mod inputs;
mod log;
mod map;
mod model;
mod robot;
mod state;

use super::input::Input;
use super::kind::Kind;
use dynamics_cli::mistake::Mistake;
use dynamics_codegen::robot::Format;
use dynamics_codegen::{Compiled, Report};
use rand_chacha::ChaCha8Rng;
use std::io::Write;
use tempfile::NamedTempFile;

/// Runs an input; whether it was accepted.
///
/// # Panics
/// If the program does, or breaks a promise.
pub fn run(input: &Input) -> bool {
    match input.kind {
        Kind::Model => model::run(input),
        Kind::Urdf => robot::run(input, Format::Urdf),
        Kind::Mjcf => robot::run(input, Format::Mjcf),
        Kind::Effect => effect::run(input),
        Kind::Log => log::run(input),
        Kind::Map => map::run(input),
        Kind::State => state::run(input),
        Kind::Inputs => inputs::run(input),
        Kind::Control => control::run(input),
    }
}

/// A report can be shown, and points into its texts.
fn check_report(report: &Report) {
    for diagnostic in &report.diagnostics {
        assert!(!diagnostic.message.is_empty());
        for label in std::iter::once(&diagnostic.primary).chain(&diagnostic.secondary) {
            let text = &report.sources.get(label.span.source).text;
            let (start, end) = (label.span.start, label.span.end);
            assert!(
                start <= end && end <= text.len(),
                "{start}..{end} of {}",
                text.len()
            );
        }
    }
    assert_eq!(report.render().is_empty(), report.diagnostics.is_empty());
    assert_eq!(
        report.render_styled().is_empty(),
        report.diagnostics.is_empty()
    );
}

/// A report that refuses something says what is wrong.
fn check_refusal(report: &Report) {
    assert!(report.has_errors(), "refused without an error");
    check_report(report);
}

/// What compiled has equations that hold, what did not says what is wrong; whether it did.
fn check_compiled(compiled: Result<Compiled, Report>, rng: &mut ChaCha8Rng) -> bool {
    match compiled {
        Ok(compiled) => {
            check_report(&compiled.warnings);
            equations::check(&compiled, rng);
            true
        }
        Err(report) => {
            check_refusal(&report);
            false
        }
    }
}

/// A mistake can be shown in all ways.
fn check_mistake(mistake: &Mistake) {
    for shown in [
        mistake.render(false),
        mistake.render(true),
        mistake.render_as_warning(false),
    ] {
        assert!(!shown.is_empty());
    }
}

/// The input as a file, for readers that take a path.
fn file(input: &Input) -> NamedTempFile {
    let mut file = NamedTempFile::with_suffix(input.file_name()).expect("a temporary file");
    file.write_all(&input.bytes).expect("the disk has room");
    file
}
