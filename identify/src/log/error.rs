//! What can be wrong with a log: place, expectation, mend.

use super::seen::{self, Missing, Seen};
use std::fmt;
use std::path::{Path, PathBuf};

/// Problems listed in full before the rest is only counted.
const LISTED: usize = 10;

/// Why a log could not be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file could not be opened or read.
    #[error(
        "{}: cannot read the log: {source}\n  mend: give the path of a log that may be read: CSV, plain or gzipped, Parquet, MCAP, db3 or ULog",
        path.display()
    )]
    Open {
        /// The path as given.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file that says how the columns of a log are read.
    #[error(
        "{}: this says how the columns of a log are read, and is no log itself\n  mend: leave it out: it is read with the log of its name, or give it with --map",
        path.display()
    )]
    Map {
        /// The path as given.
        path: PathBuf,
    },
    /// The content is not a usable log.
    #[error("{}", render(path, problems, *omitted))]
    Invalid {
        /// The path as given.
        path: PathBuf,
        /// The first problems, in the order of the file.
        problems: Vec<Problem>,
        /// How many more were found and are not listed.
        omitted: usize,
    },
}

impl LogError {
    /// The columns that the log has, if what they are has to be said.
    pub fn columns(&self) -> Option<&[Seen]> {
        let LogError::Invalid { problems, .. } = self else {
            return None;
        };
        problems.iter().find_map(|problem| match &problem.kind {
            ProblemKind::MissingColumns { found, .. } | ProblemKind::NoHeader { found } => {
                Some(found.as_slice())
            }
            _ => None,
        })
    }

    /// The list of missing columns, if that is what is wrong.
    pub(super) fn missing(&mut self) -> Option<(&mut Vec<Missing>, &[Seen])> {
        let LogError::Invalid { problems, .. } = self else {
            return None;
        };
        problems
            .iter_mut()
            .find_map(|problem| match &mut problem.kind {
                ProblemKind::MissingColumns { missing, found } => Some((missing, found.as_slice())),
                _ => None,
            })
    }
}

fn render(path: &Path, problems: &[Problem], omitted: usize) -> String {
    let total = problems.len() + omitted;
    let noun = if total == 1 { "problem" } else { "problems" };
    let mut text = format!("{}: {total} {noun} in the log", path.display());
    for problem in problems {
        text += &format!("\n  {problem}");
    }
    if omitted > 0 {
        text += &format!("\n  … and {omitted} more");
    }
    text
}

/// Problems collected so far: the first ten in full, the others counted.
#[derive(Debug, Default)]
pub(crate) struct Problems {
    listed: Vec<Problem>,
    omitted: usize,
}

impl Problems {
    pub(crate) fn push(&mut self, line: Option<u64>, column: Option<&str>, kind: ProblemKind) {
        if self.listed.len() < LISTED {
            self.listed.push(Problem {
                line,
                column: column.map(str::to_owned),
                kind,
            });
        } else {
            self.omitted += 1;
        }
    }

    /// One that has no place inside of the file.
    pub(crate) fn whole(kind: ProblemKind) -> Self {
        let mut problems = Self::default();
        problems.push(None, None, kind);
        problems
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    pub(crate) fn into_error(self, path: &Path) -> LogError {
        LogError::Invalid {
            path: path.to_owned(),
            problems: self.listed,
            omitted: self.omitted,
        }
    }
}

/// One problem and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Line of the file, counted from 1, where there is one.
    pub line: Option<u64>,
    /// Name of the column, where there is one.
    pub column: Option<String>,
    /// What is wrong.
    pub kind: ProblemKind,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, &self.column) {
            (Some(line), Some(column)) => write!(f, "line {line}, column `{column}`: ")?,
            (Some(line), None) => write!(f, "line {line}: ")?,
            (None, Some(column)) => write!(f, "column `{column}`: ")?,
            (None, None) => {}
        }
        write!(f, "{}\n    mend: {}", self.kind, self.kind.mend())
    }
}

