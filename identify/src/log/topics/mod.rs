//! Messages of topics that come at rates of their own, brought to one table.
//!
//! Every number of a message is a column `topic.field.field`, with the index behind where it stands
//! in a list. Joint states (`name`, and `position`, `velocity`, `effort` of the same length) of the
//! only topic that has them are `q_<name>`, `dq_<name>` and `u_<name>`. One topic sets the pace: the
//! one that the map says, else the joint states, else the topic with most messages. `t` counts from
//! the first message, by the stamps in the headers where every message has one, by the time of
//! logging otherwise.
//!
//! A file of hours may hold thousands of numbers that no model asks for. Of these only the names are
//! kept, for whoever writes the map.

mod topic;

pub(super) use topic::Topic;

use super::error::{ProblemKind, Problems};
use super::limits::{self, MOST_CELLS};
use super::median_step;
use super::seen::Seen;
use super::table::{Cell, Demand, Table, from_columns};
use super::warning::Warning;
use std::collections::{BTreeMap, HashMap};

/// Lists longer than this are images and clouds of points, not joints.
pub(super) const LONGEST_LIST: usize = 128;

/// What a message costs beside its numbers, in numbers: its stamps and its place in lists.
const MESSAGE: usize = 8;

/// Words in the names of columns that hold between their samples: what was commanded.
const COMMANDS: [&str; 8] = [
    "effort", "torque", "tau", "command", "cmd", "u_", "setpoint", "actuator",
];

/// Topics while their messages are taken in.
#[derive(Debug)]
pub(super) struct Topics<'a> {
    demand: Demand<'a>,
    topics: Vec<Topic>,
    index: HashMap<String, usize>,
    ignored: BTreeMap<String, String>,
    size: usize,
    warnings: Vec<Warning>,
}

impl<'a> Topics<'a> {
    /// None so far; what is `demand`ed of them is kept.
    pub fn new(demand: Demand<'a>) -> Self {
        Self {
            demand,
            topics: Vec::new(),
            index: HashMap::new(),
            ignored: BTreeMap::new(),
            size: 0,
            warnings: Vec::new(),
        }
    }

    /// Takes in a message of a topic, logged at some time \[ns\], that `fill` reads. One that it
    /// cannot read, and why, ends the topic.
    ///
    /// # Errors
    /// If there are more numbers than a log may have.
    pub fn message(
        &mut self,
        name: &str,
        logged: i128,
        fill: impl FnOnce(&mut Topic) -> Result<(), String>,
    ) -> Result<(), Problems> {
        if self.ignored.contains_key(name) {
            return Ok(());
        }
        let index = match self.index.get(name) {
            Some(&index) => index,
            None => self.add(name)?,
        };
        let topic = &mut self.topics[index];
        topic.begin();
        if let Err(reason) = fill(topic) {
            self.ignore(name, reason);
            return Ok(());
        }
        let kept = topic.end(logged);
        if kept > 0 || topic.len() > 0 {
            self.size += MESSAGE + kept;
        }
        limits::check_columns(topic.width()).map_err(Problems::whole)?;
        match self.size as u64 > MOST_CELLS {
            true => Err(Problems::whole(ProblemKind::TooManyCells {
                limit: MOST_CELLS,
            })),
            false => Ok(()),
        }
    }

    fn add(&mut self, name: &str) -> Result<usize, Problems> {
        let index = self.topics.len();
        limits::check_columns(index + 1).map_err(Problems::whole)?;
        let inside = |column: &str| {
            column
                .strip_prefix(name)
                .is_some_and(|rest| rest.starts_with('.'))
        };
        let is_kept = self.demand.map.is_some_and(|map| {
            map.topic() == Some(name) || map.columns().any(|(column, _)| inside(column))
        });
        self.topics.push(Topic::new(name, is_kept));
        self.index.insert(name.to_owned(), index);
        Ok(index)
    }

    /// Leaves a topic out; says why.
    pub fn ignore(&mut self, name: &str, reason: impl Into<String>) {
        self.ignored
            .entry(name.to_owned())
            .or_insert_with(|| reason.into());
    }

    /// Says something of the file.
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// The columns that are asked for, all at the stamps of one topic.
    ///
    /// # Errors
    /// If no message could be read, or none that is asked for.
    pub fn table(mut self) -> Result<Table, Problems> {
        let ignored = std::mem::take(&mut self.ignored);
        self.topics
            .retain(|topic| !ignored.contains_key(&topic.name));
        if self.topics.is_empty() {
            let topics = ignored
                .into_iter()
                .map(|(topic, reason)| format!("{topic} ({reason})"));
            let topics = topics.collect();
            return Err(Problems::whole(ProblemKind::NoMessages { topics }));
        }
        let demand = self.demand;
        let alone = self.topics.iter().filter(|topic| topic.has_joints).count() == 1;
        let (mut unread, mut parts) = (Vec::new(), Vec::new());
        let topics = std::mem::take(&mut self.topics);
        let paced = |topic: &Topic| {
            demand
                .map
                .is_some_and(|map| map.topic() == Some(&topic.name))
        };
        for topic in topics {
            let names = topic.names(alone).into_iter();
            let (asked, other): (Vec<_>, Vec<_>) =
                names.partition(|(name, _)| topic.len() > 0 && demand.requires(name));
            unread.extend(other.into_iter().map(|(name, _)| name));
            if !asked.is_empty() || paced(&topic) {
                parts.push(Part {
                    topic,
                    columns: asked,
                });
            }
        }
        // Said only of what is missed; a file may hold dozens of topics that nobody asks for.
        let reasons = ignored.into_iter();
        let said = reasons.map(|(topic, reason)| Warning::IgnoredTopic { topic, reason });
        self.warnings.extend(said);
        let asked = demand.map.and_then(|map| map.topic());
        if let Some(topic) = asked.filter(|_| !parts.iter().any(|part| paced(&part.topic))) {
            let mut found: Vec<String> = parts.into_iter().map(|part| part.topic.name).collect();
            found.extend(
                unread
                    .iter()
                    .filter_map(|n| n.split('.').next())
                    .map(str::to_owned),
            );
            found.sort();
            found.dedup();
            let topic = topic.to_owned();
            return Err(Problems::whole(ProblemKind::NoTopic { topic, found }));
        }
        let mut table = match parts.is_empty() {
            true => nothing(&unread, demand)?,
            false => together(parts, demand, &mut self.warnings)?,
        };
        table.unread = unread;
        self.warnings.append(&mut table.warnings);
        table.warnings = self.warnings;
        Ok(table)
    }
}

