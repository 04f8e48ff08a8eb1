//! The messages of one topic, number by number.

use super::Cell;
use std::collections::HashMap;

/// Paths longer than this many bytes are no names of channels.
const LONGEST_NAME: usize = 1024;

/// Lists of a joint state and what their columns are called.
const JOINT_STATE: [(&str, &str); 3] = [
    (".position.", "q_"),
    (".velocity.", "dq_"),
    (".effort.", "u_"),
];

/// Names of the joints of a joint state.
const JOINT_NAMES: &str = ".name.";

/// Marks the column of a joint while it is open whether it can go without the topic's name.
const JOINT: char = '\0';

/// Seconds and nanoseconds of a header, behind `.header.stamp.` or `.stamp.`.
const STAMP: [[&str; 3]; 2] = [["sec", "secs", "seconds"], ["nanosec", "nsec", "nsecs"]];

/// What the numbers at a path are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A column.
    Plain,
    /// An entry of a list of a joint state.
    Joint(usize),
    /// Seconds or nanoseconds of the header.
    Stamp(usize),
}

impl Role {
    fn of(path: &str) -> Self {
        let stamp = path
            .strip_prefix(".header")
            .unwrap_or(path)
            .strip_prefix(".stamp.");
        if let Some(part) = stamp.and_then(|name| STAMP.iter().position(|p| p.contains(&name))) {
            return Self::Stamp(part);
        }
        let list = JOINT_STATE.iter().position(|(list, _)| {
            let entry = path.strip_prefix(list);
            entry.is_some_and(|entry| entry.bytes().all(|byte| byte.is_ascii_digit()))
        });
        list.map_or(Self::Plain, Self::Joint)
    }
}

/// A number's path, seen so far.
#[derive(Debug)]
struct Column {
    path: String,
    role: Role,
    /// Whether a message had a number there.
    has_values: bool,
}

/// The message that is being taken in.
#[derive(Debug, Default)]
struct Open {
    path: String,
    row: Vec<(usize, f64)>,
    /// Where the next number most likely goes: messages of a topic are alike.
    next: usize,
    names: Vec<String>,
    /// Lengths of the lists of a joint state.
    lists: [usize; 3],
    stamp: [Option<f64>; 2],
}

/// The messages of one topic.
#[derive(Debug, Default)]
pub(in crate::log) struct Topic {
    /// Its name.
    pub name: String,
    is_kept: bool,
    /// Whether it holds joint states.
    pub has_joints: bool,
    columns: Vec<Column>,
    index: HashMap<String, usize>,
    open: Open,
    /// The joints of the last joint state, and where the entries of its lists go.
    joints: Vec<String>,
    places: [Vec<usize>; 3],
    /// Times of logging and, where stated, of the header \[ns\].
    logged: Vec<i128>,
    stamped: Vec<Option<i128>>,
    /// Numbers of all messages, each with its column, and where those of a message end.
    cells: Vec<(usize, f64)>,
    ends: Vec<usize>,
}

impl Topic {
    /// One without messages. `is_kept`: whether messages are kept, not only names of their numbers.
    pub fn new(name: &str, is_kept: bool) -> Self {
        Self {
            name: name.to_owned(),
            is_kept,
            ..Self::default()
        }
    }

    /// Begins a message; one that was not ended is forgotten.
    pub fn begin(&mut self) {
        let mut path = std::mem::take(&mut self.open.path);
        path.clear();
        self.open = Open {
            path,
            row: std::mem::take(&mut self.open.row),
            ..Open::default()
        };
        self.open.row.clear();
    }

    /// Goes into a field of the message; returns what [`Topic::leave`] wants to go back.
    pub fn enter(&mut self, field: &str) -> usize {
        let before = self.open.path.len();
        // Longer than it may be is as good as much longer.
        if before <= LONGEST_NAME {
            self.open.path.push('.');
            self.open.path.push_str(field);
        }
        before
    }

    /// Goes back to where [`Topic::enter`] was called.
    pub fn leave(&mut self, before: usize) {
        self.open.path.truncate(before);
    }

    /// A text where the message stands.
    pub fn text(&mut self, text: &str) {
        let entry = self.open.path.strip_prefix(JOINT_NAMES);
        if entry.is_some_and(|entry| !entry.contains('.')) {
            self.open.names.push(text.to_owned());
        }
    }

    /// A number where the message stands; what is no number, NaN, was not measured.
    pub fn number(&mut self, value: f64) {
        if self.open.path.len() > LONGEST_NAME {
            return;
        }
        let column = self.column();
        self.open.next = column + 1;
        match self.columns[column].role {
            Role::Stamp(part) => self.open.stamp[part] = Some(value),
            Role::Joint(list) => self.open.lists[list] += 1,
            Role::Plain => {}
        }
        if !value.is_nan() {
            self.open.row.push((column, value));
        }
    }

