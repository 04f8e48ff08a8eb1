//! From columns to channels.

use super::{Clock, Fill, Map, Term, Wrap};
use crate::log::error::{ProblemKind, Problems};
use crate::log::health::unwrap;
use crate::log::seen::Missing;
use crate::log::spikes::of_angle;
use crate::log::table::{Column, Table};
use crate::log::warning::Warning;
use std::collections::BTreeMap;

impl Map {
    /// Replaces the columns of a log by what they are; columns that the map does not
    /// mention stay as they are.
    pub(in crate::log) fn apply(&self, table: &mut Table) -> Result<(), Problems> {
        let mut problems = Problems::default();
        let found = table.seen();
        let absent = self
            .columns()
            .filter(|(column, _)| table.column(column).is_none());
        let missing: Vec<Missing> = absent
            .map(|(column, role)| Missing::named(column, role, &found))
            .collect();
        if !missing.is_empty() {
            return Err(Problems::whole(ProblemKind::MissingColumns {
                missing,
                found,
            }));
        }
        let t = self.stamps(table);
        let mut continuous: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        let mut mapped = vec![Column {
            name: "t".to_owned(),
            values: t.clone(),
        }];
        for channel in &self.channels {
            let mut values = vec![channel.offset; t.len()];
            for term in &channel.terms {
                let source = continuous
                    .entry(term.column.clone())
                    .or_insert_with(|| term.prepared(&t, table, &mut problems));
                for (value, reading) in values.iter_mut().zip(source) {
                    *value += term.factor * *reading;
                }
            }
            mapped.push(Column {
                name: channel.name.clone(),
                values,
            });
        }
        for column in &mapped {
            let odd = column.values.iter().position(|value| !value.is_finite());
            if let Some(k) = odd {
                let kind = ProblemKind::NotFinite(column.values[k].to_string());
                problems.push(Some(table.lines[k]), Some(&column.name), kind);
            }
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        table.columns.retain(|column| {
            let taken = mapped.iter().any(|own| own.name == column.name);
            let stamps = matches!(&self.clock, Clock::Column(name, _) if *name == column.name);
            // A log has no empty cells: what had some lives on in the channels it fills.
            let whole = column.values.iter().all(|value| value.is_finite());
            !taken && whole && !stamps
        });
        mapped.append(&mut table.columns);
        table.columns = mapped;
        Ok(())
    }

    /// Stamps in seconds.
    fn stamps(&self, table: &Table) -> Vec<f64> {
        match &self.clock {
            Clock::Column(name, second) => {
                let raw = table.column(name).unwrap_or_default();
                let first = raw.first().copied().unwrap_or(0.0);
                // Differences first: stamps since 1970 have few digits left for them.
                let stamp = |raw: &f64| match self.start {
                    Some(start) => start + second * (raw - first),
                    None => second * raw,
                };
                raw.iter().map(stamp).collect()
            }
            Clock::Rate(rate) => {
                let start = self.start.unwrap_or(0.0);
                let rows = 0..table.lines.len();
                rows.map(|k| start + k as f64 / rate).collect()
            }
        }
    }
}

impl Term {
    /// The column, without empty cells and made continuous.
    fn prepared(&self, t: &[f64], table: &mut Table, problems: &mut Problems) -> Vec<f64> {
        let mut values = table.column(&self.column).unwrap_or_default().to_vec();
        if let Some(fill) = self.fill {
            let empty = values.iter().filter(|value| value.is_nan()).count();
            if empty == values.len() {
                problems.push(None, Some(&self.column), ProblemKind::EmptyCell);
            } else if empty > 0 {
                fill_gaps(fill, t, &mut values);
                table.warnings.push(Warning::Filled {
                    column: self.column.clone(),
                    cells: empty,
                    linear: fill == Fill::Linear,
                });
            }
        }
        match self.wrap {
            Wrap::None => {}
            Wrap::Suspected(turn) => {
                let found = unwrap(&self.column, t, &mut values, turn);
                table.warnings.extend(found);
            }
            Wrap::Stated(turn) => join(t, turn, &mut values),
        }
        values
    }
}

/// Takes every step as the shorter way around; those to wild samples and back are none.
fn join(t: &[f64], turn: f64, values: &mut [f64]) {
    let wild = of_angle(t, values);
    let mut turns = 0.0;
    let mut previous = values.first().copied().unwrap_or(0.0);
    for (value, is_wild) in values.iter_mut().zip(wild) {
        let around = turns - ((*value - previous) / turn).round();
        if !is_wild {
            (previous, turns) = (*value, around);
        }
        *value += around * turn;
    }
}

/// Puts values into cells without one, which are NaN. Before the first measurement stands
/// the first, behind the last the last.
fn fill_gaps(fill: Fill, t: &[f64], values: &mut [f64]) {
    let known: Vec<usize> = (0..values.len()).filter(|k| !values[*k].is_nan()).collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        return;
    };
    let (begin, end) = (values[first], values[last]);
    values[..first].fill(begin);
    values[last..].fill(end);
    for pair in known.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (from, to) = (values[a], values[b]);
        for k in a + 1..b {
            values[k] = match fill {
                Fill::Hold => from,
                Fill::Linear if t[b] > t[a] => from + (to - from) * (t[k] - t[a]) / (t[b] - t[a]),
                // Stamps out of order are refused later.
                Fill::Linear => from,
            };
        }
    }
}