/// A topic with the columns of it that are asked for.
struct Part {
    topic: Topic,
    columns: Vec<(String, usize)>,
}

/// A table without rows, for a map that names columns which are not there.
fn nothing(unread: &[String], demand: Demand<'_>) -> Result<Table, Problems> {
    if demand.map.is_some() {
        return Ok(Table {
            columns: Vec::new(),
            lines: Vec::new(),
            headless: false,
            unread: Vec::new(),
            warnings: Vec::new(),
        });
    }
    // Whoever asks knows what is missing, and adds it.
    let missing = Vec::new();
    let found = std::iter::once("t").chain(unread.iter().map(String::as_str));
    let found = found.map(Seen::named).collect();
    Err(Problems::whole(ProblemKind::MissingColumns {
        missing,
        found,
    }))
}

/// All parts at the stamps of one, while all of them last.
fn together(
    parts: Vec<Part>,
    demand: Demand<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<Table, Problems> {
    let chosen = demand.map.and_then(|map| map.topic());
    let pace = (0..parts.len()).max_by_key(|&i| {
        let topic = &parts[i].topic;
        let is_chosen = chosen == Some(topic.name.as_str());
        (is_chosen, topic.has_joints, topic.len(), parts.len() - i)
    });
    let pace = pace.unwrap_or(0);
    let stamps = seconds(&parts);
    let within = |ends: fn(&Vec<f64>) -> Option<&f64>| stamps.iter().filter_map(ends).copied();
    let begin = within(|stamps| stamps.first()).fold(f64::MIN, f64::max);
    let end = within(|stamps| stamps.last()).fold(f64::MAX, f64::min);
    let kept: Vec<usize> = (0..stamps[pace].len())
        .filter(|&k| parts.len() == 1 || (begin..=end).contains(&stamps[pace][k]))
        .collect();
    let width = 1 + parts.iter().map(|part| part.columns.len()).sum::<usize>();
    limits::check(kept.len(), width).map_err(Problems::whole)?;
    let t: Vec<f64> = kept.iter().map(|&k| stamps[pace][k]).collect();
    let numbers = t.iter().copied().map(Cell::Number);
    let mut columns = vec![("t".to_owned(), numbers.collect())];
    for (index, part) in parts.iter().enumerate() {
        let (topic, own) = (&part.topic, &stamps[index]);
        if index != pace && !own.is_sorted() {
            warnings.push(Warning::IgnoredTopic {
                topic: topic.name.clone(),
                reason: "its stamps run backwards".to_owned(),
            });
            continue;
        }
        for (name, column) in &part.columns {
            let cells = match index == pace {
                true => kept.iter().map(|&k| topic.cell(k, *column)).collect(),
                false => resampled(topic, name, *column, own, &t),
            };
            columns.push((name.clone(), cells));
        }
        if index != pace {
            warnings.push(Warning::Resampled {
                topic: topic.name.clone(),
                from: median_step(own),
                onto: (parts[pace].topic.name.clone(), median_step(&stamps[pace])),
            });
        }
    }
    from_columns(columns, demand)
}

/// Stamps in seconds from the first of all.
fn seconds(parts: &[Part]) -> Vec<Vec<f64>> {
    let by_header = parts.iter().all(|part| part.topic.is_stamped());
    let all: Vec<Vec<i128>> = parts
        .iter()
        .map(|part| part.topic.stamps(by_header))
        .collect();
    let origin = all.iter().flatten().min().copied().unwrap_or(0);
    let relative = all.iter().map(|stamps| {
        let stamps = stamps.iter().map(|stamp| (stamp - origin) as f64 * 1e-9);
        stamps.collect()
    });
    relative.collect()
}

/// A column of a topic at other stamps, all of them within its `own`.
fn resampled(topic: &Topic, name: &str, column: usize, own: &[f64], t: &[f64]) -> Vec<Cell> {
    let lower = name.to_ascii_lowercase();
    let holds = COMMANDS.iter().any(|word| lower.contains(word));
    let at = |t: &f64| {
        let above = own.partition_point(|stamp| stamp <= t).max(1);
        let before = topic.cell(above - 1, column);
        if holds || above == own.len() {
            return before;
        }
        match (before, topic.cell(above, column)) {
            (Cell::Number(a), Cell::Number(b)) => {
                let share = (t - own[above - 1]) / (own[above] - own[above - 1]);
                Cell::Number(a + (b - a) * share)
            }
            (before, _) => before,
        }
    };
    t.iter().map(at).collect()
}
