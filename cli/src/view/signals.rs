//! A log on an even grid of times: what the page plays.

use dynamics_codegen::{Column, Model};
use identify::log::{Log, Record};
use serde::Serialize;
use std::collections::BTreeMap;

/// Frames of a page at most.
const MOST_FRAMES: usize = 1500;
/// Curves in one chart at most.
const MOST_CURVES: usize = 7;
/// What columns begin with that belong to coordinates and inputs, positions apart, and what they are.
const KINDS: [(&str, &str); 4] = [
    ("dq_", "rate"),
    ("ddq_", "acceleration"),
    ("u_", "input"),
    ("ucmd_", "command"),
];

/// Curves over time, one value per frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// Quantity and unit.
    pub title: String,
    /// Names and values.
    pub curves: Vec<(String, Vec<f64>)>,
}

/// Even times over a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Frames {
    /// s.
    pub times: Vec<f64>,
    /// Per time, the sample before it and the share of the way to the next.
    between: Vec<(usize, f64)>,
}

impl Frames {
    /// As many as the log has samples, 1500 at most.
    pub fn of(t: &[f64]) -> Self {
        let (first, last) = (t[0], t[t.len() - 1]);
        let count = t.len().clamp(2, MOST_FRAMES);
        let step = (last - first) / (count - 1) as f64;
        let times: Vec<f64> = (0..count).map(|k| first + k as f64 * step).collect();
        let between = times.iter().map(|&time| {
            let after = t.partition_point(|&sample| sample <= time);
            let before = after.saturating_sub(1).min(t.len().saturating_sub(2));
            let width = t.get(before + 1).map_or(1.0, |next| next - t[before]);
            (before, ((time - t[before]) / width).clamp(0.0, 1.0))
        });
        Self {
            between: between.collect(),
            times,
        }
    }

    /// Seconds from one to the next.
    pub fn interval(&self) -> f64 {
        self.times[1] - self.times[0]
    }

    /// A column at these times, linear in between.
    pub fn at(&self, column: &[f64]) -> Vec<f64> {
        let value = |&(before, share): &(usize, f64)| {
            let next = column.get(before + 1).unwrap_or(&column[before]);
            column[before] + share * (next - column[before])
        };
        self.between.iter().map(value).collect()
    }

    /// The arguments of a model's tapes at these times, positions from a log, everything else zero.
    pub fn arguments<'a>(
        &'a self,
        q: &'a [Vec<f64>],
        model: &Model,
        parameters: &[f64],
    ) -> Vec<Column<'a>> {
        let mut columns = vec![Column::Each(self.times.as_slice())];
        columns.extend(q.iter().map(|column| Column::Each(column.as_slice())));
        let others = model.coordinates.len() + model.input_symbols().len() + model.states.len();
        columns.extend(std::iter::repeat_n(Column::Same(0.0), others));
        columns.extend(parameters.iter().map(|&value| Column::Same(value)));
        columns
    }
}

/// Charts of a log: positions and rates of the same unit together, then inputs, then what else is there.
pub fn charts(model: &Model, log: &Log, record: &Record, frames: &Frames) -> Vec<Chart> {
    let mut charts = Vec::new();
    let mut by_unit: BTreeMap<&str, Vec<(String, Vec<f64>)>> = BTreeMap::new();
    let positions = model.positions();
    for (coordinate, column) in positions.iter().zip(&record.q) {
        let curve = (coordinate.name.clone(), frames.at(column));
        by_unit
            .entry(coordinate.unit.as_str())
            .or_default()
            .push(curve);
    }
    for (unit, curves) in by_unit {
        charts.extend(split(&format!("position [{unit}]"), curves));
    }
    for (prefix, title) in KINDS {
        let named = log.channels.iter();
        let curves = named.filter_map(|(name, column)| {
            let rest = name.strip_prefix(prefix)?;
            Some((rest.to_string(), frames.at(column)))
        });
        charts.extend(split(title, curves.collect()));
    }
    let is_known = |name: &str| {
        let mut kinds = KINDS.iter();
        name.starts_with("q_") || kinds.any(|(prefix, _)| name.starts_with(prefix))
    };
    let mut others: BTreeMap<&str, Vec<(String, Vec<f64>)>> = BTreeMap::new();
    for (name, column) in &log.channels {
        if !is_known(name) {
            let stem = ["_x", "_y", "_z"]
                .iter()
                .find_map(|end| name.strip_suffix(end));
            let curve = (name.clone(), frames.at(column));
            others.entry(stem.unwrap_or(name)).or_default().push(curve);
        }
    }
    for (stem, curves) in others {
        charts.extend(split(stem, curves));
    }
    charts
}

/// Not too many curves in one chart.
fn split(title: &str, curves: Vec<(String, Vec<f64>)>) -> Vec<Chart> {
    let parts = curves.chunks(MOST_CURVES);
    let chart = |curves: &[(String, Vec<f64>)]| Chart {
        title: title.to_string(),
        curves: curves.to_vec(),
    };
    parts.map(chart).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_linear_between_samples() {
        let frames = Frames::of(&[1.0, 1.1, 2.0]);
        assert_eq!(frames.times, [1.0, 1.5, 2.0]);
        let found = frames.at(&[0.0, 1.0, 10.0]);
        assert_eq!([found[0], found[2]], [0.0, 10.0]);
        assert!((found[1] - 5.0).abs() < 1e-12);
        let one = Frames::of(&[3.0]);
        assert_eq!(one.at(&[7.0]), [7.0, 7.0]);
    }
}
