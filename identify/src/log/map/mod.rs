//! What the columns of a log are: a small TOML file beside it.
//!
//! A log that does not name its columns as a model names its coordinates, or that does not
//! measure in SI, gets a map: `arm.toml` for the log `arm.csv`. Every channel of the model
//! is a linear function of columns,
//!
//! ```text
//! channel = sign · factor · unit · column + offset        or        Σ factorᵢ · unitᵢ · columnᵢ + offset
//! ```
//!
//! and a transmission with motor angles `q_m = R q` gives `q = R⁻¹ q_m + offset`,
//! `q̇ = R⁻¹ q̇_m`, `u = Rᵀ u_m`, the last since both sides have the same power. All keys are
//! described in `docs/log-format.md`.
//!
//! ```
//! use identify::log::{Log, Map};
//!
//! let map = Map::parse("swing.toml", r#"
//!     time = { column = "stamp", unit = "ms" }
//!     [columns]
//!     q_joint = { column = "angle", unit = "deg", sign = -1, offset = 0.5 }
//! "#)?;
//! let mut text = String::from("stamp,angle\n");
//! for k in 0..60 {
//!     text += &format!("{},{}\n", 10 * k, 2 * k);
//! }
//! let log = Log::from_bytes_with("swing.csv", text.as_bytes(), Some(&map))?;
//! assert!((log.t[1] - 0.01).abs() < 1e-15);
//! assert!((log.channels["q_joint"][30] - (0.5 - 60_f64.to_radians())).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod apply;
mod file;
mod nesting;
mod template;
mod transmission;
mod unit;

pub use nesting::too_deep;
pub use template::template;

use dynamics_codegen::file::{Limit, read_text};
use file::{Column, File, Fill, KEYS, Time};
use nesting::DEEPEST;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A map is a page, not a data set.
const LIMIT: Limit = Limit {
    what: "a map",
    bytes: 1 << 20,
};

/// Why a map could not be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{}: {message}\n  mend: {mend}", path.display(), line.map(|line| format!(":{line}")).unwrap_or_default())]
pub struct MapError {
    /// The map.
    pub path: PathBuf,
    /// The line, counted from 1, where there is one.
    pub line: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub mend: String,
}

/// What the columns of a log are.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Where it came from, as shown in messages.
    pub path: PathBuf,
    clock: Clock,
    /// The time of the first sample, if stated.
    start: Option<f64>,
    /// The topic to whose stamps the others are brought, if stated.
    topic: Option<String>,
    /// Files that stand beside the log.
    beside: Vec<String>,
    channels: Vec<Channel>,
}

/// Where the time stamps come from.
#[derive(Debug, Clone, PartialEq)]
enum Clock {
    /// A column, and what one of its units is in seconds.
    Column(String, f64),
    /// A rate in Hz.
    Rate(f64),
}

/// A channel of the model as a linear function of columns.
#[derive(Debug, Clone, PartialEq)]
struct Channel {
    name: String,
    terms: Vec<Term>,
    offset: f64,
}

/// A column with what it is multiplied by.
#[derive(Debug, Clone, PartialEq)]
struct Term {
    column: String,
    factor: f64,
    wrap: Wrap,
    fill: Option<Fill>,
}

/// How a column that starts anew after a turn is made continuous.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wrap {
    /// It does not.
    None,
    /// It may, at this many of its units, if it looks like it.
    Suspected(f64),
    /// It does, as the map says.
    Stated(f64),
}

/// Stands for a log's own name in the names of files beside it.
const LOG: &str = "{log}";

/// Most files beside a log.
const MOST_BESIDE: usize = 16;

/// Prefixes of channels.
pub(super) const PREFIXES: [&str; 4] = ["q_", "dq_", "ddq_", "u_"];
/// What comes before the name of an input as it was commanded.
pub(super) const COMMANDED: &str = "ucmd_";

impl Map {
    /// Where the map of a log is looked for: `arm.toml` beside `arm.csv` (or `arm.csv.gz`,
    /// `arm.parquet`, `arm.mcap`, `arm.db3`, `arm.ulg`).
    pub fn beside(log: &Path) -> PathBuf {
        let mut name = Map::stem(log).into_os_string();
        name.push(".toml");
        PathBuf::from(name)
    }