/// What is wrong: found, expected; [`ProblemKind::mend`] says what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProblemKind {
    /// The file has no content but blank lines and comments.
    #[error("the file is empty; expected a header line and samples")]
    Empty,
    /// There is a header and no sample.
    #[error("the file ends after its header; expected samples")]
    HeaderOnly,
    /// The first bytes are those of another file format.
    #[error("the file is {0}; expected CSV (plain or gzipped), Parquet, MCAP, db3 or ULog")]
    Foreign(&'static str),
    /// A file of a known binary format that is damaged.
    #[error("the file is no sound {format}: {reason}")]
    Damaged {
        /// The format.
        format: &'static str,
        /// What its reader said.
        reason: String,
    },
    /// A file of messages none of which can be read.
    #[error("the file holds no message that can be read; topics: {}", if topics.is_empty() { "none".to_owned() } else { topics.join(", ") })]
    NoMessages {
        /// The topics, each with what is wrong with its messages.
        topics: Vec<String>,
    },
    /// The topic whose stamps are to be used is not there.
    #[error(
        "there is no topic `{topic}`, to whose stamps the log's map brings the others; topics: {}",
        quoted(found)
    )]
    NoTopic {
        /// What the map says.
        topic: String,
        /// The topics that are there.
        found: Vec<String>,
    },
    /// A byte sequence that is no UTF-8.
    #[error("byte {offset} of the text is not UTF-8; expected UTF-8 text")]
    NotUtf8 {
        /// Offset of the first bad byte, counted from 0, after decompression.
        offset: usize,
    },
    /// The gzip stream stops before its end.
    #[error(
        "the gzip stream breaks off after {decoded} decompressed bytes; expected a complete stream"
    )]
    TruncatedGzip {
        /// Bytes decompressed before the end.
        decoded: usize,
    },
    /// The gzip stream is damaged.
    #[error("the gzip stream is damaged after {decoded} decompressed bytes ({reason})")]
    CorruptGzip {
        /// Bytes decompressed before the damage.
        decoded: usize,
        /// What the decoder said.
        reason: String,
    },
    /// Decompressed, the log is larger than allowed.
    #[error("the log is larger than {limit} bytes when decompressed")]
    TooLarge {
        /// The limit in bytes.
        limit: u64,
    },
    /// A piece of a file, which is read as a whole, is larger than allowed.
    #[error("a piece of the file is larger than {limit} bytes when decompressed")]
    PieceTooLarge {
        /// The limit in bytes.
        limit: u64,
    },
    /// More cells than are read.
    #[error("the log has more than {limit} cells")]
    TooManyCells {
        /// The limit.
        limit: u64,
    },
    /// More columns than are read.
    #[error("the log has {found} columns; at most {limit} are read")]
    TooManyColumns {
        /// Columns found.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// The first row consists of numbers only, and no map says what they are.
    #[error("the log has no header: its first row holds numbers")]
    NoHeader {
        /// The columns, named by their numbers from 1 on.
        found: Vec<Seen>,
    },
    /// Two columns share a name.
    #[error("columns {first} and {second} have the same name")]
    DuplicateColumn {
        /// Position of the first of the two, counted from 1.
        first: usize,
        /// Position of the second of the two.
        second: usize,
    },
    /// Columns that are needed are not there.
    #[error("{}", seen::missing(missing, found))]
    MissingColumns {
        /// All of them.
        missing: Vec<Missing>,
        /// The columns that are there.
        found: Vec<Seen>,
    },
    /// A file that is to stand beside another has another number of rows.
    #[error("it has {rows} rows and `{beside}`, which it stands beside, has {expected}")]
    OtherLength {
        /// Its rows.
        rows: usize,
        /// The file of the log itself.
        beside: String,
        /// The rows of that.
        expected: usize,
    },
    /// A file that is to stand beside another has other stamps.
    #[error("its stamp is {stamp} where `{beside}`, which it stands beside, has {expected}")]
    OtherStamps {
        /// Its stamp on the line.
        stamp: f64,
        /// The file of the log itself.
        beside: String,
        /// The stamp of that in the same row.
        expected: f64,
    },
    /// A recording at another rate than the one it is to follow.
    #[error(
        "it was recorded every {step:.6} s and `{after}`, which it follows, every {expected:.6} s"
    )]
    OtherStep {
        /// Its median step.
        step: f64,
        /// The recording before it.
        after: String,
        /// The median step of that.
        expected: f64,
    },
    /// A recording without columns of the one it is to follow.
    #[error(
        "it has no column {} as `{after}` has, which it follows",
        quoted(columns)
    )]
    OtherColumns {
        /// The columns that it lacks.
        columns: Vec<String>,
        /// The recording before it.
        after: String,
    },
    /// A cell that is no number.
    #[error("found `{0}`; expected a finite number")]
    NotANumber(String),
    /// A number with a decimal comma.
    #[error("found `{0}`; expected a number with a decimal point")]
    DecimalComma(String),
    /// NaN or infinity.
    #[error("found `{0}`; expected a finite number")]
    NotFinite(String),
    /// A cell without content.
    #[error("the cell is empty; expected a finite number")]
    EmptyCell,
    /// A row with too many or too few cells.
    #[error("the row has {found} cells; expected {expected} as in the header")]
    Ragged {
        /// Cells in the row.
        found: usize,
        /// Cells in the header.
        expected: usize,
    },
    /// A stamp smaller than the one before.
    #[error("time runs backwards from {previous} s (line {previous_line}) to {stamp} s")]
    TimeBackwards {
        /// The stamp before.
        previous: f64,
        /// Its line.
        previous_line: u64,
        /// The stamp on this line.
        stamp: f64,
    },
    /// The same stamp twice with different values.
    #[error("the stamp {stamp} s repeats that of line {previous_line} with other values")]
    DuplicateStamp {
        /// The stamp.
        stamp: f64,
        /// The line it was first seen on.
        previous_line: u64,
    },
    /// Stamps of another unit.
    #[error("the median step is {step:.0} s; expected seconds")]
    NotSeconds {
        /// The median step.
        step: f64,
    },
    /// Too few samples.
    #[error("the log has {found} samples; expected at least {minimum}")]
    TooShort {
        /// Samples found.
        found: usize,
        /// Samples needed.
        minimum: usize,
    },
    /// A sensor that is frozen for nearly all of the log.
    #[error(
        "the sensor says one value while its coordinate moves, so that {left} samples are left; expected at \
         least {minimum}"
    )]
    Frozen {
        /// Samples in which no sensor is frozen.
        left: usize,
        /// Samples needed.
        minimum: usize,
    },
}

