//! What the build script makes afresh is what is checked in.
#![cfg(feature = "regenerate")]

use std::path::Path;

#[test]
fn the_build_script_makes_what_is_checked_in() {
    let fresh = Path::new(env!("OUT_DIR"));
    let checked_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut count = 0;
    for entry in std::fs::read_dir(fresh).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap();
        let expected = std::fs::read_to_string(&path).unwrap();
        let found = std::fs::read_to_string(checked_in.join(name)).unwrap_or_default();
        assert!(
            found == expected,
            "generated/src/{} is out of date; regenerate it with\n    {}",
            name.display(),
            "DYNAMICS_REGENERATE=1 cargo test -p integration-tests --test generated_is_current"
        );
        count += 1;
    }
    assert!(count >= 9, "eight models and lib.rs, found {count}");
}
