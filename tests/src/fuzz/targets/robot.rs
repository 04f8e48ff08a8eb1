//! A robot description, by itself and under a model.

use super::{check_compiled, check_report};
use crate::files::root;
use crate::fuzz::Input;
use crate::fuzz::corpus::MJCF;
use dynamics_codegen::mjcf;
use dynamics_codegen::robot::{Format, Options, Robot, merge_fixed};
use dynamics_codegen::source::Sources;
use dynamics_codegen::urdf;
use dynamics_codegen::{Library, Report, compile, compile_bytes};
use rand::RngExt;

/// How often the robot is what a model stands on, with all its numbers as parameters.
const UNDER_A_MODEL: f64 = 0.3;
/// What one of the files includes.
const PART: &str = "walker_defaults.xml";

pub(super) fn run(input: &Input, format: Format) -> bool {
    let rng = &mut input.choices();
    let text = std::str::from_utf8(&input.bytes);
    if let Ok(text) = text {
        check_robot(input.file_name(), text, format);
    }
    let mut library = Library::builtin();
    if format == Format::Mjcf {
        library.add_file(PART, PART, part());
    }
    let compiled = match text {
        Ok(text) if rng.random_bool(UNDER_A_MODEL) => {
            library.add_file(input.file_name(), input.file_name(), text);
            let (word, file) = (format.word(), input.file_name());
            let model = format!("model m;\n{word} {file:?} {{ parameters: all; origins: all; }}\n");
            compile("m.model", &model, &library)
        }
        _ => compile_bytes(input.file_name(), &input.bytes, &library),
    };
    check_compiled(compiled, rng)
}

/// What is read is finite; what is not read has an error.
fn check_robot(name: &str, text: &str, format: Format) {
    let mut sources = Sources::new();
    let id = sources.add(name, text);
    let mut diagnostics = Vec::new();
    let robot = match format {
        Format::Urdf => urdf::read(&sources, id, &mut diagnostics),
        Format::Mjcf => {
            let beside = |path: &str| match path {
                PART => Ok((PART.to_string(), part())),
                _ => Err(std::io::ErrorKind::NotFound.into()),
            };
            let options = Options::default();
            mjcf::read_with(&mut sources, id, options, &beside, &mut diagnostics)
        }
    };
    let report = Report {
        sources,
        diagnostics,
    };
    check_report(&report);
    assert_eq!(robot.is_none(), report.has_errors(), "{report}");
    if let Some(robot) = robot {
        check_bodies(&robot);
        check_bodies(&merge_fixed(&robot));
    }
}

fn part() -> String {
    let path = root().join(MJCF).join(PART);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn check_bodies(robot: &Robot) {
    for body in &robot.bodies {
        let inertia = &body.inertia;
        let numbers = inertia.tensor.as_flattened().iter().chain(&inertia.center);
        assert!(numbers.copied().all(f64::is_finite), "{inertia:?}");
        assert!(
            inertia.mass.is_finite() && inertia.mass >= 0.0,
            "{inertia:?}"
        );
    }
}
