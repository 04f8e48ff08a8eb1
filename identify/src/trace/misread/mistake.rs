//! What may be wrong with columns, what that makes of their values, and how a map says it.

use crate::log::{Log, Record};
use std::f64::consts::{PI, TAU};

/// What a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Position,
    Velocity,
    Acceleration,
    Input,
}

impl Kind {
    /// Those of a coordinate; the place is the order of the derivative.
    pub const MOTION: [Self; 3] = [Self::Position, Self::Velocity, Self::Acceleration];
}

/// A column of a record: what it measures, and of which coordinate or input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Column {
    pub kind: Kind,
    pub index: usize,
}

/// A unit that a column may be in instead of the SI unit.
#[derive(Debug, PartialEq)]
pub(super) struct Unit {
    /// As a map writes it for a position; of a speed, if it is one by itself.
    pub name: &'static str,
    /// In SI.
    pub size: f64,
    /// Whether it measures an angle; else a length.
    pub angle: bool,
    /// Whether it is a unit of speed.
    pub speed: bool,
}

/// Degrees and millimetres come first: those are tried on whole coordinates.
pub(super) const UNITS: [Unit; 5] = [
    Unit {
        name: "deg",
        size: PI / 180.0,
        angle: true,
        speed: false,
    },
    Unit {
        name: "mm",
        size: 1e-3,
        angle: false,
        speed: false,
    },
    Unit {
        name: "turn",
        size: TAU,
        angle: true,
        speed: false,
    },
    Unit {
        name: "cm",
        size: 1e-2,
        angle: false,
        speed: false,
    },
    Unit {
        name: "rpm",
        size: TAU / 60.0,
        angle: true,
        speed: true,
    },
];

/// What may be wrong with some columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mistake {
    /// All of them have the opposite sign, or are in this unit, or both.
    Scaled {
        columns: Vec<Column>,
        reversed: bool,
        unit: Option<&'static Unit>,
    },
    /// Each pair stands in each other's place.
    Swapped(Vec<(Column, Column)>),
}

/// What mends one or two columns.
#[derive(Debug, Clone, Copy)]
pub(super) enum Change {
    Scale(Column, f64),
    Swap(Column, Column),
}

impl Mistake {
    pub fn reversed(columns: Vec<Column>) -> Self {
        Self::Scaled {
            columns,
            reversed: true,
            unit: None,
        }
    }

    pub fn in_unit(columns: Vec<Column>, unit: &'static Unit) -> Self {
        Self::Scaled {
            columns,
            reversed: false,
            unit: Some(unit),
        }
    }

    /// What turns the columns into what they are taken for.
    pub fn changes(&self) -> Vec<Change> {
        match self {
            Self::Scaled {
                columns,
                reversed,
                unit,
            } => {
                let sign = if *reversed { -1.0 } else { 1.0 };
                let factor = sign * unit.map_or(1.0, |unit| unit.size);
                let scaled = columns.iter().map(|&column| Change::Scale(column, factor));
                scaled.collect()
            }
            Self::Swapped(pairs) => pairs.iter().map(|&(a, b)| Change::Swap(a, b)).collect(),
        }
    }

    /// The columns by their names in the log.
    pub fn columns(&self, record: &Record, log: &Log) -> Vec<String> {
        let columns = match self {
            Self::Scaled { columns, .. } => columns.clone(),
            Self::Swapped(pairs) => pairs.iter().flat_map(|&(a, b)| [a, b]).collect(),
        };
        let names = columns.iter().map(|column| column.name(record, log));
        names.collect()
    }

    /// In a sentence without its full stop.
    pub fn sentence(&self, record: &Record, log: &Log) -> String {
        let names = list(&self.columns(record, log));
        match self {
            Self::Swapped(pairs) => {
                let pair = |&(a, b): &(Column, Column)| {
                    list(&[a, b].map(|column| column.name(record, log)))
                };
                let pairs: Vec<String> = pairs.iter().map(pair).collect();
                format!("{} stand in each other's place", pairs.join(", "))
            }
            Self::Scaled {
                columns,
                reversed,
                unit,
            } => {
                let one = columns.len() == 1;
                let (is, has) = if one { ("is", "has") } else { ("are", "have") };
                let sign = format!("{has} the opposite sign");
                match (unit, columns.first()) {
                    (Some(unit), Some(first)) => {
                        let unit = match one {
                            true => unit.of(first.kind),
                            false => unit.name.to_string(),
                        };
                        let and = if *reversed {
                            format!(" and {sign}")
                        } else {
                            String::new()
                        };
                        format!("{names} {is} in {unit}{and}")
                    }
                    _ => format!("{names} {sign}"),
                }
            }
        }
    }

    /// The lines that read the columns as they are, under `[columns]` of a map.
    pub fn map(&self, record: &Record, log: &Log) -> Vec<String> {
        let line = |to: Column, from: Column, rest: &str| {
            let [to, from] = [to, from].map(|column| column.name(record, log));
            format!("\"{to}\" = {{ column = \"{from}\"{rest} }}")
        };
        match self {
            Self::Swapped(pairs) => {
                let both = pairs.iter().flat_map(|&(a, b)| [(a, b), (b, a)]);
                both.map(|(to, from)| line(to, from, "")).collect()
            }
            Self::Scaled {
                columns,
                reversed,
                unit,
            } => {
                let each = columns.iter().map(|&column| {
                    let unit = unit.map(|unit| format!(", unit = \"{}\"", unit.of(column.kind)));
                    let sign = if *reversed { ", sign = -1" } else { "" };
                    line(column, column, &(unit.unwrap_or_default() + sign))
                });
                each.collect()
            }
        }
    }

    /// What the record would be without it.
    pub fn mend(&self, record: &mut Record) {
        for change in self.changes() {
            match change {
                Change::Scale(column, by) => {
                    if let Some(values) = column.of(record) {
                        values.iter_mut().for_each(|value| *value *= by);
                    }
                }
                Change::Swap(a, b) => {
                    let taken = a.of(record).map(std::mem::take);
                    let other = match (b.of(record), taken) {
                        (Some(values), Some(taken)) => std::mem::replace(values, taken),
                        _ => continue,
                    };
                    if let Some(values) = a.of(record) {
                        *values = other;
                    }
                }
            }
        }
    }
}

impl Column {
    fn of(self, record: &mut Record) -> Option<&mut Vec<f64>> {
        match self.kind {
            Kind::Position => record.q.get_mut(self.index),
            Kind::Velocity => record.dq.get_mut(self.index)?.as_mut(),
            Kind::Acceleration => record.ddq.get_mut(self.index)?.as_mut(),
            Kind::Input => record.u.get_mut(self.index),
        }
    }

    /// Its name in the log.
    fn name(self, record: &Record, log: &Log) -> String {
        match self.kind {
            Kind::Position => log.column("q_", &record.coordinates[self.index]),
            Kind::Velocity => log.column("dq_", &record.coordinates[self.index]),
            Kind::Acceleration => log.column("ddq_", &record.coordinates[self.index]),
            Kind::Input => log.input_column(&record.inputs[self.index]),
        }
    }
}

impl Unit {
    /// The unit of a column of this kind, as a map writes it.
    fn of(&self, kind: Kind) -> String {
        match kind {
            Kind::Velocity if !self.speed => format!("{}/s", self.name),
            Kind::Acceleration => format!("{}/s^2", self.name),
            _ => self.name.to_string(),
        }
    }
}

/// `` `a`, `b` and `c` ``
fn list(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => quoted.concat(),
    }
}
