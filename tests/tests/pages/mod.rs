//! Machines traced, and their pages.

use dynamics_codegen::{Compiled, Library, compile};
use identify::log::Log;
use identify::report::{Page, diff, html};
use identify::trace::{Outcome, Request, trace};
use std::sync::OnceLock;

/// A machine's model and what its logs say about it.
#[derive(Clone)]
pub struct Traced {
    pub file: String,
    pub text: String,
    pub compiled: Compiled,
    pub outcome: Outcome,
}

/// A model of `models/`, traced along the logs of a machine of `data/scenarios`.
pub fn machine(model: &str, id: &str) -> Traced {
    let root = env!("CARGO_MANIFEST_DIR");
    let folder = format!("{root}/data/scenarios/{id}");
    let file = format!("{model}.model");
    let text = std::fs::read_to_string(format!("{root}/../models/{file}")).unwrap();
    let parameters = std::fs::read_to_string(format!("{folder}/parameters.json")).unwrap();
    let read = |name: &str| Log::read(format!("{folder}/{name}")).unwrap();
    let library = Library::builtin();
    let outcome = trace(&Request {
        parameters: serde_json::from_str(&parameters).unwrap(),
        test: Some(&read("test.csv.gz")),
        ..Request::new(model, &text, &library, &read("train.csv.gz"))
    });
    Traced {
        compiled: compile(model, &text, &library).unwrap(),
        outcome: outcome.unwrap(),
        file,
        text,
    }
}

/// A pendulum with friction in its second joint, traced once for all tests.
pub fn pendulum() -> &'static Traced {
    static TRACED: OnceLock<Traced> = OnceLock::new();
    TRACED.get_or_init(|| machine("pendulum2", "o01_pendulum2"))
}

/// The page of a traced machine.
pub fn page(traced: &Traced, command: &str) -> String {
    let Traced {
        file,
        text,
        compiled,
        outcome,
    } = traced;
    let page = Page {
        outcome,
        model: &compiled.model,
        file,
        diff: &diff(file, text, &outcome.patched_model),
        reading: None,
        command,
    };
    html(&page).unwrap()
}
