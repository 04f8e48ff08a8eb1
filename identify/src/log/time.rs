//! Checks of the time stamps.

use super::MINIMUM_SAMPLES;
use super::error::{ProblemKind, Problems};
use super::table::Table;
use super::warning::Warning;

/// Stamps must increase. A row that repeats the one before in every column is
/// dropped and reported; any other repeated or earlier stamp is a problem.
pub(super) fn check(table: &mut Table) -> Result<(), Problems> {
    let mut problems = Problems::default();
    let repeated = disorder(table, &mut problems);
    if let Some(&first) = repeated.first() {
        table.warnings.push(Warning::RepeatedRows {
            rows: repeated.len(),
            line: table.lines[first],
        });
        drop_rows(table, &repeated);
    }
    let found = table.lines.len();
    if found < MINIMUM_SAMPLES {
        let minimum = MINIMUM_SAMPLES;
        problems.push(None, None, ProblemKind::TooShort { found, minimum });
    }
    if problems.is_empty() {
        Ok(())
    } else {
        Err(problems)
    }
}

/// Reports stamps out of order; returns the rows that repeat the one before.
fn disorder(table: &Table, problems: &mut Problems) -> Vec<usize> {
    let mut repeated = Vec::new();
    let Some(time) = table.columns.iter().find(|column| column.name == "t") else {
        return repeated;
    };
    for (k, pair) in (1..).zip(time.values.windows(2)) {
        let (previous, stamp) = (pair[0], pair[1]);
        let previous_line = table.lines[k - 1];
        let same = || {
            let mut columns = table.columns.iter();
            columns.all(|column| column.values[k] == column.values[k - 1])
        };
        let kind = if stamp > previous {
            continue;
        } else if stamp < previous {
            ProblemKind::TimeBackwards {
                previous,
                previous_line,
                stamp,
            }
        } else if same() {
            repeated.push(k);
            continue;
        } else {
            ProblemKind::DuplicateStamp {
                stamp,
                previous_line,
            }
        };
        problems.push(Some(table.lines[k]), Some("t"), kind);
    }
    repeated
}

/// Removes the rows of the given increasing indices.
fn drop_rows(table: &mut Table, rows: &[usize]) {
    let keep = |k: usize| rows.binary_search(&k).is_err();
    for column in &mut table.columns {
        column.values = kept(&column.values, keep);
    }
    table.lines = kept(&table.lines, keep);
}

fn kept<T: Copy>(values: &[T], keep: impl Fn(usize) -> bool) -> Vec<T> {
    let chosen = values.iter().enumerate().filter(|(k, _)| keep(*k));
    chosen.map(|(_, value)| *value).collect()
}
