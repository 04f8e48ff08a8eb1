//! Logs in MCAP files whose messages are JSON.
//!
//! Every number in a message becomes a column `topic.field.field`, with the index behind
//! where it stands in a list. Joint states (`name`, and `position`, `velocity`, `effort` of
//! the same length) of the only topic that has them become `q_<name>`, `dq_<name>` and
//! `u_<name>`. `t` counts from the first message: by the stamps in the headers where every
//! message has one, by the time of logging otherwise.

use super::error::{ProblemKind, Problems};
use super::limits::{self, MOST_CELLS};
use super::median_step;
use super::table::{Cell, Demand, Table, from_columns};
use super::warning::Warning;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use serde_json::Value;
use std::collections::BTreeMap;

/// Lists longer than this are images and clouds of points, not joints.
const LONGEST_LIST: usize = 128;

/// Records and chunks longer than this many bytes are refused.
const LARGEST_RECORD: usize = 1 << 28;

/// Paths longer than this many bytes are no names of channels.
const LONGEST_NAME: usize = 1024;

/// What a message costs beside its numbers, in numbers: its stamps and its place in lists.
const MESSAGE: usize = 8;

/// Lists of a joint state and what their columns are called.
const JOINT_STATE: [(&str, &str); 3] = [("position", "q_"), ("velocity", "dq_"), ("effort", "u_")];

/// Marks the column of a joint while it is open whether it can go without the topic's name.
const JOINT: char = '\0';

/// Words in the names of columns that hold between their samples: what was commanded.
const COMMANDS: [&str; 6] = ["effort", "torque", "tau", "command", "cmd", "u_"];

/// The messages of one topic.
#[derive(Debug, Default)]
struct Topic {
    name: String,
    /// Times of logging and, where stated, of the header \[ns\].
    logged: Vec<i128>,
    stamped: Vec<Option<i128>>,
    /// Names of the columns, each with its number.
    names: BTreeMap<String, usize>,
    /// Per message, the columns it has and their values, in the order of the columns.
    rows: Vec<Vec<(usize, f64)>>,
    has_joints: bool,
}

/// Reads all topics in JSON and brings them to the stamps of one.
pub(super) fn table(bytes: &[u8], demand: Demand<'_>) -> Result<Table, Problems> {
    let (mut topics, mut warnings) = read(bytes)?;
    for topic in &mut topics {
        topic.rename_joints();
    }
    let joints = topics.iter().filter(|topic| topic.has_joints).count();
    if joints > 1 {
        topics.iter_mut().for_each(Topic::qualify_joints);
    }
    // The positions set the pace; without them the topic with most messages.
    let base = (0..topics.len()).max_by_key(|&i| {
        let topic = &topics[i];
        (topic.has_joints, topic.rows.len(), topics.len() - i)
    });
    let Some(base) = base else {
        return from_columns(Vec::new(), demand);
    };
    let by_header = topics.iter().all(|t| t.stamped.iter().all(Option::is_some));
    let stamps: Vec<Vec<f64>> = seconds(&topics, by_header);
    let begin = stamps
        .iter()
        .filter_map(|s| s.first())
        .copied()
        .fold(f64::MIN, f64::max);
    let end = stamps
        .iter()
        .filter_map(|s| s.last())
        .copied()
        .fold(f64::MAX, f64::min);
    let kept: Vec<usize> = (0..stamps[base].len())
        .filter(|&k| topics.len() == 1 || (begin..=end).contains(&stamps[base][k]))
        .collect();
    let columns = 1 + topics.iter().map(|topic| topic.names.len()).sum::<usize>();
    limits::check(kept.len(), columns).map_err(fail)?;
    let t: Vec<f64> = kept.iter().map(|&k| stamps[base][k]).collect();
    let mut columns = vec![(
        "t".to_owned(),
        t.iter().copied().map(Cell::Number).collect(),
    )];
    for (index, topic) in topics.iter().enumerate() {
        if index != base && !stamps[index].is_sorted() {
            warnings.push(Warning::IgnoredTopic {
                topic: topic.name.clone(),
                reason: "its stamps run backwards".to_owned(),
            });
            continue;
        }
        for (name, &column) in &topic.names {
            let name = name.trim_start_matches(JOINT);
            let cells = if index == base {
                kept.iter().map(|&k| topic.cell(k, column)).collect()
            } else {
                topic.resampled(name, column, &stamps[index], &t)
            };
            columns.push((name.to_owned(), cells));
        }
        if index != base {
            warnings.push(Warning::Resampled {
                topic: topic.name.clone(),
                from: median_step(&stamps[index]),
                onto: (topics[base].name.clone(), median_step(&stamps[base])),
            });
        }
    }
    let mut table = from_columns(columns, demand)?;
    warnings.append(&mut table.warnings);
    table.warnings = warnings;
    Ok(table)
}

