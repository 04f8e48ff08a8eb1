//! Files that stand side by side: the same rows, other columns.

use super::LogError;
use super::error::{ProblemKind, Problems};
use super::limits;
use super::table::Table;
use std::collections::BTreeSet;
use std::path::Path;

/// Stamps of one row may differ by this share of a step.
const SAME: f64 = 0.5;

/// Puts the columns of `other` behind those of `table`, whose file is `path`. A name that is taken
/// gets its file's in front: `torques.j1`. Where both files have a column `t`, the rows must be of
/// one time.
///
/// # Errors
/// If the rows are not the same ones, or too many cells come together.
pub(super) fn join(
    table: &mut Table,
    other: Table,
    path: &Path,
    file: &Path,
) -> Result<(), LogError> {
    let fail = |line, column, kind| {
        let mut problems = Problems::default();
        problems.push(line, column, kind);
        Err(problems.into_error(file))
    };
    let beside = || path.display().to_string();
    let (rows, expected) = (other.lines.len(), table.lines.len());
    if rows != expected {
        let beside = beside();
        return fail(
            None,
            None,
            ProblemKind::OtherLength {
                rows,
                beside,
                expected,
            },
        );
    }
    if let Err(kind) = limits::check(rows, table.columns.len() + other.columns.len()) {
        return fail(None, None, kind);
    }
    if let (Some(t), Some(stamps)) = (table.column("t"), other.column("t")) {
        let step = super::median_step(t).abs();
        let mut pairs = t.iter().zip(stamps);
        if let Some(k) = pairs.position(|(a, b)| (a - b).abs() > SAME * step) {
            let kind = ProblemKind::OtherStamps {
                stamp: stamps[k],
                beside: beside(),
                expected: t[k],
            };
            return fail(Some(other.lines[k]), Some("t"), kind);
        }
    }
    let mut taken: BTreeSet<String> = table.columns.iter().map(|c| c.name.clone()).collect();
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    for mut column in other
        .columns
        .into_iter()
        .filter(|column| column.name != "t")
    {
        while !taken.insert(column.name.clone()) {
            column.name = format!("{stem}.{}", column.name);
        }
        table.columns.push(column);
    }
    table.headless |= other.headless;
    table.unread.extend(other.unread);
    table.warnings.extend(other.warnings);
    Ok(())
}
