//! Where results go: standard output, or a file that is there whole or not at all.

use crate::mistake::Mistake;
use anyhow::Context;
use std::fs;
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Whether messages may be coloured: on a terminal, unless `NO_COLOR` says otherwise.
pub fn colours_on_stderr() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Says something on standard error.
pub fn complain(text: &str) {
    // Nobody is left to hear that standard error is closed.
    writeln!(io::stderr(), "{text}").ok();
}

/// Says something on standard error that does not stop the work.
pub fn warn(mistake: &Mistake) {
    complain(&mistake.render_as_warning(colours_on_stderr()));
}

/// Standard output, buffered; a closed pipe comes back as an error, not a panic.
pub fn stdout() -> BufWriter<io::StdoutLock<'static>> {
    BufWriter::new(io::stdout().lock())
}

/// A file under construction: a temporary one in the same folder, which takes the
/// file's place when everything has been written, and vanishes otherwise.
#[derive(Debug)]
pub struct WholeFile {
    target: PathBuf,
    file: BufWriter<NamedTempFile>,
}

impl WholeFile {
    /// Begins a file.
    ///
    /// # Errors
    /// If the folder does not exist or cannot be written to, or something other
    /// than a file has this name.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        // Through a link, its target is replaced, not the link.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if fs::metadata(&target).is_ok_and(|found| !found.is_file()) {
            let message = format!("cannot write `{}`: it is not a file", path.display());
            return Err(Mistake::new(message).help("name a file").into());
        }
        let folder = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let file = temporary(folder).map_err(|error| unwritable(path, folder, error))?;
        Ok(Self {
            target,
            file: BufWriter::new(file),
        })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If the last bytes cannot be written or the file not be renamed.
    pub fn finish(self) -> anyhow::Result<()> {
        let Self { target, file } = self;
        let file = file.into_inner().map_err(io::IntoInnerError::into_error);
        file.and_then(|file| file.persist(&target).map_err(|error| error.error))
            .with_context(|| format!("cannot write `{}`", target.display()))?;
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// A temporary file with the access rights that a new file gets.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".dynamics-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

fn unwritable(path: &Path, folder: &Path, error: io::Error) -> anyhow::Error {
    let help = match error.kind() {
        ErrorKind::NotFound => format!("create the folder `{}` first", folder.display()),
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to".to_string()
        }
        ErrorKind::NotADirectory => format!("`{}` is not a folder", folder.display()),
        _ => {
            let context = format!("cannot write `{}`", path.display());
            return anyhow::Error::new(error).context(context);
        }
    };
    let message = format!("cannot write `{}`: {}", path.display(), error.kind());
    Mistake::new(message).help(help).into()
}
