//! Inputs over time: piecewise linear, from a CSV file.

use crate::mistake::{Mistake, Place};
use crate::parameters;
use dynamics_codegen::file::{self, Limit};
use identify::log::Counted;
use std::path::Path;

/// As much text as a log may be.
const LIMIT: Limit = Limit {
    what: "a file of inputs",
    bytes: 512 << 20,
};

/// Inputs as functions of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Strictly increasing, at least one, s.
    times: Vec<f64>,
    /// Per time, one value per input.
    values: Vec<Vec<f64>>,
}

impl Inputs {
    /// The same at all times.
    pub fn constant(values: Vec<f64>) -> Self {
        Self {
            times: vec![0.0],
            values: vec![values],
        }
    }

    /// Values at times, one row of values per time.
    ///
    /// # Errors
    /// If there is no time, or time does not increase.
    pub fn new(times: Vec<f64>, values: Vec<Vec<f64>>) -> Result<Self, Mistake> {
        if times.is_empty() || times.len() != values.len() {
            let message = format!("{} rows of inputs for {} times", values.len(), times.len());
            return Err(
                Mistake::new(message).help("give a row of inputs per time, and one at least")
            );
        }
        if let Some(pair) = times.windows(2).find(|pair| pair[1] <= pair[0]) {
            let message = format!("time does not increase: {} s after {} s", pair[1], pair[0]);
            return Err(Mistake::new(message).help("sort the rows by time, and keep one per time"));
        }
        Ok(Self { times, values })
    }

    /// Reads a CSV file with a column `t` and one column `u_<name>` per input; other
    /// columns are left alone.
    ///
    /// # Errors
    /// If a column is missing, an entry is no finite number, or time does not increase.
    pub fn read(path: &Path, names: &[&str]) -> Result<Self, Mistake> {
        let columns: Vec<String> = names.iter().map(|name| format!("u_{name}")).collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        Self::read_columns(path, &columns)
    }

    /// Reads the column `t` and those of these names.
    ///
    /// # Errors
    /// As [`Inputs::read`].
    pub fn read_columns(path: &Path, names: &[&str]) -> Result<Self, Mistake> {
        let file = file::open(path, LIMIT).map_err(|error| Mistake::unreadable(path, &error))?;
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(Counted::new(file));
        let file = path.display().to_string();
        let header = reader
            .headers()
            .map_err(|error| fault(&file, &error))?
            .clone();
        let columns = columns(&file, &header, names)?;
        let (mut times, mut values) = (Vec::new(), Vec::new());
        for record in reader.records() {
            let record = record.map_err(|error| fault(&file, &error))?;
            let entry = |column: usize| number(&file, &header, &record, column);
            let t = entry(columns[0])?;
            if let Some(&last) = times.last()
                && t <= last
            {
                let message = format!("time does not increase: {t} s after {last} s");
                return Err(at(&file, &record, columns[0], message)
                    .help("sort the rows by time, and keep one row per time"));
            }
            times.push(t);
            values.push(
                columns[1..]
                    .iter()
                    .map(|&c| entry(c))
                    .collect::<Result<_, _>>()?,
            );
        }
        if times.is_empty() {
            let message = format!("`{file}` has no row of numbers");
            return Err(Mistake::new(message).help("add a row under the heading"));
        }
        Ok(Self { times, values })
    }

    /// The first and the last time.
    pub fn range(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// The values at a time; the first and the last are held before and after.
    pub fn at(&self, t: f64) -> Vec<f64> {
        let after = self.times.partition_point(|&time| time <= t);
        if after == 0 {
            return self.values[0].clone();
        }
        if after == self.times.len() {
            return self.values[after - 1].clone();
        }
        let (start, end) = (self.times[after - 1], self.times[after]);
        let share = (t - start) / (end - start);
        let pairs = self.values[after - 1].iter().zip(&self.values[after]);
        pairs.map(|(a, b)| a + share * (b - a)).collect()
    }

    /// The first time behind `t` at which the inputs may change direction.
    pub fn next_corner(&self, t: f64) -> Option<f64> {
        let after = self.times.partition_point(|&time| time <= t);
        self.times.get(after).copied()
    }
}

/// Where `t` and the inputs stand.
fn columns(file: &str, header: &csv::StringRecord, names: &[&str]) -> Result<Vec<usize>, Mistake> {
    let wanted = std::iter::once("t").chain(names.iter().copied());
    wanted
        .map(|name| {
            let mut found = (0..header.len()).filter(|&column| &header[column] == name);
            match (found.next(), found.next()) {
                (Some(column), None) => Ok(column),
                (Some(_), Some(_)) => {
                    let message = format!("`{file}` has two columns `{name}`");
                    Err(Mistake::new(message).help("drop one of them"))
                }
                (None, _) => {
                    let mistake = Mistake::new(format!("`{file}` has no column `{name}`"));
                    let taken = |column: &str| names.contains(&column);
                    let spare = header
                        .iter()
                        .filter(|column| *column != "t" && !taken(column));
                    Err(parameters::suggest(mistake, name, spare))
                }
            }
        })
        .collect()
}

fn number(
    file: &str,
    header: &csv::StringRecord,
    record: &csv::StringRecord,
    column: usize,
) -> Result<f64, Mistake> {
    // The reader has seen to it that every row has as many entries as the heading.
    let entry = record.get(column).unwrap_or_default();
    match entry.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => {
            let message = format!("column `{}` must hold finite numbers", &header[column]);
            Err(at(file, record, column, message).help("correct the entry or leave the row out"))
        }
    }
}

/// A mistake at an entry of a row.
fn at(file: &str, record: &csv::StringRecord, column: usize, message: String) -> Mistake {
    let entries: Vec<&str> = record.iter().collect();
    let start = entries
        .iter()
        .take(column)
        .map(|entry| entry.len() + 1)
        .sum();
    let end = start + entries.get(column).map_or(0, |entry| entry.len());
    let line = record.position().map_or(1, csv::Position::line);
    let place = Place {
        file: file.to_string(),
        first_line: usize::try_from(line).unwrap_or(usize::MAX),
        text: entries.join(","),
        range: start..end,
        label: String::new(),
    };
    Mistake::at(place, message)
}

fn fault(file: &str, error: &csv::Error) -> Mistake {
    let line = |position: &Option<csv::Position>| position.as_ref().map_or(1, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::Io(io) => Mistake::unreadable(Path::new(file), io),
        csv::ErrorKind::Utf8 { pos, .. } => {
            let message = format!("line {} of `{file}` is not UTF-8 text", line(pos));
            Mistake::new(message).help("save it as UTF-8")
        }
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => Mistake::new(format!(
            "line {} of `{file}` has {len} entries, the heading has {expected_len}",
            line(pos)
        ))
        .help("every row has one entry per column"),
        _ => Mistake::new(format!("`{file}` is not a CSV file: {error}"))
            .help("a heading such as `t,u_j1`, then one row per time"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_linear_in_between_and_held_outside() {
        let inputs = Inputs {
            times: vec![1.0, 2.0, 4.0],
            values: vec![vec![0.0], vec![10.0], vec![20.0]],
        };
        assert_eq!(inputs.at(0.0), [0.0]);
        assert_eq!(inputs.at(1.5), [5.0]);
        assert_eq!(inputs.at(3.0), [15.0]);
        assert_eq!(inputs.at(9.0), [20.0]);
        assert_eq!(inputs.next_corner(1.0), Some(2.0));
        assert_eq!(inputs.next_corner(4.0), None);
    }
}
