//! A robot description, by itself and under a model.

use super::{check_compiled, check_report};
use crate::fuzz::Input;
use dynamics_codegen::source::Sources;
use dynamics_codegen::robot::{Robot, merge_fixed};
use dynamics_codegen::urdf;
use dynamics_codegen::{Library, Report, compile, compile_bytes};
use rand::RngExt;

/// How often the robot is what a model stands on, with all its numbers as parameters.
const UNDER_A_MODEL: f64 = 0.3;
const MODEL: &str = "model m;\nurdf \"fuzz.urdf\" { parameters: all; origins: all; }\n";

pub(super) fn run(input: &Input) -> bool {
    let rng = &mut input.choices();
    let text = std::str::from_utf8(&input.bytes);
    if let Ok(text) = text {
        check_robot(text);
    }
    let compiled = match text {
        Ok(text) if rng.random_bool(UNDER_A_MODEL) => {
            let mut library = Library::builtin();
            library.add_file(input.file_name(), input.file_name(), text);
            compile("m.model", MODEL, &library)
        }
        _ => compile_bytes(input.file_name(), &input.bytes, &Library::builtin()),
    };
    check_compiled(compiled, rng)
}

/// What is read is finite; what is not read has an error.
fn check_robot(text: &str) {
    let mut sources = Sources::new();
    let id = sources.add("fuzz.urdf", text);
    let mut diagnostics = Vec::new();
    let robot = urdf::read(&sources, id, &mut diagnostics);
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
