//! What is checked in under `generated/` is what the models give today.

use dynamics_codegen::emit::{self, Emission};
use integration_tests::{files, models};

const COMMAND: &str =
    "DYNAMICS_REGENERATE=1 cargo test -p integration-tests --test generated_is_current";

#[test]
fn rust_modules_are_current() {
    let models = models::all();
    let emissions: Vec<Emission<'_>> = models.iter().map(models::emission).collect();
    let files = emit::rust_crate_of(&emissions).expect("every model has a name of its own");
    let files: Vec<(String, String)> = files.into_iter().map(|f| (f.name, f.text)).collect();
    assert!(files.len() >= 9, "eight models and lib.rs");
    let wrong = files::ensure_folder(&files::root().join("generated/src"), &files, "rs");
    report(&wrong);
}

#[test]
fn c_files_are_current() {
    let models = models::all();
    let files = models.iter().flat_map(|model| models::emission(model).c());
    let files: Vec<(String, String)> = files.map(|f| (f.name, f.text)).collect();
    let folder = files::root().join("generated/c");
    let mut wrong = files::ensure_folder(&folder, &ending(&files, ".h"), "h");
    wrong.extend(files::ensure_folder(&folder, &ending(&files, ".c"), "c"));
    report(&wrong);
}

/// A misspelt name would be passed over.
#[test]
fn every_request_names_a_model() {
    let path = files::root().join("generated/functions.txt");
    let text = std::fs::read_to_string(path).expect("generated/functions.txt is there");
    let models = models::all();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let name = line.split(':').next().expect("the first part");
        let known = models.iter().any(|(_, c)| c.model.name == name);
        assert!(known, "generated/functions.txt: there is no model `{name}`");
    }
}

fn ending(files: &[(String, String)], ending: &str) -> Vec<(String, String)> {
    files
        .iter()
        .filter(|(name, _)| name.ends_with(ending))
        .cloned()
        .collect()
}

/// The modules that `back_ends_agree` tries what no model in `models/` has on.
#[test]
fn the_fixtures_are_current() {
    let fixtures = [models::EVERYTHING, models::TOUCHING].map(|path| {
        let file = emit::rust_file(&models::read(path), path);
        (file.name, file.text)
    });
    let folder = files::root().join("tests/tests/fixtures");
    report(&files::ensure_folder(&folder, &fixtures, "rs"));
}

fn report(wrong: &[String]) {
    assert!(
        wrong.is_empty(),
        "generated/ is out of date; regenerate it with\n    {COMMAND}\n\n{}",
        wrong.join("\n")
    );
}
