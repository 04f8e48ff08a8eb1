//! A model file, from its bytes to code.

use super::{check_refusal, check_report, equations};
use crate::files::root;
use crate::fuzz::Input;
use dynamics_codegen::{Compiled, Library, Report, Variables, compile_bytes, compile_keeping};
use rand::RngExt;
use rand::seq::IteratorRandom;

/// How often all parameters but a few are folded in.
const FOLDED: f64 = 0.2;

pub(super) fn run(input: &Input) -> bool {
    let mut library = Library::builtin();
    library.look_in(root().join("models"));
    let compiled = match compile_bytes(input.file_name(), &input.bytes, &library) {
        Ok(compiled) => compiled,
        Err(report) => {
            check_refusal(&report);
            return false;
        }
    };
    check_report(&compiled.warnings);
    let rng = &mut input.choices();
    if rng.random_bool(FOLDED) {
        let names = compiled.model.parameters.iter().map(|p| p.name.clone());
        let kept = Variables::only(names.sample(rng, 2));
        match folded(input, &library, &kept) {
            Ok(compiled) => equations::check(&compiled, rng),
            Err(report) => check_refusal(&report),
        }
    } else {
        equations::check(&compiled, rng);
    }
    true
}

fn folded(input: &Input, library: &Library, kept: &Variables) -> Result<Compiled, Report> {
    let text = std::str::from_utf8(&input.bytes).expect("a model that compiles is text");
    compile_keeping(input.file_name(), text, library, kept)
}
