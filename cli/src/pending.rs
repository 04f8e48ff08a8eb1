//! Files under construction. They vanish with the program, also if a signal ends it.

use crate::signals;
use std::collections::BTreeSet;
use std::fs::{self, Permissions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

static PENDING: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn pending() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PENDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file's place on the list of those that a signal removes; left when it is dropped.
#[derive(Debug)]
pub struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        pending().remove(&self.0);
    }
}

/// Begins a file in a folder, with the access rights that a new file gets.
///
/// # Errors
/// If the system will not let us.
pub fn begin(folder: &Path) -> io::Result<(NamedTempFile, Listed)> {
    signals::watch()?;
    // Held until the file is listed: a signal waits that long.
    let mut pending = pending();
    let mut builder = tempfile::Builder::new();
    builder.prefix(".dynamics-");
    if let Some(permissions) = of_a_new_file() {
        builder.permissions(permissions);
    }
    let file = builder.tempfile_in(folder)?;
    pending.insert(file.path().to_path_buf());
    let listed = Listed(file.path().to_path_buf());
    Ok((file, listed))
}

/// What the system's mask is taken off.
#[cfg(unix)]
fn of_a_new_file() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn of_a_new_file() -> Option<Permissions> {
    None
}

/// Removes what is on the list. As long as the answer is kept no file is begun.
pub fn remove_all() -> impl Sized {
    let pending = pending();
    for path in pending.iter() {
        // One that has just taken its place is not there any more.
        fs::remove_file(path).ok();
    }
    pending
}
