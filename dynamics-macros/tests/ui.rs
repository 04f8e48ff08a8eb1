//! What the compiler says about mistakes: `ui/*.rs` with `ui/*.stderr`, which
//! `TRYBUILD=overwrite` writes.

use std::path::{Path, PathBuf};

/// The crate that the fixtures are compiled in has a folder of its own, and models are
/// looked up there.
fn bring_models() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models");
    let crates = target.join("tests/trybuild");
    let to = crates.join(env!("CARGO_PKG_NAME")).join("models");
    for folder in ["", "effects"] {
        std::fs::create_dir_all(to.join(folder)).unwrap();
        let entries = std::fs::read_dir(from.join(folder)).unwrap();
        let files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        for file in files.iter().filter(|file| file.is_file()) {
            std::fs::copy(file, to.join(folder).join(file.file_name().unwrap())).unwrap();
        }
    }
}

#[test]
fn mistakes_are_explained() {
    if left_out::too_slow() {
        return;
    }
    bring_models();
    trybuild::TestCases::new().compile_fail("tests/ui/*.rs");
}
