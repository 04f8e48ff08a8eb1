//! Measured logs: from a file to checked channels.
//!
//! A log is a table with one row per sample and a header that names the
//! columns: `t` \[s\], `q_<name>` position, `dq_<name>` velocity, `ddq_<name>`
//! acceleration of the coordinate `<name>`, `u_<name>` the input of that
//! name; anything else is kept as an extra channel. SI units, radians. A log that is not
//! like that gets a [`Map`], a small TOML file beside it.
//!
//! Formats: CSV, plain or gzipped; Parquet; messages in JSON or CDR in MCAP and db3 files, as ROS 2
//! records them; ULog. `docs/log-format.md` has the whole.
//!
//! Accepted as they are: gzip (recognised by its first bytes), a UTF-8 byte
//! order mark, Windows line ends, comma, semicolon or tab between cells,
//! spaces around names and numbers, blank lines, lines that start with `#`. Dropped, with a warning:
//! bytes that are no text at the ends, a last row that breaks off. Everything else that is not a finite number in its place is refused with
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
mod beside;
mod cdr;
mod doubt;
mod ends;
mod error;
mod follow;
mod frozen;
pub(crate) mod health;
mod json;
mod limits;
mod map;
mod mcap;
mod numbered;
mod parquet;
mod quantum;
mod record;
mod rosbag;
mod said;
mod seen;
mod sensed;
mod source;
mod spikes;
mod statistics;
mod table;
mod text;
mod ticks;
mod time;
mod topics;
mod ulog;
mod wanted;
mod warning;

pub use aside::Aside;
pub(crate) use aside::is_aside;
pub use doubt::Doubt;
pub use error::{LogError, Problem, ProblemKind};
pub use limits::{Counted, MOST_CELLS};
pub use map::{Map, MapError, template, too_deep};
pub use quantum::quantisation_step;
pub use record::Record;
pub(crate) use record::{evenly_spread, longest_step, median_step, segments, stretches};
pub(crate) use said::said_of;
pub use seen::{Glance, Missing, Seen};
pub use sensed::{Gauge, Reading, Sensed};
pub(crate) use spikes::{BESIDE, ORDINARY, RARE, ordinary_sizes, stands_out};
pub(crate) use statistics::{mad_sd, median, rms, share_of_news};
pub use wanted::{Axis, Wanted};
pub use warning::Warning;

use dynamics_codegen::file;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use table::{Cell, Demand, Table};

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
    /// Columns of topics that nobody asked for: they were not read.
    pub unread: Vec<String>,
    /// Recordings that follow the first: the first sample of each, and its file.
    pub followed: Vec<(usize, PathBuf)>,
    /// What was set aside while reading (repeated rows, columns of text).
    pub warnings: Vec<Warning>,
}

impl Log {
    /// Reads a log from a file.
    ///
    /// # Errors
    ///
    /// [`LogError::Open`] when the file cannot be read, [`LogError::Map`] when it is one that says how logs are
    /// read, [`LogError::Invalid`] with up to ten problems when its content cannot be used.
    pub fn read(path: impl AsRef<Path>) -> Result<Log, LogError> {
        Log::read_with(path, None)
    }

    /// As [`Log::read`], for a log whose columns a [`Map`] explains.
    ///
    /// # Errors
    ///
    /// As [`Log::read`]; also when a column that the map names is not there, or a file that it
    /// puts beside the log does not belong there.
    pub fn read_with(path: impl AsRef<Path>, map: Option<&Map>) -> Result<Log, LogError> {
        let path = path.as_ref();
        if path.extension().is_some_and(|end| end == "toml") {
            return Err(LogError::Map {
                path: path.to_owned(),
            });
        }
        let bytes = bytes(path)?;
        let demand = Demand { map, before: 0 };
        let mut table = source::table(path, &bytes, demand)?;
        table.warnings.extend(rosbag::left_behind(path, &bytes));
        drop(bytes);
        for other in map.iter().flat_map(|map| map.beside_log(path)) {
            let before = table.columns.len();
            let there = source::table(&other, &self::bytes(&other)?, Demand { map, before })?;
            beside::join(&mut table, there, path, &other)?;
        }
        Log::from_table(path, table, map)
    }

    /// Reads a log from the bytes of a file; `path` is its name in messages.
    ///
    /// # Errors
    ///
    /// [`LogError::Invalid`], as for [`Log::read`].
    pub fn from_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<Log, LogError> {
        Log::from_bytes_with(path, bytes, None)
    }

    /// As [`Log::from_bytes`], for a log whose columns a [`Map`] explains. Files that it puts
    /// beside the log are not looked at.
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
        let table = source::table(path, bytes, Demand { map, before: 0 })?;
        Log::from_table(path, table, map)
    }

    /// A log from columns of numbers that are no file; `name` is what messages call it. Rows are
    /// counted from 1. Files that the map puts beside the log are not looked at.
    ///
    /// # Errors
    ///
    /// As [`Log::read_with`]; columns of different lengths are refused as cells that are empty.
    pub fn from_columns(
        name: impl AsRef<Path>,
        columns: Vec<(String, Vec<f64>)>,
        map: Option<&Map>,
    ) -> Result<Log, LogError> {
        let name = name.as_ref();
        let rows = columns.iter().map(|(_, values)| values.len()).max();
        let cells = |values: Vec<f64>| {
            let missing = rows.unwrap_or(0) - values.len();
            let cells = values.into_iter().map(Cell::Number);
            cells
                .chain(std::iter::repeat_n(Cell::Empty, missing))
                .collect()
        };
        let columns = columns.into_iter();
        let columns = columns.map(|(name, values)| (name, cells(values)));
        let table = table::from_columns(columns.collect(), Demand { map, before: 0 })
            .map_err(|found| found.into_error(name))?;
        Log::from_table(name, table, map)
    }

    fn from_table(path: &Path, mut table: Table, map: Option<&Map>) -> Result<Log, LogError> {
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
            unread: table.unread,
            followed: Vec::new(),
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

    /// Columns that the log has, whether they were read or not.
    fn seen(&self) -> Vec<Seen> {
        let unread = self.unread.iter().map(String::as_str);
        self.columns()
            .into_iter()
            .chain(unread)
            .map(Seen::named)
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
        self.select_sensed(coordinates, inputs, &[])
    }

    /// The same of a model whose sensors are `gauges`, vectors by components. Where the log has a
    /// column of one of them, positions may be missing: [`Record::sensed`] holds what there is
    /// in their place.
    ///
    /// # Errors
    /// As [`Log::select`], if the log has neither all positions nor a sensor.
    pub fn select_sensed(
        &self,
        coordinates: &[String],
        inputs: &[String],
        gauges: &[Gauge],
    ) -> Result<Record, LogError> {
        record::select(self, coordinates, inputs, gauges)
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>, LogError> {
    file::read(path, limits::FILE).map_err(|source| LogError::Open {
        path: path.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod binary_tests;
