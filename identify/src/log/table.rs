//! From text to named columns of numbers.

use super::error::{ProblemKind, Problems};
use super::limits::check_columns;
use super::map::Map;
use super::warning::Warning;
use csv::{Position, ReaderBuilder, StringRecord, Trim};
use std::collections::HashMap;

/// Characters of a cell shown in a message.
const SHOWN: usize = 40;

/// Prefixes of the columns whose every cell must be a finite number.
const MEASURED: [&str; 5] = ["q_", "dq_", "ddq_", "u_", "ucmd_"];

/// What the column of time stamps is called elsewhere.
const TIME_NAMES: [&str; 6] = ["T", "time", "_time", "timestamp", "stamp", "t_s"];

/// A numeric column.
#[derive(Debug)]
pub(super) struct Column {
    /// Its name in the header.
    pub name: String,
    /// Its values, one per row.
    pub values: Vec<f64>,
}

/// The rows of a log as columns.
#[derive(Debug)]
pub(super) struct Table {
    /// Numeric columns in the order of the file.
    pub columns: Vec<Column>,
    /// Line of the file of each row, counted from 1.
    pub lines: Vec<u64>,
    /// Columns set aside.
    pub warnings: Vec<Warning>,
}

/// What is asked of a log before its map, if it has one, is applied.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Demand<'a> {
    pub map: Option<&'a Map>,
}

impl Demand<'_> {
    /// Whether every cell of a column must be a finite number.
    fn requires(&self, column: &str) -> bool {
        let measured = MEASURED.iter().any(|prefix| column.starts_with(prefix));
        let mentioned = |map: &Map| map.columns().any(|(name, _)| name == column);
        match self.map {
            None => column == "t" || measured,
            Some(map) => measured || mentioned(map),
        }
    }

    fn slot(&self, name: &str) -> Slot {
        Slot {
            name: name.to_owned(),
            values: Vec::new(),
            required: self.requires(name),
            fills: self.map.is_some_and(|map| map.fills(name)),
            unusable: None,
        }
    }
}

/// A column while it is read.
struct Slot {
    name: String,
    values: Vec<f64>,
    required: bool,
    /// Whether a cell may be empty, to be filled.
    fills: bool,
    /// First cell of an optional column that is no number: line and text.
    unusable: Option<(u64, String)>,
}

/// Reads all rows; collects the problems of all of them.
pub(super) fn parse(text: &str, demand: Demand<'_>) -> Result<Table, Problems> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(delimiter(text))
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let mut problems = Problems::default();
    let mut record = StringRecord::new();
    let mut lines = Lines::new(text);
    let mut slots: Option<Vec<Slot>> = None;
    let mut rows: Vec<u64> = Vec::new();
    // Reading from memory that is known to be UTF-8, with rows of any length
    // allowed, leaves the reader no way to fail; `Ok(false)` is the end.
    while let Ok(true) = reader.read_record(&mut record) {
        let line = lines.of(record.position());
        match &mut slots {
            None if blank(&record, 2) => {}
            None => {
                if let Err(kind) = check_columns(record.len()) {
                    problems.push(Some(line), None, kind);
                    return Err(problems);
                }
                slots = Some(header(&record, line, demand, &mut problems));
            }
            Some(slots) if blank(&record, slots.len()) => {}
            Some(slots) => {
                rows.push(line);
                row(&record, line, slots, &mut problems);
            }
        }
    }
    match slots {
        None => problems.push(None, None, ProblemKind::Empty),
        Some(_) if rows.is_empty() && problems.is_empty() => {
            problems.push(None, None, ProblemKind::HeaderOnly);
        }
        Some(slots) if problems.is_empty() => return Ok(finish(slots, rows)),
        Some(_) => {}
    }
    Err(problems)
}

/// A line of nothing but spaces, where rows have `expected` cells.
fn blank(record: &StringRecord, expected: usize) -> bool {
    expected > 1 && record.len() == 1 && record[0].is_empty()
}

