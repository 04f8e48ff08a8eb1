//! Checked-in files that a program makes.

use std::io::Write;
use std::path::{Path, PathBuf};

/// Set to `1` to write the files instead of comparing them.
pub const SWITCH: &str = "DYNAMICS_REGENERATE";

/// The workspace's folder.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the crate lies in the workspace")
        .to_path_buf()
}

/// Compares the files of a folder with what they should be, or, if [`SWITCH`] is set,
/// makes them so. Files with the same ending that should not be there count as well.
///
/// Returns what is wrong, one line per file; empty if nothing is.
pub fn ensure_folder(folder: &Path, files: &[(String, String)], ending: &str) -> Vec<String> {
    let write = std::env::var(SWITCH).is_ok_and(|value| value == "1");
    let mut wrong = Vec::new();
    for (name, text) in files {
        let path = folder.join(name);
        let found = std::fs::read_to_string(&path).ok();
        if found.as_ref() == Some(text) {
            continue;
        }
        if write {
            write_atomically(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        } else {
            wrong.push(match found {
                Some(found) => format!("{}: {}", path.display(), first_difference(&found, text)),
                None => format!("{}: missing", path.display()),
            });
        }
    }
    for stray in strays(folder, files, ending) {
        if write {
            std::fs::remove_file(&stray).unwrap_or_else(|e| panic!("{}: {e}", stray.display()));
        } else {
            wrong.push(format!("{}: belongs to no model", stray.display()));
        }
    }
    wrong
}

/// All or nothing: written beside its place, then moved there.
pub fn write_atomically(path: &Path, text: &str) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::Builder::new()
        .permissions(plain())
        .tempfile_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// The rights of an ordinary file; a temporary one is the owner's alone.
fn plain() -> std::fs::Permissions {
    #[cfg(unix)]
    {
        std::os::unix::fs::PermissionsExt::from_mode(0o644)
    }
    #[cfg(not(unix))]
    {
        std::fs::metadata(env!("CARGO_MANIFEST_DIR"))
            .expect("the crate's folder is there")
            .permissions()
    }
}

/// The files with this ending, sorted; none if there is no such folder.
pub fn in_folder(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<PathBuf> = paths
        .filter(|path| path.extension().is_some_and(|e| e == ending))
        .collect();
    found.sort();
    found
}

fn strays(folder: &Path, files: &[(String, String)], ending: &str) -> Vec<PathBuf> {
    let known = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        files.iter().any(|(known, _)| *known == name)
    };
    let found = in_folder(folder, ending).into_iter();
    found.filter(|path| !known(path)).collect()
}

fn first_difference(found: &str, expected: &str) -> String {
    let mut lines = found.lines().zip(expected.lines()).enumerate();
    match lines.find(|(_, (a, b))| a != b) {
        Some((index, (a, b))) => {
            format!(
                "line {}\n    checked in: {a}\n    fresh:      {b}",
                index + 1
            )
        }
        None => "one is longer than the other".to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_differs_what_is_missing_and_what_is_left_over() {
        let folder = tempfile::tempdir().unwrap();
        write_atomically(&folder.path().join("a.rs"), "one\ntwo\n").unwrap();
        write_atomically(&folder.path().join("old.rs"), "").unwrap();
        write_atomically(&folder.path().join("note.txt"), "").unwrap();
        let files = [("a.rs", "one\nthree\n"), ("b.rs", "")].map(|(n, t)| (n.into(), t.into()));
        let wrong = ensure_folder(folder.path(), &files, "rs");
        assert_eq!(wrong.len(), 3, "{wrong:?}");
        assert!(wrong[0].contains("line 2"));
        assert!(wrong[1].contains("missing"));
        assert!(wrong[2].contains("old.rs"));
    }
}