fn fail(kind: ProblemKind) -> Problems {
    let mut problems = Problems::default();
    problems.push(None, None, kind);
    problems
}

/// The topics in JSON, in the order of their first message, and what was left out.
fn read(bytes: &[u8]) -> Result<(Vec<Topic>, Vec<Warning>), Problems> {
    let damaged = |error: mcap::McapError| {
        fail(ProblemKind::Damaged {
            format: "MCAP file",
            reason: error.to_string(),
        })
    };
    let mut topics: Vec<Topic> = Vec::new();
    let mut ignored: BTreeMap<String, String> = BTreeMap::new();
    let mut size = 0;
    // Checked first: a damaged chunk may say that it has more than memory holds.
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LARGEST_RECORD);
    for message in MessageReader::new_with_options(bytes, options) {
        let message = message.map_err(damaged)?;
        let (name, encoding) = (&message.channel.topic, &message.channel.message_encoding);
        if encoding != "json" {
            ignored.insert(
                name.clone(),
                format!("its messages are `{encoding}`, not `json`"),
            );
            continue;
        }
        let Ok(value) = serde_json::from_slice::<Value>(&message.data) else {
            let reason = format!("message {} of it is no JSON", message.sequence);
            ignored.insert(name.clone(), reason);
            continue;
        };
        let index = topics.iter().position(|topic| topic.name == *name);
        let index = index.unwrap_or_else(|| {
            topics.push(Topic {
                name: name.clone(),
                ..Topic::default()
            });
            topics.len() - 1
        });
        size += MESSAGE + topics[index].add(i128::from(message.log_time), &value);
        limits::check_columns(topics[index].names.len()).map_err(fail)?;
        if size as u64 > MOST_CELLS {
            return Err(fail(ProblemKind::TooManyCells { limit: MOST_CELLS }));
        }
    }
    topics.retain(|topic| !ignored.contains_key(&topic.name));
    if topics.is_empty() {
        let topics = ignored
            .into_iter()
            .map(|(topic, reason)| format!("{topic} ({reason})"));
        let topics = topics.collect();
        return Err(fail(ProblemKind::NoMessages { topics }));
    }
    let warnings = ignored.into_iter();
    let warnings = warnings.map(|(topic, reason)| Warning::IgnoredTopic { topic, reason });
    Ok((topics, warnings.collect()))
}

/// Stamps in seconds from the first of all.
fn seconds(topics: &[Topic], by_header: bool) -> Vec<Vec<f64>> {
    let of = |topic: &Topic| -> Vec<i128> {
        if by_header {
            topic.stamped.iter().flatten().copied().collect()
        } else {
            topic.logged.clone()
        }
    };
    let all: Vec<Vec<i128>> = topics.iter().map(of).collect();
    let origin = all.iter().flatten().min().copied().unwrap_or(0);
    let relative = all.iter().map(|stamps| {
        let stamps = stamps.iter().map(|stamp| (stamp - origin) as f64 * 1e-9);
        stamps.collect()
    });
    relative.collect()
}

