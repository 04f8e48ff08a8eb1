//! Measured logs: from a file to checked channels.
//!
//! A log is a table with one row per sample and a header that names the
//! columns: `t` \[s\], `q_<name>` position, `dq_<name>` velocity, `ddq_<name>`
//! acceleration of the coordinate `<name>`, `u_<name>` the input of that
//! name; anything else is kept as an extra channel. SI units, radians. A log that is not
//! like that gets a [`Map`], a small TOML file beside it.
//!
//! Formats: CSV, plain or gzipped; behind the feature `parquet` Parquet; behind the feature
//! `mcap` MCAP with messages in JSON. `docs/log-format.md` has the whole.
//!
//! Accepted as they are: gzip (recognised by its first bytes), a UTF-8 byte
//! order mark, Windows line ends, comma, semicolon or tab between cells,
//! spaces around names and numbers, blank lines, lines that start with `#`.
//! Everything else that is not a finite number in its place is refused with
//! the line, the column, what was expected and how to mend it, several
//! problems at once. What can be used but should be known — gaps, jitter,
//! wrapped angles, wild samples, stuck or quantised channels, saturated inputs — comes
//! back as a [`Warning`].
//!
//! ```
//! use identify::log::Log;
//!
//! let mut text = String::from("t,q_joint,u_joint\n");
//! for k in 0..60 {
//!     let t = 0.01 * f64::from(k);
//!     text += &format!("{t},{},{}\n", (3.0 * t).sin(), (5.0 * t).cos());
//! }
//! let log = Log::from_bytes("swing.csv", text.as_bytes())?;
//! let joint = ["joint".to_owned()];
//! let record = log.select(&joint, &joint)?;
//! assert_eq!(record.q[0].len(), 60);
//! assert!(record.dq[0].is_none());
//! # Ok::<(), identify::log::LogError>(())
//! ```

mod aside;
mod assumed;
mod error;
mod frozen;
pub(crate) mod health;
mod limits;
mod map;
#[cfg(feature = "mcap")]
mod mcap;
mod numbered;
#[cfg(feature = "parquet")]
mod parquet;
mod quantum;
mod record;
mod said;
mod source;
mod spikes;
mod statistics;
mod table;
mod time;
mod warning;

pub use aside::Aside;
pub(crate) use aside::is_aside;
pub use error::{LogError, Problem, ProblemKind};
pub use limits::{Counted, MOST_CELLS};
pub use map::{Map, MapError, template};
pub use quantum::quantisation_step;
pub use record::Record;
pub(crate) use record::{longest_step, median_step, segments, stretches};
pub(crate) use said::said_of;
pub(crate) use statistics::{mad_sd, median, rms, share_of_news};
pub use warning::Warning;

use dynamics_codegen::file;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use table::Demand;

/// Fewest samples a log must have: three windows of the shortest filter used
/// downstream, and enough for a held-out block.
pub const MINIMUM_SAMPLES: usize = 50;

/// A log as read: time stamps and every numeric column of the file.
///
/// Stamps increase strictly, all channels have the length of [`Log::t`], and
/// every value is finite.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Where the log came from, as shown in messages.
    pub path: PathBuf,
    /// Time stamps \[s\], strictly increasing, length n.
    pub t: Vec<f64>,
    /// Column name → values, each of length n; `t` is not among them.
    pub channels: BTreeMap<String, Vec<f64>>,
    /// Line of the file each sample stands on, length n; where there are no lines, its
    /// number, counted from 1.
    pub lines: Vec<u64>,
    /// What was set aside while reading (repeated rows, columns of text).
    pub warnings: Vec<Warning>,
}

impl Log {
    /// Reads a log from a file: CSV, plain or gzipped, or what features add.
    ///
    /// # Errors
    ///
    /// [`LogError::Open`] when the file cannot be read, [`LogError::Invalid`]
    /// with up to ten problems when its content cannot be used.
    pub fn read(path: impl AsRef<Path>) -> Result<Log, LogError> {
        Log::read_with(path, None)
    }

    /// As [`Log::read`], for a log whose columns a [`Map`] explains.
    ///
    /// # Errors
    ///
    /// As [`Log::read`]; also when a column that the map names is not there.
    pub fn read_with(path: impl AsRef<Path>, map: Option<&Map>) -> Result<Log, LogError> {
        let path = path.as_ref();
        let bytes = file::read(path, limits::FILE).map_err(|source| LogError::Open {
            path: path.to_owned(),
            source,
        })?;
        Log::from_bytes_with(path, &bytes, map)
    }

    /// Reads a log from the bytes of a file; `path` is its name in messages.
    ///
    /// # Errors
    ///
    /// [`LogError::Invalid`], as for [`Log::read`].
    pub fn from_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<Log, LogError> {
        Log::from_bytes_with(path, bytes, None)
    }

    /// As [`Log::from_bytes`], for a log whose columns a [`Map`] explains.
    ///
    /// # Errors
    ///
    /// As [`Log::read_with`].
    pub fn from_bytes_with(
        path: impl AsRef<Path>,
        bytes: &[u8],
        map: Option<&Map>,
    ) -> Result<Log, LogError> {
        let path = path.as_ref();
        let mut table = source::table(path, bytes, Demand { map })?;
        if let Some(map) = map {
            map.apply(&mut table)
                .map_err(|found| found.into_error(path))?;
        }
        time::check(&mut table).map_err(|found| found.into_error(path))?;
        let mut channels: BTreeMap<String, Vec<f64>> = table
            .columns
            .into_iter()
            .map(|column| (column.name, column.values))
            .collect();
        let t = channels.remove("t").unwrap_or_default();
        Ok(Log {
            path: path.to_owned(),
            t,
            channels,
            lines: table.lines,
            warnings: table.warnings,
        })
    }

    /// Number of samples n.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether the log has no sample; never true of a log that was read.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Names of the columns, `t` first, the others in alphabetical order.
    pub fn columns(&self) -> Vec<&str> {
        std::iter::once("t")
            .chain(self.channels.keys().map(String::as_str))
            .collect()
    }

    /// Takes out the channels of a model: `q_<name>` (required), `dq_<name>`
    /// and `ddq_<name>` (where present) of every coordinate, `u_<name>`
    /// (required) of every input, in the order given.
    ///
    /// Wrapped angles are unwrapped, and the health of the chosen channels is
    /// reported in [`Record::warnings`].
    ///
    /// # Errors
    ///
    /// [`LogError::Invalid`] that lists every missing column, the columns
    /// found and the nearest name.
    pub fn select(&self, coordinates: &[String], inputs: &[String]) -> Result<Record, LogError> {
        record::select(self, coordinates, inputs)
    }
}

#[cfg(test)]
mod tests;

#[cfg(all(test, any(feature = "parquet", feature = "mcap")))]
mod binary_tests;
