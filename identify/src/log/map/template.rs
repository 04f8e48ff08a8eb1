//! A map to start from, for a log whose columns are not called what the model calls them.

use super::PREFIXES;

/// What columns of each kind tend to be called, in the order of [`PREFIXES`].
const WORDS: [&[&str]; 4] = [
    &[
        "q", "pos", "position", "angle", "theta", "phi", "enc", "encoder", "x", "y", "z",
    ],
    &["dq", "qd", "vel", "velocity", "speed", "omega", "rate"],
    &["ddq", "qdd", "acc", "accel", "acceleration"],
    &[
        "u", "tau", "torque", "effort", "force", "cmd", "command", "current", "motor",
    ],
];

/// Names of time columns.
const TIMES: [&str; 7] = [
    "t",
    "time",
    "_time",
    "timestamp",
    "stamp",
    "secs",
    "seconds",
];

/// The text of a map: every channel that a model wants, each with the column that it most
/// likely is, to be checked and completed by hand.
pub fn template(columns: &[String], coordinates: &[String], inputs: &[String]) -> String {
    let time = columns.iter().find(|name| is_time(name));
    let mut text =
        String::from("# What the columns of the log are; docs/log-format.md has all keys.\n");
    text += "# Check every line: columns are guessed, units are those of the model.\n\n[time]\n";
    text += &format!("column = {}\n", quoted(time.map_or("", String::as_str)));
    text += "unit = \"s\"  # or ms, us, ns\n\n[columns]\n";
    let mut used: Vec<&String> = time.into_iter().collect();
    let wanted = [
        (0, coordinates, true),
        (1, coordinates, false),
        (2, coordinates, false),
        (3, inputs, true),
    ];
    for (kind, names, required) in wanted {
        let channels = names.iter().map(|name| format!("{}{name}", PREFIXES[kind]));
        // What is called as it should be needs no line.
        let (there, missing): (Vec<_>, Vec<_>) = names
            .iter()
            .zip(channels)
            .partition(|(_, channel)| columns.contains(channel));
        let there: Vec<String> = there.into_iter().map(|(_, channel)| channel).collect();
        used.extend(columns.iter().filter(|column| there.contains(column)));
        let candidates: Vec<&String> = columns
            .iter()
            .filter(|column| kind_of(column) == Some(kind) && !used.contains(column))
            .collect();
        let names: Vec<&String> = missing.iter().map(|(name, _)| *name).collect();
        for ((_, channel), guess) in missing.iter().zip(guesses(&candidates, &names)) {
            if guess.is_none() && !required {
                continue;
            }
            used.extend(guess);
            let unit = ["rad", "rad/s", "rad/s^2", "N*m"][kind];
            let (channel, column) = (key(channel), quoted(guess.map_or("", String::as_str)));
            text += &format!(
                "{channel} = {{ column = {column}, unit = \"{unit}\", sign = 1, offset = 0 }}\n"
            );
        }
    }
    let unused: Vec<&str> = columns
        .iter()
        .filter(|c| !used.contains(c))
        .map(String::as_str)
        .collect();
    if !unused.is_empty() {
        text += &format!(
            "\n# Columns not used above: {}\n",
            unused.join(", ").replace(char::is_control, " ")
        );
    }
    text
}

fn is_time(name: &str) -> bool {
    TIMES.iter().any(|time| name.eq_ignore_ascii_case(time))
}

/// Lower-case words of a name, digits apart.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in name.chars() {
        let joins =
            c.is_alphabetic() && last.is_alphabetic() && !(c.is_uppercase() && last.is_lowercase())
                || c.is_ascii_digit() && last.is_ascii_digit();
        match words.last_mut() {
            Some(word) if joins => word.extend(c.to_lowercase()),
            _ if c.is_alphanumeric() => words.push(c.to_lowercase().collect()),
            _ => {}
        }
        last = c;
    }
    words
}

/// What a column is, by the words in its name: rates before positions.
fn kind_of(name: &str) -> Option<usize> {
    if is_time(name) {
        return None;
    }
    let words = words(name);
    [2, 1, 3, 0].into_iter().find(|&kind| {
        words
            .iter()
            .any(|word| WORDS[kind].contains(&word.as_str()))
    })
}

/// A column for each name: the one that shares most words with it, and its number if it
/// has one. Where as many are left of both, they are taken in their order.
fn guesses<'a>(candidates: &[&'a String], names: &[&String]) -> Vec<Option<&'a String>> {
    let is_number = |word: &String| word.bytes().all(|byte| byte.is_ascii_digit());
    let mut left: Vec<&String> = candidates.to_vec();
    let mut found: Vec<Option<&String>> = Vec::new();
    for name in names {
        let own = words(name);
        let shared = |candidate: &String| {
            let theirs = words(candidate);
            let fits = own
                .iter()
                .filter(|word| is_number(word))
                .all(|n| theirs.contains(n));
            own.iter()
                .filter(|word| fits && theirs.contains(word))
                .count()
        };
        let best = left
            .iter()
            .map(|candidate| shared(candidate))
            .max()
            .unwrap_or(0);
        let mut alike = left
            .iter()
            .copied()
            .filter(|c| best > 0 && shared(c) == best);
        let only = alike.next().filter(|_| alike.next().is_none());
        left.retain(|candidate| Some(*candidate) != only);
        found.push(only);
    }
    if found.iter().filter(|guess| guess.is_none()).count() == left.len() {
        let mut left = left.into_iter();
        for guess in found.iter_mut().filter(|guess| guess.is_none()) {
            *guess = left.next();
        }
    }
    found
}

/// A string of TOML, on one line.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            _ if c.is_control() => out += &format!("\\u{:04X}", u32::from(c)),
            _ => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A key of TOML, quoted where it has to be.
fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.chars().all(bare) {
        name.to_owned()
    } else {
        quoted(name)
    }
}