impl ProblemKind {
    /// What the user can do about it.
    pub fn mend(&self) -> String {
        match self {
            Self::Empty | Self::HeaderOnly => "record or export the log again",
            Self::Foreign(_) => "export the log as CSV in UTF-8",
            Self::Damaged { .. } => "copy the file again, or record it to its end",
            Self::NoMessages { .. } => {
                "record joint states, in JSON or CDR with their definitions, or convert the file (CSV, Parquet)"
            }
            Self::NoTopic { .. } => "correct `[time] topic` in the log's map",
            Self::NotUtf8 { .. } => "save the file as UTF-8 (names in ASCII are safest)",
            Self::TruncatedGzip { .. } | Self::CorruptGzip { .. } => {
                "copy the file again, or repair it (`gzip -t` tests it)"
            }
            Self::TooLarge { .. } => "cut the log into parts or lower its rate",
            Self::PieceTooLarge { .. } => "write the log in smaller chunks",
            Self::TooManyCells { .. } => {
                "cut the log into parts, lower its rate, or leave out columns that the model does not need"
            }
            Self::TooManyColumns { .. } => "leave out columns that the model does not need",
            Self::NoHeader { .. } => {
                "say in the log's map which column is which, by its number (`q_arm = { column = 2 }`), or add a header line; if it is there as a comment, remove the leading `#`"
            }
            Self::DuplicateColumn { .. } => "rename or delete one of them",
            Self::MissingColumns { missing, found } => return seen::mend_missing(missing, found),
            Self::OtherLength { .. } => "cut both to the rows that belong together",
            Self::OtherStamps { .. } => "bring both to the same stamps, or leave out the column of stamps of one",
            Self::OtherStep { .. } => "give recordings at one rate, or bring them to one",
            Self::OtherColumns { .. } => "give recordings of the same columns, each with its map if they are called otherwise",
            Self::NotANumber(_) => "correct the cell or delete the row",
            Self::DecimalComma(_) => "export with a decimal point",
            Self::NotFinite(_) => "delete the rows without a measurement; a gap in time is allowed",
            Self::EmptyCell => {
                "delete the rows without a measurement (a gap in time is allowed), or say in the log's map how they are filled: `fill = \"hold\"` or `\"linear\"`"
            }
            Self::Ragged { .. } => "complete the row or delete it (a last row may be cut off)",
            Self::TimeBackwards { .. } => {
                "keep one continuous recording: cut the log there, or sort rows that were shuffled"
            }
            Self::DuplicateStamp { .. } => {
                "write stamps with more digits, or delete one of the rows"
            }
            Self::NotSeconds { step } => {
                let unit = super::health::likely_unit(*step);
                return format!("say in the log's map what they are: `[time] unit = \"{unit}\"`");
            }
            Self::TooShort { .. } => "record for longer or at a higher rate",
            Self::Frozen { .. } => {
                "delete the column if it is a velocity's, which need not be there; repair a position's sensor and record again"
            }
        }
        .to_owned()
    }
}

fn quoted(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