/// The most frequent of tab, semicolon and comma in the first row that is neither blank nor a
/// comment. What stands in quotes is part of a name.
fn delimiter(text: &str) -> u8 {
    const MARKS: [u8; 3] = [b'\t', b';', b','];
    let skipped = |line: &&str| line.trim().is_empty() || line.starts_with('#');
    let before: usize = text
        .split_inclusive('\n')
        .take_while(skipped)
        .map(str::len)
        .sum();
    let (mut counts, mut quoted) = ([0_usize; 3], false);
    for byte in text[before..].bytes() {
        match byte {
            b'"' => quoted = !quoted,
            b'\n' if !quoted => break,
            _ if quoted => {}
            _ => {
                for (count, mark) in counts.iter_mut().zip(MARKS) {
                    *count += usize::from(byte == mark);
                }
            }
        }
    }
    // `max_by_key` keeps the last of equals: the comma when there is none.
    let most = (0..MARKS.len()).max_by_key(|&mark| counts[mark]);
    most.map_or(b',', |mark| MARKS[mark])
}

/// Line numbers of records. The reader reports where it started to look for a
/// record; blank lines and comments before it are stepped over here.
struct Lines<'a> {
    bytes: &'a [u8],
    /// Line ends up to this byte are counted …
    counted: usize,
    /// … and this is the line it stands on.
    line: u64,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        Lines {
            bytes: text.as_bytes(),
            counted: 0,
            line: 1,
        }
    }

    fn of(&mut self, position: Option<&Position>) -> u64 {
        let mut begin = position.map_or(0, |position| position.byte() as usize);
        loop {
            match self.bytes.get(begin) {
                Some(b'\n' | b'\r') => begin += 1,
                Some(b'#') => begin += until_line_end(&self.bytes[begin..]),
                _ => break,
            }
        }
        let passed = self.bytes.get(self.counted..begin).unwrap_or_default();
        self.line += passed.iter().filter(|byte| **byte == b'\n').count() as u64;
        self.counted = self.counted.max(begin);
        self.line
    }
}

fn until_line_end(bytes: &[u8]) -> usize {
    bytes
        .iter()
        .position(|byte| *byte == b'\n')
        .unwrap_or(bytes.len())
}

/// Checks the names of the columns.
fn header(
    record: &StringRecord,
    line: u64,
    demand: Demand<'_>,
    problems: &mut Problems,
) -> Vec<Slot> {
    if record.iter().all(|cell| cell.parse::<f64>().is_ok()) {
        problems.push(Some(line), None, ProblemKind::NumericHeader);
    }
    let mut positions: HashMap<&str, usize> = HashMap::new();
    for (second, name) in (1..).zip(record) {
        match positions.get(name) {
            Some(first) if !name.is_empty() => {
                let first = *first;
                let kind = ProblemKind::DuplicateColumn { first, second };
                problems.push(Some(line), Some(name), kind);
            }
            _ => {
                positions.insert(name, second);
            }
        }
    }
    if demand.map.is_none() && !positions.contains_key("t") && problems.is_empty() {
        let found = record.iter().map(str::to_owned).collect();
        problems.push(Some(line), Some("t"), no_time(found));
    }
    record.iter().map(|name| demand.slot(name)).collect()
}

fn no_time(found: Vec<String>) -> ProblemKind {
    let nearest = TIME_NAMES
        .iter()
        .find_map(|alias| found.iter().find(|name| name.eq_ignore_ascii_case(alias)));
    ProblemKind::MissingColumn {
        role: "the time stamps [s]".to_owned(),
        nearest: nearest.cloned(),
        found,
    }
}

/// Reads the cells of one row.
fn row(record: &StringRecord, line: u64, slots: &mut [Slot], problems: &mut Problems) {
    if record.len() != slots.len() {
        let kind = ProblemKind::Ragged {
            found: record.len(),
            expected: slots.len(),
        };
        problems.push(Some(line), None, kind);
        return;
    }
    for (slot, cell) in slots.iter_mut().zip(record) {
        if slot.unusable.is_some() {
            continue;
        }
        slot.take(line, number(cell), cell, problems);
    }
}

