//! Named columns of numbers, and how cells become them.

use super::error::{ProblemKind, Problems};
use super::map::Map;
use super::seen::{Missing, Seen, seen};
use super::warning::Warning;

/// Characters of a cell shown in a message.
const SHOWN: usize = 40;

/// Prefixes of the columns whose every cell must be a finite number.
const MEASURED: [&str; 5] = ["q_", "dq_", "ddq_", "u_", "ucmd_"];

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
    /// Whether the columns are called by their numbers, for want of a header.
    pub headless: bool,
    /// Columns that nobody asked for, and that were not read.
    pub unread: Vec<String>,
    /// Columns set aside.
    pub warnings: Vec<Warning>,
}

impl Table {
    /// The columns that are there, whether they were read or not.
    pub fn seen(&self) -> Vec<Seen> {
        let unread = self.unread.iter().map(|name| Seen::named(name));
        let mut all = seen(&self.columns, self.headless);
        all.extend(unread);
        all
    }

    /// The values of a column; none if it is not there.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let mut columns = self.columns.iter();
        columns
            .find(|column| column.name == name)
            .map(|column| column.values.as_slice())
    }
}

/// What is asked of a log before its map, if it has one, is applied.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Demand<'a> {
    /// What the columns are.
    pub map: Option<&'a Map>,
    /// How many columns stand before the first of this file: those of files beside it.
    pub before: usize,
}

impl Demand<'_> {
    /// Whether every cell of a column must be a finite number.
    pub fn requires(&self, column: &str) -> bool {
        let measured = MEASURED.iter().any(|prefix| column.starts_with(prefix));
        let mentioned = |map: &Map| map.columns().any(|(name, _)| name == column);
        match self.map {
            None => column == "t" || measured,
            Some(map) => measured || mentioned(map),
        }
    }

    pub fn slot(&self, name: &str) -> Slot {
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
pub(super) struct Slot {
    /// Its name.
    pub name: String,
    values: Vec<f64>,
    required: bool,
    /// Whether a cell may be empty, to be filled.
    fills: bool,
    /// First cell of an optional column that is no number: line and text.
    unusable: Option<(u64, String)>,
}

impl Slot {
    /// Whether its cells are of no use.
    pub fn is_unusable(&self) -> bool {
        self.unusable.is_some()
    }

    /// The next cell: its number, or what is wrong with it.
    pub fn take(
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

/// That there is no column of stamps.
pub(super) fn no_time(found: Vec<Seen>) -> ProblemKind {
    ProblemKind::MissingColumns {
        missing: vec![Missing::time(&found)],
        found,
    }
}

/// A cell of a file that is no text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    Empty,
    /// What stands there in place of a number, [`shortened`].
    Other(Box<str>),
}

/// A table from columns of cells, all of one length; lines are counted from 1.
pub(super) fn from_columns(
    columns: Vec<(String, Vec<Cell>)>,
    demand: Demand<'_>,
) -> Result<Table, Problems> {
    let mut problems = Problems::default();
    let rows = columns.first().map_or(0, |(_, cells)| cells.len());
    let found: Vec<Seen> = columns.iter().map(|(name, _)| Seen::named(name)).collect();
    if demand.map.is_none() && !found.iter().any(|seen| seen.name == "t") {
        problems.push(None, None, no_time(found));
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
pub(super) fn finish(slots: Vec<Slot>, lines: Vec<u64>) -> Table {
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
        headless: false,
        unread: Vec::new(),
        warnings,
    }
}