impl Topic {
    /// Takes a message in; returns how many numbers it has.
    fn add(&mut self, logged: i128, message: &Value) -> usize {
        self.logged.push(logged);
        self.stamped.push(header_stamp(message));
        let mut row = BTreeMap::new();
        let names = joint_names(message);
        for (list, prefix) in JOINT_STATE {
            let values = message.get(list).and_then(Value::as_array);
            let values = values.filter(|values| values.len() == names.len() && !names.is_empty());
            for (name, value) in names.iter().zip(values.into_iter().flatten()) {
                if let Some(value) = value.as_f64() {
                    self.has_joints |= prefix == "q_";
                    row.insert(format!("{JOINT}{prefix}{name}"), value);
                }
            }
        }
        let is_joint_state = !row.is_empty();
        flatten(&self.name, message, &mut |name, value| {
            let inside =
                |(list, _): &(&str, &str)| name.starts_with(&format!("{}.{list}.", self.name));
            if !is_joint_state || !JOINT_STATE.iter().any(inside) {
                row.insert(name, value);
            }
        });
        let mut numbered: Vec<(usize, f64)> = row
            .into_iter()
            .map(|(name, value)| {
                let next = self.names.len();
                (*self.names.entry(name).or_insert(next), value)
            })
            .collect();
        numbered.sort_unstable_by_key(|(column, _)| *column);
        let size = numbered.len();
        self.rows.push(numbered);
        size
    }

    /// Only the joints of a joint state go without the topic's name.
    fn rename_joints(&mut self) {
        if !self.has_joints {
            self.qualify_joints();
        }
    }

    fn qualify_joints(&mut self) {
        let qualified = |name: String| match name.strip_prefix(JOINT) {
            Some(joint) => format!("{}.{joint}", self.name),
            None => name,
        };
        let names = std::mem::take(&mut self.names).into_iter();
        self.names = names
            .map(|(name, column)| (qualified(name), column))
            .collect();
    }

    fn cell(&self, row: usize, column: usize) -> Cell {
        let row = &self.rows[row];
        let found = row.binary_search_by_key(&column, |(column, _)| *column);
        found.map_or(Cell::Empty, |found| Cell::Number(row[found].1))
    }

    /// The column at other stamps, all of them within its own.
    fn resampled(&self, name: &str, column: usize, own: &[f64], t: &[f64]) -> Vec<Cell> {
        let holds = COMMANDS
            .iter()
            .any(|word| name.to_ascii_lowercase().contains(word));
        let at = |t: &f64| {
            let above = own.partition_point(|stamp| stamp <= t).max(1);
            let before = self.cell(above - 1, column);
            if holds || above == own.len() {
                return before;
            }
            match (before, self.cell(above, column)) {
                (Cell::Number(a), Cell::Number(b)) => {
                    let share = (t - own[above - 1]) / (own[above] - own[above - 1]);
                    Cell::Number(a + (b - a) * share)
                }
                (before, _) => before,
            }
        };
        t.iter().map(at).collect()
    }
}

/// Names of the joints of a joint state.
fn joint_names(message: &Value) -> Vec<&str> {
    let names = message.get("name").and_then(Value::as_array);
    let names = names.into_iter().flatten();
    let names: Option<Vec<&str>> = names.map(Value::as_str).collect();
    names.unwrap_or_default()
}

/// `header.stamp` or `stamp`, in nanoseconds.
fn header_stamp(message: &Value) -> Option<i128> {
    let header = message.get("header").unwrap_or(message);
    let stamp = header.get("stamp")?;
    let part = |names: [&str; 3]| {
        let found = names.iter().find_map(|name| stamp.get(*name));
        found.and_then(Value::as_i64).map(i128::from)
    };
    let (seconds, nanoseconds) = (
        part(["sec", "secs", "seconds"])?,
        part(["nanosec", "nsec", "nsecs"])?,
    );
    Some(1_000_000_000 * seconds + nanoseconds)
}

/// Every number of a message under its path. `serde_json` bounds the depth.
fn flatten(path: &str, value: &Value, found: &mut impl FnMut(String, f64)) {
    if path.len() > LONGEST_NAME {
        return;
    }
    match value {
        Value::Number(number) => {
            if let Some(number) = number.as_f64() {
                found(path.to_owned(), number);
            }
        }
        Value::Object(fields) => {
            for (name, field) in fields {
                flatten(&format!("{path}.{name}"), field, found);
            }
        }
        Value::Array(items) if items.len() <= LONGEST_LIST => {
            for (index, item) in items.iter().enumerate() {
                flatten(&format!("{path}.{index}"), item, found);
            }
        }
        _ => {}
    }
}
