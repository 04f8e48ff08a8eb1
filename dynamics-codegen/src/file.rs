//! Files that somebody else names: regular ones only, and no more of them than a limit.
//!
//! A path in a model or on a command line may lead to a device that never ends or to a pipe
//! that nobody writes to. Whoever opens files through here neither fills the memory nor hangs.

use std::fs::{File, FileType};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// How large a file may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// What the file is, as messages call it: `a model`.
    pub what: &'static str,
    /// Most bytes.
    pub bytes: u64,
}

/// A file that is being read. What goes on behind the limit is an error, not cut off.
#[derive(Debug)]
pub struct Bounded {
    file: File,
    limit: Limit,
    left: u64,
}

impl Read for Bounded {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        // A file may grow while it is read, and some say that they have no size at all.
        self.left = self
            .left
            .checked_sub(count as u64)
            .ok_or_else(|| self.limit.exceeded())?;
        Ok(count)
    }
}

impl Limit {
    fn exceeded(&self) -> io::Error {
        let Self { what, bytes } = self;
        let most = match bytes >> 20 {
            0 => format!("{bytes} bytes"),
            mebibytes => format!("{mebibytes} MiB"),
        };
        let message = format!("it is larger than {what} may be ({most})");
        io::Error::new(ErrorKind::FileTooLarge, message)
    }
}

/// Opens a regular file.
///
/// # Errors
/// If the system will not let us; [`ErrorKind::InvalidInput`] if it is a pipe or a device,
/// [`ErrorKind::IsADirectory`] if it is a folder, [`ErrorKind::FileTooLarge`] if it is larger
/// than `limit`.
pub fn open(path: &Path, limit: Limit) -> io::Result<Bounded> {
    // Before it is opened: that may take until somebody writes to the pipe.
    let found = std::fs::metadata(path)?;
    if found.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !found.is_file() {
        let message = format!("it is {}, not a file", kind(found.file_type()));
        return Err(io::Error::new(ErrorKind::InvalidInput, message));
    }
    if found.len() > limit.bytes {
        return Err(limit.exceeded());
    }
    Ok(Bounded {
        file: File::open(path)?,
        limit,
        left: limit.bytes,
    })
}

/// The bytes of a regular file.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path, limit: Limit) -> io::Result<Vec<u8>> {
    let mut file = open(path, limit)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a regular file.
///
/// # Errors
/// As [`open`]; [`ErrorKind::InvalidData`] if it is not UTF-8.
pub fn read_text(path: &Path, limit: Limit) -> io::Result<String> {
    let mut text = String::new();
    open(path, limit)?.read_to_string(&mut text)?;
    Ok(text)
}

/// Whether a regular file is there and holds these bytes and no others.
pub fn holds(path: &Path, bytes: &[u8]) -> bool {
    let limit = Limit {
        what: "what it is compared with",
        bytes: bytes.len() as u64,
    };
    read(path, limit).is_ok_and(|found| found == bytes)
}

#[cfg(unix)]
fn kind(found: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    if found.is_fifo() {
        "a pipe"
    } else if found.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(not(unix))]
fn kind(_: FileType) -> &'static str {
    "a device"
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Limit = Limit {
        what: "a note",
        bytes: 4,
    };

    #[test]
    fn a_file_up_to_the_limit_is_read_and_no_larger_one() {
        let path = std::env::temp_dir().join(format!("dynamics-limit-{}", std::process::id()));
        std::fs::write(&path, "1234").unwrap();
        assert_eq!(read(&path, LIMIT).unwrap(), b"1234");
        assert_eq!(read_text(&path, LIMIT).unwrap(), "1234");
        std::fs::write(&path, "12345").unwrap();
        let error = read(&path, LIMIT).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert_eq!(
            error.to_string(),
            "it is larger than a note may be (4 bytes)"
        );
    }

    /// Files that say that they are empty and are not.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_a_file_says_of_its_size_is_not_believed() {
        let error = read(Path::new("/proc/self/maps"), LIMIT).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_folders_are_no_files() {
        let of = |path: &str| read(Path::new(path), LIMIT).unwrap_err();
        assert_eq!(of("/dev/zero").to_string(), "it is a device, not a file");
        assert_eq!(of("/").kind(), ErrorKind::IsADirectory);
    }
}