    fn column(&mut self) -> usize {
        let next = self.columns.get(self.open.next);
        match next.is_some_and(|column| column.path == self.open.path) {
            true => self.open.next,
            false => self.numbered(&self.open.path.clone()),
        }
    }

    fn numbered(&mut self, path: &str) -> usize {
        if let Some(&column) = self.index.get(path) {
            return column;
        }
        let column = self.columns.len();
        self.columns.push(Column {
            path: path.to_owned(),
            role: Role::of(path),
            has_values: false,
        });
        self.index.insert(path.to_owned(), column);
        column
    }

    /// Ends the message, which was logged at this time \[ns\]; returns how many numbers are kept.
    pub fn end(&mut self, logged: i128) -> usize {
        self.name_joints();
        for (column, _) in &self.open.row {
            self.columns[*column].has_values = true;
        }
        if !self.is_kept && !self.has_joints {
            return 0;
        }
        self.logged.push(logged);
        self.stamped.push(self.header_stamp());
        self.open.row.sort_by_key(|(column, _)| *column);
        self.cells.extend_from_slice(&self.open.row);
        self.ends.push(self.cells.len());
        self.open.row.len()
    }

    /// Entries of the lists of a joint state go under the names of the joints.
    fn name_joints(&mut self) {
        let joints = std::mem::take(&mut self.open.names);
        if joints.is_empty() || !self.open.lists.contains(&joints.len()) {
            return;
        }
        if joints != self.joints {
            self.places = JOINT_STATE.map(|(_, prefix)| {
                let paths = joints.iter().map(|joint| format!("{JOINT}{prefix}{joint}"));
                paths.map(|path| self.numbered(&path)).collect()
            });
            self.joints = joints;
        }
        for list in 0..JOINT_STATE.len() {
            if self.open.lists[list] != self.joints.len() {
                continue;
            }
            for (column, _) in &mut self.open.row {
                let Column { path, role, .. } = &self.columns[*column];
                let entry = path.strip_prefix(JOINT_STATE[list].0);
                let entry = entry.filter(|_| *role == Role::Joint(list));
                if let Some(entry) = entry.and_then(|entry| entry.parse::<usize>().ok()) {
                    *column = self.places[list].get(entry).copied().unwrap_or(*column);
                }
            }
            self.has_joints |= list == 0;
        }
    }

    /// The stamp of the message's header; one of nought was never set.
    fn header_stamp(&self) -> Option<i128> {
        let [seconds, nanoseconds] = self.open.stamp.map(|part| part.map(|x| x as i128));
        let stamp = seconds?
            .checked_mul(1_000_000_000)?
            .checked_add(nanoseconds?)?;
        (stamp != 0).then_some(stamp)
    }

    /// Times of the messages \[ns\]: of their headers, if all have one, or of logging.
    pub fn stamps(&self, by_header: bool) -> Vec<i128> {
        match by_header {
            true => self.stamped.iter().flatten().copied().collect(),
            false => self.logged.clone(),
        }
    }

    /// Whether every message has a stamp in its header.
    pub fn is_stamped(&self) -> bool {
        self.stamped.iter().all(Option::is_some)
    }

    /// How many messages are kept.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// How many paths its numbers have.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    /// Names of the columns, each with its number. `alone`: whether it is the only topic with joint
    /// states, whose joints go without its name.
    pub fn names(&self, alone: bool) -> Vec<(String, usize)> {
        let named = self
            .columns
            .iter()
            .enumerate()
            .filter(|(_, column)| column.has_values && !matches!(column.role, Role::Stamp(_)));
        let full = named.map(|(number, column)| {
            let joint = column.path.strip_prefix(JOINT);
            let name = match joint {
                Some(joint) if alone && self.has_joints => joint.to_owned(),
                Some(joint) => format!("{}.{joint}", self.name),
                None => format!("{}{}", self.name, column.path),
            };
            (name, number)
        });
        let mut names: Vec<(String, usize)> = full.collect();
        names.sort();
        names
    }

    /// A number of a message.
    pub fn cell(&self, message: usize, column: usize) -> Cell {
        let begin = message.checked_sub(1).map_or(0, |before| self.ends[before]);
        let row = &self.cells[begin..self.ends[message]];
        let found = row.binary_search_by_key(&column, |(column, _)| *column);
        found.map_or(Cell::Empty, |found| Cell::Number(row[found].1))
    }
}
