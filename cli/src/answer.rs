//! Named quantities at one state, as JSON or as a page.

use serde::ser::{Serialize, SerializeMap, Serializer};
use std::fmt::Write;

/// Labels are at least so wide.
const LABEL: usize = 10;

/// A quantity's values.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// How many there are of something.
    Count(usize),
    /// A vector.
    Vector(Vec<f64>),
    /// A matrix, by rows.
    Matrix(Vec<Vec<f64>>),
    /// Vectors by name.
    Columns(Vec<(String, Vec<f64>)>),
    /// Numbers by name.
    Scalars(Vec<(String, f64)>),
}

/// Quantities by name, in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer(Vec<(String, Quantity)>);

impl Answer {
    /// Adds a quantity.
    pub fn push(&mut self, name: impl Into<String>, mut quantity: Quantity) {
        // A zero has no sign worth showing.
        quantity.values().for_each(|value| *value += 0.0);
        self.0.push((name.into(), quantity));
    }

    /// The first quantity with a value that is no finite number.
    pub fn not_finite(&self) -> Option<&str> {
        let faulty = self.0.iter().find(|(_, quantity)| !quantity.is_finite());
        faulty.map(|(name, _)| name.as_str())
    }

    /// As text for people, under a title.
    pub fn page(&self, title: &str) -> String {
        let mut lines: Vec<(String, String)> = Vec::new();
        for (name, quantity) in &self.0 {
            if let Quantity::Count(count) = quantity {
                lines.push((name.clone(), format!("{count:>13}")));
            }
            for (label, row) in quantity.rows(name) {
                let numbers: Vec<String> = row.iter().map(|x| format!("{x:>13.6e}")).collect();
                lines.push((label, numbers.join(" ")));
            }
        }
        let width = lines.iter().map(|(label, _)| label.chars().count());
        let width = width.max().unwrap_or(0).max(LABEL);
        let mut page = format!("{title}\n");
        for (label, numbers) in lines {
            // Writing to a string cannot fail.
            writeln!(page, "  {label:<width$} {numbers}").ok();
        }
        page
    }
}

impl Quantity {
    fn values(&mut self) -> Box<dyn Iterator<Item = &mut f64> + '_> {
        match self {
            Self::Count(_) => Box::new(std::iter::empty()),
            Self::Vector(row) => Box::new(row.iter_mut()),
            Self::Matrix(rows) => Box::new(rows.iter_mut().flatten()),
            Self::Columns(named) => Box::new(named.iter_mut().flat_map(|(_, row)| row)),
            Self::Scalars(named) => Box::new(named.iter_mut().map(|(_, value)| value)),
        }
    }

    fn is_finite(&self) -> bool {
        let all = |row: &[f64]| row.iter().all(|x| x.is_finite());
        match self {
            Self::Count(_) => true,
            Self::Vector(row) => all(row),
            Self::Matrix(rows) => rows.iter().all(|row| all(row)),
            Self::Columns(named) => named.iter().all(|(_, row)| all(row)),
            Self::Scalars(named) => named.iter().all(|(_, value)| value.is_finite()),
        }
    }

    /// Labelled rows; what is empty has none.
    fn rows(&self, name: &str) -> Vec<(String, &[f64])> {
        let rows: Vec<(String, &[f64])> = match self {
            Self::Count(_) => Vec::new(),
            Self::Vector(row) => vec![(name.to_string(), row)],
            Self::Matrix(rows) => rows
                .iter()
                .enumerate()
                .map(|(i, row)| (if i == 0 { name } else { "" }.to_string(), row.as_slice()))
                .collect(),
            Self::Columns(named) => named
                .iter()
                .map(|(entry, row)| (format!("{name}.{entry}"), row.as_slice()))
                .collect(),
            Self::Scalars(named) => named
                .iter()
                .map(|(entry, value)| (format!("{name}.{entry}"), std::slice::from_ref(value)))
                .collect(),
        };
        rows.into_iter()
            .filter(|(_, row)| !row.is_empty())
            .collect()
    }
}

impl Serialize for Quantity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Count(count) => count.serialize(serializer),
            Self::Vector(row) => row.serialize(serializer),
            Self::Matrix(rows) => rows.serialize(serializer),
            Self::Columns(named) => {
                serializer.collect_map(named.iter().map(|(name, row)| (name, row)))
            }
            Self::Scalars(named) => {
                serializer.collect_map(named.iter().map(|(name, value)| (name, value)))
            }
        }
    }
}

impl Serialize for Answer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, quantity) in &self.0 {
            map.serialize_entry(name, quantity)?;
        }
        map.end()
    }
}
