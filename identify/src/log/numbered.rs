//! Joints that a log knows by their numbers alone.

use super::map::{COMMANDED, PREFIXES};
use super::{Log, Warning};
use std::collections::{BTreeMap, BTreeSet};

/// What a numbered joint may be called beside its number and words of its own name.
const PLAIN: [&str; 5] = ["j", "joint", "axis", "a", "q"];

impl Log {
    /// Names the columns of a log that numbers its joints as a model does: `q_j1` becomes
    /// `q_left_arm_joint_1`, with `dq_j1`, `ddq_j1` and `u_j1`, and a warning says so.
    ///
    /// Only where nothing is left to guess: no coordinate has a column under its own name, each
    /// has a number of its own that exactly one `q_` column bears, no such column is left over,
    /// and columns are called by nothing but `j`, `joint`, `axis`, `a`, `q` or words of the
    /// coordinate's name beside it; likewise each column of an input. Otherwise the log stays as
    /// it is. A motor in front of a gear, `q_motor1`, is no joint.
    pub fn name_by_number(&mut self, coordinates: &[String], inputs: &[String]) {
        let joints = self.called(&["q_"]);
        let Some(joints) = matched(&joints, coordinates).filter(|m| m.len() == coordinates.len())
        else {
            return;
        };
        let Some(motors) = matched(&self.called(&["u_", COMMANDED]), inputs) else {
            return;
        };
        let new_name = |column: &String| {
            let (prefix, name) = split(column);
            let names = if prefix.starts_with('u') {
                &motors
            } else {
                &joints
            };
            let new = names.get(name).filter(|_| !prefix.is_empty());
            new.map_or_else(|| column.clone(), |new| format!("{prefix}{new}"))
        };
        let new_names: BTreeSet<String> = self.channels.keys().map(new_name).collect();
        if new_names.len() < self.channels.len() {
            return;
        }
        let channels = std::mem::take(&mut self.channels).into_iter();
        self.channels = channels
            .map(|(column, values)| (new_name(&column), values))
            .collect();
        self.warnings.push(Warning::Numbered {
            joints: joints.into_iter().collect(),
        });
    }

    /// What comes after some prefixes in the names of columns, each once.
    fn called(&self, prefixes: &[&str]) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for column in self.channels.keys() {
            let (prefix, name) = split(column);
            if prefixes.contains(&prefix) && !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        }
        names
    }
}

/// A column's prefix, empty if it has none, and the name behind it.
fn split(column: &str) -> (&str, &str) {
    let mut prefixes = PREFIXES.iter().chain(&[COMMANDED]);
    let prefix = prefixes.find(|prefix| column.starts_with(**prefix));
    column.split_at(prefix.map_or(0, |prefix| prefix.len()))
}

/// The name that each column's number means; `None` if it is not plain for all of them.
fn matched(columns: &[String], names: &[String]) -> Option<BTreeMap<String, String>> {
    if names.iter().any(|name| is_there(columns, name)) {
        return None;
    }
    let mut found: BTreeMap<String, String> = BTreeMap::new();
    for column in columns {
        let number = number(column)?;
        let mut alike = names
            .iter()
            .filter(|name| self::number(name) == Some(number));
        let name = alike.next()?;
        let own = words(name);
        let is_plain = |word: &String| PLAIN.contains(&word.as_str()) || own.contains(word);
        let is_taken = found.values().any(|taken| taken == name);
        if alike.next().is_some() || is_taken || !words(column).iter().all(is_plain) {
            return None;
        }
        found.insert(column.clone(), name.clone());
    }
    Some(found)
}

/// Whether a name has a column of its own. A coordinate may bear the whole name of its column:
/// `q_1`.
fn is_there(columns: &[String], name: &str) -> bool {
    columns
        .iter()
        .any(|column| column == name || column == split(name).1)
}

/// The last number in a name.
fn number(name: &str) -> Option<u64> {
    let mut runs = name.split(|c: char| !c.is_ascii_digit());
    runs.rfind(|run| !run.is_empty())?.parse().ok()
}

/// The words of a name, without numbers.
fn words(name: &str) -> Vec<String> {
    let runs = name.split(|c: char| !c.is_alphabetic());
    runs.filter(|run| !run.is_empty())
        .map(str::to_lowercase)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{headed, names};

    fn renamed(header: &str, joints: &[&str]) -> Vec<String> {
        let mut log = headed(header);
        let names = names(joints);
        log.name_by_number(&names, &names);
        log.channels.into_keys().collect()
    }

    const ARM: [&str; 2] = ["left_7_joint_1", "left_7_joint_2"];

    #[test]
    fn numbers_say_which_joint_is_meant() {
        let called = renamed("t,q_j1,q_j2,dq_j2,u_j1,load", &ARM);
        let own = [
            "dq_left_7_joint_2",
            "load",
            "q_left_7_joint_1",
            "q_left_7_joint_2",
            "u_left_7_joint_1",
        ];
        assert_eq!(called, own);
        assert_eq!(renamed("t,q_1,q_2,u_left1", &ARM)[0], "q_left_7_joint_1");
    }

    #[test]
    fn nothing_is_guessed() {
        let stays = |header: &str, joints: &[&str]| {
            let mut columns: Vec<&str> = header.split(',').skip(1).collect();
            columns.sort_unstable();
            assert_eq!(renamed(header, joints), columns, "{joints:?}");
        };
        // From nought on; a motor; one too many; one too few; an input that belongs to none.
        stays("t,q_0,q_1", &ARM);
        stays("t,q_motor1,q_motor2", &ARM);
        stays("t,q_1,q_2,q_3", &ARM);
        stays("t,q_2", &ARM);
        stays("t,q_1,q_2,u_3", &ARM);
        // One is called as it should be; two with one number; the whole name of the column.
        stays("t,q_1,q_left_7_joint_2", &ARM);
        stays("t,q_1,q_2,dq_1,dq_left_7_joint_1", &ARM);
        stays("t,q_1,q_2", &["left_1", "right_1"]);
        stays("t,q_1,q_2", &["q_1", "q_2"]);
    }
}
