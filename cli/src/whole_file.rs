//! Files that are there whole or not at all.

use crate::mistake::Mistake;
use crate::pending::{self, Listed};
use dynamics_codegen::file::holds;
use std::fmt;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, PersistError};

/// A file under construction: a temporary one in the same folder, which takes the
/// file's place when everything has been written, and vanishes otherwise.
///
/// What is there already is written through links and keeps its access rights and its owner;
/// what may not be written to is not replaced.
#[derive(Debug)]
pub struct WholeFile {
    /// As the user wrote it.
    path: PathBuf,
    /// Behind all links.
    target: PathBuf,
    // Before its place on the list: a file is on it as long as it is there.
    file: BufWriter<NamedTempFile>,
    _listed: Listed,
}

impl WholeFile {
    /// Begins a file.
    ///
    /// # Errors
    /// If the folder does not exist or cannot be written to, or what has this name is no file
    /// or may not be written to.
    pub fn create(path: &Path) -> Result<Self, Mistake> {
        let target = behind_links(path);
        let old = match fs::metadata(&target) {
            Ok(found) => Some(found),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(unwritable(path, &error)),
        };
        if let Some(old) = &old {
            check_rights(path, &target, old)?;
        }
        let (file, listed) =
            pending::begin(folder_of(&target)).map_err(|error| unwritable(path, &error))?;
        if let Some(old) = &old {
            resemble(file.as_file(), old).map_err(|error| {
                let message = format!(
                    "cannot write `{}`: its owner and rights cannot be kept: {error}",
                    path.display()
                );
                Mistake::new(message).help("write as its owner, or to another file")
            })?;
        }
        Ok(Self {
            path: path.to_path_buf(),
            target,
            file: BufWriter::new(file),
            _listed: listed,
        })
    }

    /// Whether a file can be written here; nothing is changed.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn check(path: &Path) -> Result<(), Mistake> {
        Self::create(path).map(drop)
    }

    /// Writes a file of this text.
    ///
    /// # Errors
    /// As [`create`](Self::create) and [`finish`](Self::finish).
    pub fn write(path: &Path, text: &str) -> Result<(), Mistake> {
        let mut file = Self::create(path)?;
        file.write_all(text.as_bytes())?;
        file.finish()
    }

    /// Adds some bytes.
    ///
    /// # Errors
    /// If there is no room for them.
    pub fn write_all(&mut self, bytes: &[u8]) -> Result<(), Mistake> {
        let written = self.file.write_all(bytes);
        written.map_err(|error| unwritable(&self.path, &error))
    }

    /// Adds some text: what `write!` calls.
    ///
    /// # Errors
    /// If there is no room for it.
    pub fn write_fmt(&mut self, text: fmt::Arguments<'_>) -> Result<(), Mistake> {
        let written = self.file.write_fmt(text);
        written.map_err(|error| unwritable(&self.path, &error))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If the last bytes cannot be written or the file not be renamed.
    pub fn finish(self) -> Result<(), Mistake> {
        self.put(NamedTempFile::persist)
    }

    /// Puts the file in the place of one that was read, if it is still as it was then.
    ///
    /// # Errors
    /// As [`finish`](Self::finish), or if it has changed.
    pub fn replace(self, read: &[u8]) -> Result<(), Mistake> {
        if !holds(&self.target, read) {
            let message = format!(
                "cannot write `{}`: it has changed since it was read",
                self.path.display()
            );
            return Err(Mistake::new(message));
        }
        self.finish()
    }

    /// Puts the file in its place if nothing has taken it in the meantime.
    ///
    /// # Errors
    /// As [`finish`](Self::finish), or if there is a file of that name.
    pub fn finish_new(self) -> Result<(), Mistake> {
        self.put(NamedTempFile::persist_noclobber)
    }

    fn put(
        self,
        persist: impl FnOnce(NamedTempFile, PathBuf) -> Result<File, PersistError>,
    ) -> Result<(), Mistake> {
        let Self {
            path, target, file, ..
        } = self;
        let file = file.into_inner().map_err(io::IntoInnerError::into_error);
        let put = file.and_then(|file| persist(file, target).map_err(|error| error.error));
        put.map(drop).map_err(|error| unwritable(&path, &error))
    }
}

/// Makes a folder for files, if it is not there.
///
/// # Errors
/// If it cannot be made or written to.
pub fn make_folder(folder: &Path) -> Result<(), Mistake> {
    fs::create_dir_all(folder).map_err(|error| {
        let reason = match error.kind() {
            ErrorKind::AlreadyExists | ErrorKind::NotADirectory => {
                "a file of that name is in the way".to_string()
            }
            ErrorKind::PermissionDenied => "permission denied".to_string(),
            _ => format!("the folder cannot be made ({error})"),
        };
        let message = format!("cannot write `{}`: {reason}", folder.display());
        Mistake::new(message).help("choose a folder that you may write to")
    })?;
    match pending::begin(folder) {
        Ok(_) => Ok(()),
        Err(error) => Err(unwritable(folder, &error)),
    }
}

/// Links lead to links at most this often, as the system has it.
const LINKS: usize = 40;

/// The place that a path leads to, whether there is a file yet or not.
fn behind_links(path: &Path) -> PathBuf {
    let mut target = path.to_path_buf();
    for _ in 0..LINKS {
        match fs::read_link(&target) {
            // Where it starts from the root, nothing is left of the folder.
            Ok(next) => target = folder_of(&target).join(next),
            Err(_) => break,
        }
    }
    target
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Whether a file that is there may be written to. The rename that replaces it would not ask.
fn check_rights(path: &Path, target: &Path, old: &Metadata) -> Result<(), Mistake> {
    let refuse = |reason: &str, help: &str| {
        let message = format!("cannot write `{}`: {reason}", path.display());
        Err(Mistake::new(message).help(help))
    };
    if !old.is_file() {
        return refuse("it is not a file", "name a file");
    }
    // The system's own administrator may open everything, so that opening is not enough.
    if old.permissions().readonly() {
        return refuse(
            "it is read-only",
            "change its access rights, or name another file",
        );
    }
    match OpenOptions::new().append(true).open(target) {
        Ok(_) => Ok(()),
        Err(error) => Err(unwritable(path, &error)),
    }
}

/// Gives a new file the owner and the access rights of an old one.
#[cfg(unix)]
fn resemble(file: &File, old: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let new = file.metadata()?;
    if (new.uid(), new.gid()) != (old.uid(), old.gid()) {
        fchown(file, Some(old.uid()), Some(old.gid()))?;
    }
    file.set_permissions(old.permissions())
}

#[cfg(not(unix))]
fn resemble(file: &File, old: &Metadata) -> io::Result<()> {
    file.set_permissions(old.permissions())
}

fn unwritable(path: &Path, error: &io::Error) -> Mistake {
    let folder = folder_of(path).display();
    let because =
        |reason: &str| Mistake::new(format!("cannot write `{}`: {reason}", path.display()));
    match error.kind() {
        ErrorKind::NotFound => {
            because("there is no such folder").help(format!("make `{folder}` first"))
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            because("permission denied").help("choose a folder that you may write to")
        }
        ErrorKind::NotADirectory => {
            because("a file is in the way").help(format!("`{folder}` is not a folder"))
        }
        ErrorKind::AlreadyExists => {
            because("there is such a file by now").help("move it away, or name another file")
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            because("there is no room left").help("make room, or choose another folder")
        }
        _ => because(&error.to_string()),
    }
}