impl Slot {
    /// The next cell: its number, or what is wrong with it.
    fn take(
        &mut self,
        line: u64,
        cell: Result<f64, ProblemKind>,
        shown: &str,
        problems: &mut Problems,
    ) {
        match cell {
            Ok(value) => self.values.push(value),
            Err(ProblemKind::EmptyCell) if self.fills => self.values.push(f64::NAN),
            Err(kind) if self.required => problems.push(Some(line), Some(&self.name), kind),
            Err(_) => {
                self.unusable = Some((line, shortened(shown)));
                self.values = Vec::new();
            }
        }
    }
}

/// A cell of a file that is no text.
#[cfg(any(feature = "parquet", feature = "mcap"))]
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    Empty,
    /// What stands there in place of a number, [`shortened`].
    Other(Box<str>),
}

/// A table from columns of cells, all of one length; lines are counted from 1.
#[cfg(any(feature = "parquet", feature = "mcap"))]
pub(super) fn from_columns(
    columns: Vec<(String, Vec<Cell>)>,
    demand: Demand<'_>,
) -> Result<Table, Problems> {
    let mut problems = Problems::default();
    let rows = columns.first().map_or(0, |(_, cells)| cells.len());
    let names: Vec<String> = columns.iter().map(|(name, _)| name.clone()).collect();
    if demand.map.is_none() && !names.iter().any(|name| name == "t") {
        problems.push(None, Some("t"), no_time(names));
    } else if rows == 0 {
        problems.push(None, None, ProblemKind::HeaderOnly);
    }
    let mut slots = Vec::new();
    for (name, cells) in columns {
        let mut slot = demand.slot(&name);
        for (line, cell) in (1..).zip(cells) {
            if slot.unusable.is_some() {
                break;
            }
            let (number, shown) = match cell {
                Cell::Number(value) if value.is_finite() => (Ok(value), String::new()),
                Cell::Number(value) => (
                    Err(ProblemKind::NotFinite(value.to_string())),
                    value.to_string(),
                ),
                Cell::Empty => (Err(ProblemKind::EmptyCell), String::new()),
                Cell::Other(text) => (
                    Err(ProblemKind::NotANumber(text.clone().into())),
                    text.into(),
                ),
            };
            slot.take(line, number, &shown, &mut problems);
        }
        slots.push(slot);
    }
    if problems.is_empty() {
        Ok(finish(slots, (1..=rows as u64).collect()))
    } else {
        Err(problems)
    }
}

fn number(cell: &str) -> Result<f64, ProblemKind> {
    match cell.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(ProblemKind::NotFinite(shortened(cell))),
        Err(_) if cell.is_empty() => Err(ProblemKind::EmptyCell),
        Err(_) if cell.replacen(',', ".", 1).parse::<f64>().is_ok() => {
            Err(ProblemKind::DecimalComma(shortened(cell)))
        }
        Err(_) => Err(ProblemKind::NotANumber(shortened(cell))),
    }
}

/// A cell as shown in a message: one line, not too long.
pub(super) fn shortened(cell: &str) -> String {
    let mut shown: String = cell
        .chars()
        .take(SHOWN)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if cell.chars().nth(SHOWN).is_some() {
        shown.push('…');
    }
    shown
}

/// Sets aside what has no name or no numbers.
fn finish(slots: Vec<Slot>, lines: Vec<u64>) -> Table {
    let mut columns = Vec::new();
    let mut warnings = Vec::new();
    for (position, slot) in (1..).zip(slots) {
        match slot.unusable {
            _ if slot.name.is_empty() => warnings.push(Warning::NamelessColumn { position }),
            Some((line, text)) => warnings.push(Warning::IgnoredColumn {
                column: slot.name,
                line,
                text,
            }),
            None => columns.push(Column {
                name: slot.name,
                values: slot.values,
            }),
        }
    }
    Table {
        columns,
        lines,
        warnings,
    }
}