    /// The path of a log without its endings.
    fn stem(log: &Path) -> PathBuf {
        let mut stem = log.to_owned();
        for ending in ["gz", "csv", "tsv", "txt", "parquet", "mcap", "db3", "ulg"] {
            if stem.extension().is_some_and(|found| found == ending) {
                stem.set_extension("");
            }
        }
        stem
    }

    /// Reads a map.
    ///
    /// # Errors
    /// [`MapError`], with the line.
    pub fn read(path: &Path) -> Result<Map, MapError> {
        let text = read_text(path, LIMIT).map_err(|error| MapError {
            path: path.to_owned(),
            line: None,
            message: format!("cannot read the map: {error}"),
            mend: "give the path of a TOML file in UTF-8 that may be read".to_owned(),
        })?;
        Map::parse(path, &text)
    }

    /// A map from its text; `path` is its name in messages.
    ///
    /// # Errors
    /// [`MapError`], with the line.
    pub fn parse(path: impl AsRef<Path>, text: &str) -> Result<Map, MapError> {
        let reader = Reader {
            path: path.as_ref(),
            text,
        };
        reader.map()
    }

    /// The columns that a log must have, with what each is for.
    pub(super) fn columns(&self) -> impl Iterator<Item = (&str, String)> {
        let time = match &self.clock {
            Clock::Column(name, _) => Some((name.as_str(), "the time stamps".to_owned())),
            Clock::Rate(_) => None,
        };
        let terms = self.channels.iter().flat_map(|channel| {
            let role = format!("what `{}` says `{}` is", self.path.display(), channel.name);
            let columns = channel.terms.iter().map(|term| term.column.as_str());
            columns.map(move |column| (column, role.clone()))
        });
        time.into_iter().chain(terms)
    }

    /// The channels that it makes of columns.
    pub(super) fn channels(&self) -> impl Iterator<Item = &str> {
        self.channels.iter().map(|channel| channel.name.as_str())
    }

    /// The topic to whose stamps the others are to be brought.
    pub(super) fn topic(&self) -> Option<&str> {
        self.topic.as_deref()
    }

    /// The files that stand beside a log: their columns are columns of the log, too.
    pub(super) fn beside_log(&self, log: &Path) -> Vec<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let stem = Map::stem(log);
        let stem = stem.file_name().unwrap_or_default().to_string_lossy();
        let path = |name: &String| folder.join(name.replace(LOG, &stem));
        self.beside.iter().map(path).collect()
    }

    /// A file that this map puts beside each of several logs, since its name does not contain
    /// `{log}`.
    pub fn beside_all(&self) -> Option<&str> {
        let mut names = self.beside.iter();
        names.find(|name| !name.contains(LOG)).map(String::as_str)
    }

    /// Whether cells of this column may be empty.
    pub(super) fn fills(&self, column: &str) -> bool {
        let mut terms = self.channels.iter().flat_map(|channel| &channel.terms);
        terms.any(|term| term.column == column && term.fill.is_some())
    }
}

