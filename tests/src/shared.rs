//! Data of others, read where it lies: beside the repository, never in it.

use crate::files::root;
use std::path::PathBuf;

/// A file or folder of `../shared`; `None`, with a word, where it is not there.
///
/// # Panics
/// If it is missing and `CI` is set: then a test may not be left out.
pub fn file(path: &str) -> Option<PathBuf> {
    let full = root().join("../shared").join(path);
    if full.exists() {
        return Some(full);
    }
    assert!(
        std::env::var_os("CI").is_none(),
        "../shared/{path} is missing beside the repository"
    );
    println!("left out: ../shared/{path} is not here");
    None
}
