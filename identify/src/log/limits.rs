//! How much a log may hold, so that no file fills the memory: a small archive may stand for
//! a text that no machine has room for.

use super::error::ProblemKind;
use dynamics_codegen::file::Limit;
use std::io::{self, ErrorKind, Read};

/// How large the file of a log may be, compressed or not.
pub(super) const FILE: Limit = Limit {
    what: "a log",
    bytes: 1 << 30,
};

/// Most bytes of a log as text, after decompression.
pub(super) const MOST_BYTES: u64 = 1 << 29;

/// Most bytes of messages that are looked at, after decompression; most of a recording may be
/// images, which are stepped over.
pub(super) const MOST_MESSAGE_BYTES: u64 = 1 << 32;

/// Most cells of a log: 256 MiB as numbers, of which reading holds up to three copies. Seven
/// joints with positions, velocities and torques at 1 kHz reach it in 25 minutes.
pub const MOST_CELLS: u64 = 1 << 25;

/// Most columns of a log. A column costs much more than a cell.
pub(super) const MOST_COLUMNS: usize = 10_000;

/// Counts the cells of a text before they are cells: by the marks between them. A mark in a
/// comment or in quotes counts, too, which does not matter at this size.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CellCount {
    line_ends: u64,
    /// Commas, semicolons, tabs: only one of them stands between cells.
    marks: [u64; 3],
}

impl CellCount {
    /// Takes a piece of the text into account.
    pub fn add(&mut self, text: &[u8]) {
        let count = |mark: u8| text.iter().filter(|byte| **byte == mark).count() as u64;
        self.line_ends += count(b'\n');
        for (total, mark) in self.marks.iter_mut().zip([b',', b';', b'\t']) {
            *total += count(mark);
        }
    }

    /// Whether the text has more cells than a log may have.
    pub fn is_exceeded(&self) -> bool {
        self.line_ends + self.marks.into_iter().max().unwrap_or(0) > MOST_CELLS
    }
}

/// A table in text that is read no further than the cell that is one too many, which is an
/// error of kind [`ErrorKind::FileTooLarge`].
#[derive(Debug)]
pub struct Counted<R> {
    inner: R,
    count: CellCount,
}

impl<R> Counted<R> {
    /// Counts what is read from `inner`.
    pub fn new(inner: R) -> Self {
        let count = CellCount::default();
        Self { inner, count }
    }
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.count.add(&buffer[..count]);
        if self.count.is_exceeded() {
            let message = format!("it has more than {MOST_CELLS} cells");
            return Err(io::Error::new(ErrorKind::FileTooLarge, message));
        }
        Ok(count)
    }
}

/// Whether a table of this size may be read.
///
/// # Errors
/// [`ProblemKind::TooManyColumns`] or [`ProblemKind::TooManyCells`].
pub(super) fn check(rows: usize, columns: usize) -> Result<(), ProblemKind> {
    check_columns(columns)?;
    match rows.checked_mul(columns) {
        Some(cells) if cells as u64 <= MOST_CELLS => Ok(()),
        _ => Err(ProblemKind::TooManyCells { limit: MOST_CELLS }),
    }
}

/// Whether a table may have so many columns.
///
/// # Errors
/// [`ProblemKind::TooManyColumns`].
pub(super) fn check_columns(found: usize) -> Result<(), ProblemKind> {
    let limit = MOST_COLUMNS;
    match found <= limit {
        true => Ok(()),
        false => Err(ProblemKind::TooManyColumns { found, limit }),
    }
}