/// Turns the file into a map; all that can be wrong with it has a place here.
struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Reader<'_> {
    fn map(&self) -> Result<Map, MapError> {
        if let Some(at) = too_deep(self.text) {
            let message = format!("brackets nest more than {DEEPEST} deep");
            let mend = "close each `{` and `[` in the line that opens it";
            return Err(self.fault(Some(at..at + 1), message, mend));
        }
        self.refuse_what_is_no_map()?;
        let file: File = toml::from_str(self.text).map_err(|error| {
            let message = error.message().trim_end().to_owned();
            self.fault(
                error.span(),
                message,
                "`docs/log-format.md` has all keys, with examples",
            )
        })?;
        let start = file.time.start.as_ref().map(|start| self.finite(start));
        let mut map = Map {
            path: self.path.to_owned(),
            clock: self.clock(&file.time)?,
            start: start.transpose()?,
            topic: file.time.topic.clone(),
            beside: self.beside(&file.files.beside)?,
            channels: Vec::new(),
        };
        for (name, column) in &file.columns {
            self.check_name(name)?;
            let channel = self.channel(name, column)?;
            map.channels.push(channel);
        }
        for (name, column) in &file.sensors {
            self.check_sensor(name)?;
            let channel = self.channel(name, column)?;
            map.channels.push(channel);
        }
        for transmission in &file.transmission {
            let channels = self.transmission(transmission)?;
            map.channels.extend(channels);
        }
        let mut known = BTreeSet::new();
        if let Some(twice) = map.channels.iter().find(|c| !known.insert(&c.name)) {
            let message = format!("`{}` is stated twice", twice.name);
            return Err(self.fault(
                None,
                message,
                "keep it under `[columns]` or in one transmission",
            ));
        }
        let bare = Map {
            path: map.path.clone(),
            clock: Clock::Column("t".to_owned(), 1.0),
            start: None,
            topic: None,
            beside: Vec::new(),
            channels: Vec::new(),
        };
        if map == bare {
            let mend = "state the channels: `q_arm = { column = \"angle\", unit = \"deg\" }` under `[columns]`";
            return Err(self.fault(None, "the map says nothing".to_owned(), mend));
        }
        Ok(map)
    }

    fn clock(&self, time: &Time) -> Result<Clock, MapError> {
        let Some(rate) = &time.rate else {
            let second = time.unit.as_ref().map_or(Ok(1.0), |unit| self.unit(unit))?;
            let column = time
                .column
                .as_ref()
                .map(|column| column.get_ref().0.clone());
            return Ok(Clock::Column(
                column.unwrap_or_else(|| "t".to_owned()),
                second,
            ));
        };
        let column = time.column.as_ref().map(|column| ("column", column.span()));
        let unit = time.unit.as_ref().map(|unit| ("unit", unit.span()));
        if let Some((key, span)) = column.or(unit) {
            let message = format!("`rate` and `{key}` exclude each other");
            let mend = "state the `rate` of a log without stamps, or the `column` of stamps and its `unit`";
            return Err(self.fault(Some(span), message, mend));
        }
        let value = self.finite(rate)?;
        if value > 0.0 {
            return Ok(Clock::Rate(value));
        }
        let message = format!("`rate` is {value}; expected samples per second");
        Err(self.fault(Some(rate.span()), message, "for instance 1000"))
    }

    fn beside(&self, stated: &[Spanned<String>]) -> Result<Vec<String>, MapError> {
        if let Some(one_more) = stated.get(MOST_BESIDE) {
            let message = format!(
                "{} files stand beside the log; at most {MOST_BESIDE} are read",
                stated.len()
            );
            return Err(self.fault(Some(one_more.span()), message, "join some of them"));
        }
        Ok(stated.iter().map(|name| name.get_ref().clone()).collect())
    }

    /// What stands under `[columns]` is about a coordinate or an input.
    fn check_name(&self, name: &Spanned<String>) -> Result<(), MapError> {
        let text = name.get_ref();
        let mut prefixes = PREFIXES.iter().chain(&[COMMANDED]);
        if prefixes.any(|prefix| text.len() > prefix.len() && text.starts_with(prefix)) {
            return Ok(());
        }
        let message = format!("`{text}` is no channel");
        let mend = format!(
            "write `q_{text}` for a position, `dq_` for a velocity, `ddq_` for an acceleration, `u_` for an \
             input; what shows a sensor of the model stands under `[sensors]`"
        );
        Err(self.fault(Some(name.span()), message, &mend))
    }

    /// A sensor is not the clock.
    fn check_sensor(&self, name: &Spanned<String>) -> Result<(), MapError> {
        if name.get_ref() != "t" {
            return Ok(());
        }
        let mend = "a sensor has its name from the model; which column holds the stamps is said under `[time]`";
        Err(self.fault(Some(name.span()), "`t` is the time".to_owned(), mend))
    }

    fn channel(&self, name: &Spanned<String>, column: &Column) -> Result<Channel, MapError> {
        let place = Some(name.span());
        let text = name.get_ref();
        let unit = |unit: &Option<Spanned<String>>| match unit {
            Some(unit) => Ok((self.unit(unit)?, unit::turn(unit.get_ref()))),
            None => Ok((1.0, unit::turn("rad"))),
        };
        let sign = self.number(&column.sign, 1.0)?;
        if sign.abs() != 1.0 {
            let span = column.sign.as_ref().map(Spanned::span);
            let message = format!("`sign` is {sign}; expected 1 or -1");
            return Err(self.fault(span, message, "other numbers go into `factor`"));
        }
        let factor = sign * self.number(&column.factor, 1.0)?;
        let is_position = text.starts_with("q_");
        let terms = match (&column.column, &column.terms) {
            (Some(source), None) => {
                let (own, turn) = unit(&column.unit)?;
                vec![Term {
                    column: source.0.clone(),
                    factor: factor * own,
                    wrap: self.wrap(&column.wraps, turn.filter(|_| is_position))?,
                    fill: column.fill,
                }]
            }
            (None, Some(terms)) if !terms.is_empty() && column.wraps.is_none() => {
                let mut found = Vec::new();
                for term in terms {
                    let stated = term.unit.as_ref().or(column.unit.as_ref()).cloned();
                    let (own, turn) = unit(&stated)?;
                    found.push(Term {
                        column: term.column.0.clone(),
                        factor: factor * own * self.finite(&term.factor)?,
                        wrap: self.wrap(&term.wraps, turn.filter(|_| is_position))?,
                        fill: column.fill,
                    });
                }
                found
            }
            (None, Some(terms)) if !terms.is_empty() => {
                let message = "`wraps` belongs to each of the `terms`".to_owned();
                return Err(self.fault(place, message, "write it beside the `factor` of the term"));
            }
            _ => {
                let message = format!("`{text}` needs either `column` or `terms`");
                let mend = "`{ column = \"angle\" }`, or `{ terms = [{ column = \"m5\", factor = 0.02 }, …] }`";
                return Err(self.fault(place, message, mend));
            }
        };
        Ok(Channel {
            name: text.clone(),
            terms,
            offset: self.number(&column.offset, 0.0)?,
        })
    }

    fn wrap(&self, stated: &Option<Spanned<f64>>, turn: Option<f64>) -> Result<Wrap, MapError> {
        match (stated, turn) {
            (Some(period), _) => {
                let value = self.finite(period)?;
                if value > 0.0 {
                    return Ok(Wrap::Stated(value));
                }
                let message = format!("`wraps` is {value}; expected how many units make a turn");
                Err(self.fault(
                    Some(period.span()),
                    message,
                    "for instance 360, or the counts of the encoder",
                ))
            }
            (None, Some(turn)) => Ok(Wrap::Suspected(turn)),
            (None, None) => Ok(Wrap::None),
        }
    }

    fn unit(&self, unit: &Spanned<String>) -> Result<f64, MapError> {
        unit::factor(unit.get_ref()).map_err(|message| {
            let mend = "state a known unit, or none and the number in `factor`";
            self.fault(Some(unit.span()), message, mend)
        })
    }

    fn number(&self, number: &Option<Spanned<f64>>, otherwise: f64) -> Result<f64, MapError> {
        number
            .as_ref()
            .map_or(Ok(otherwise), |number| self.finite(number))
    }

    fn finite(&self, number: &Spanned<f64>) -> Result<f64, MapError> {
        let value = *number.get_ref();
        if value.is_finite() {
            return Ok(value);
        }
        let message = format!("found {value}; expected a finite number");
        Err(self.fault(Some(number.span()), message, "state a number"))
    }

    /// A controller's file, say, that has the log's name.
    fn refuse_what_is_no_map(&self) -> Result<(), MapError> {
        let Ok(table) = toml::from_str::<toml::Table>(self.text) else {
            return Ok(());
        };
        let Some(first) = table.keys().next() else {
            return Ok(());
        };
        if table.keys().any(|key| KEYS.contains(&key.as_str())) {
            return Ok(());
        }
        let keys = KEYS.map(|key| format!("`{key}`")).join(", ");
        let message = format!(
            "this is no map of a log's columns: it states `{}`, and none of {keys}",
            first.escape_debug()
        );
        let mend = "what has a log's name and `.toml` is taken for its map: give the file another name if it is \
            something else, or write `[columns]` (docs/log-format.md)";
        Err(self.fault(None, message, mend))
    }

    fn fault(&self, span: Option<Range<usize>>, message: String, mend: &str) -> MapError {
        let before = span.and_then(|span| self.text.get(..span.start));
        MapError {
            path: self.path.to_owned(),
            line: before.map(|before| 1 + before.matches('\n').count()),
            message,
            mend: mend.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
