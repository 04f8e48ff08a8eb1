//! Tables in text: CSV, with or without a header.

use super::ends::Sound;
use super::error::{ProblemKind, Problems};
use super::limits::check_columns;
use super::seen::Seen;
use super::table::{Demand, Slot, Table, finish, no_time, shortened};
use super::warning::Warning;
use csv::{Position, ReaderBuilder, StringRecord, Trim};
use std::collections::HashMap;

/// Reads all rows; collects the problems of all of them.
pub(super) fn parse(sound: Sound<'_>, demand: Demand<'_>) -> Result<Table, Problems> {
    let text = sound.text;
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(delimiter(text))
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let mut problems = Problems::default();
    let mut warnings = sound.warnings;
    let mut record = StringRecord::new();
    let mut lines = Lines::new(text, sound.line);
    let mut reading: Option<Reading> = None;
    // Reading from memory that is known to be UTF-8, with rows of any length
    // allowed, leaves the reader no way to fail; `Ok(false)` is the end.
    while let Ok(true) = reader.read_record(&mut record) {
        let line = lines.of(record.position());
        match &mut reading {
            None if blank(&record, 2) => {}
            None => {
                if let Err(kind) = check_columns(record.len()) {
                    problems.push(Some(line), None, kind);
                    return Err(problems);
                }
                let found = Reading::begin(&record, line, demand, &mut problems);
                reading = Some(found);
            }
            Some(reading) if blank(&record, reading.slots.len()) => {}
            Some(reading) => reading.take(&mut record, line, &mut problems),
        }
    }
    let Some(mut reading) = reading else {
        problems.push(None, None, ProblemKind::Empty);
        return Err(problems);
    };
    warnings.extend(reading.end(text.ends_with(['\n', '\r']), &mut problems));
    if reading.lines.is_empty() && problems.is_empty() {
        problems.push(None, None, ProblemKind::HeaderOnly);
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let headless = reading.headless;
    let mut table = finish(reading.slots, reading.lines);
    warnings.append(&mut table.warnings);
    let table = Table {
        headless,
        warnings,
        ..table
    };
    if headless && demand.map.is_none() {
        let found = table.seen();
        problems.push(None, None, ProblemKind::NoHeader { found });
        return Err(problems);
    }
    Ok(table)
}

/// A table while its rows are read.
struct Reading {
    slots: Vec<Slot>,
    headless: bool,
    /// Lines of the rows.
    lines: Vec<u64>,
    /// The row read last and its line: only the next one says that it is not cut off.
    last: Option<(StringRecord, u64)>,
}

impl Reading {
    /// From the first row, which is a header unless it holds nothing but numbers.
    fn begin(
        record: &StringRecord,
        line: u64,
        demand: Demand<'_>,
        problems: &mut Problems,
    ) -> Self {
        let headless = record.iter().all(|cell| cell.parse::<f64>().is_ok());
        let slots = match headless {
            true => {
                let numbers = 1 + demand.before..=demand.before + record.len();
                numbers.map(|n| demand.slot(&n.to_string())).collect()
            }
            false => header(record, line, demand, problems),
        };
        Self {
            slots,
            headless,
            lines: Vec::new(),
            last: headless.then(|| (record.clone(), line)),
        }
    }

    /// The next row; `record` is free for the one after.
    fn take(&mut self, record: &mut StringRecord, line: u64, problems: &mut Problems) {
        match &mut self.last {
            None => self.last = Some((std::mem::take(record), line)),
            Some((last, last_line)) => {
                self.lines.push(*last_line);
                row(last, *last_line, &mut self.slots, problems);
                std::mem::swap(last, record);
                *last_line = line;
            }
        }
    }

    /// The last row, unless it is cut off. `complete`: whether the text ends with its line.
    fn end(&mut self, complete: bool, problems: &mut Problems) -> Option<Warning> {
        let (last, line) = self.last.take()?;
        if !self.lines.is_empty() && self.is_cut(&last, complete) {
            let text: Vec<&str> = last.iter().collect();
            let text = shortened(&text.join(","));
            return Some(Warning::CutRow { line, text });
        }
        self.lines.push(line);
        row(&last, line, &mut self.slots, problems);
        None
    }

    /// Whether a last row lacks cells, or the end of a number.
    fn is_cut(&self, last: &StringRecord, complete: bool) -> bool {
        // An open quote swallows many rows, which are no single cut one.
        if last.iter().any(|cell| cell.contains('\n')) {
            return false;
        }
        let is_broken = |cell: &str| number(cell).is_err();
        let in_use = self.slots.last().is_some_and(|slot| !slot.is_unusable());
        let ends_broken = in_use && last.iter().next_back().is_some_and(is_broken);
        last.len() < self.slots.len()
            || (!complete && last.len() == self.slots.len() && ends_broken)
    }
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
    fn new(text: &'a str, first: u64) -> Self {
        Lines {
            bytes: text.as_bytes(),
            counted: 0,
            line: first,
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
        let named = record.iter().filter(|name| !name.is_empty());
        let found = named.map(Seen::named).collect();
        problems.push(None, None, no_time(found));
    }
    record.iter().map(|name| demand.slot(name)).collect()
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
        if slot.is_unusable() {
            continue;
        }
        slot.take(line, number(cell), cell, problems);
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
