//! A map to start from, for a log whose columns are not called what the model calls them.

use super::{PREFIXES, unit};
use crate::log::seen::Seen;
use crate::log::wanted::{Axis, Wanted};

/// What columns of each kind tend to be called, in the order of [`PREFIXES`].
const WORDS: [&[&str]; 4] = [
    &[
        "q",
        "qpos",
        "pos",
        "position",
        "positions",
        "angle",
        "angles",
        "theta",
        "phi",
        "enc",
        "encoder",
        "x",
        "y",
        "z",
    ],
    &[
        "dq",
        "qd",
        "qvel",
        "vel",
        "velocity",
        "velocities",
        "speed",
        "speeds",
        "omega",
        "rate",
    ],
    &[
        "ddq",
        "qdd",
        "qacc",
        "acc",
        "accel",
        "acceleration",
        "accelerations",
    ],
    &[
        "u", "tau", "torque", "torques", "effort", "efforts", "force", "forces", "cmd", "command",
        "current", "currents", "voltage", "pwm", "motor",
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

/// Units of positions by the word for them in a column's name. A lone `m` or `s` is not among
/// them: it is a motor or a sample as often.
const POSITIONS: [(&str, &str); 11] = [
    ("deg", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("rad", "rad"),
    ("mrad", "mrad"),
    ("turn", "turn"),
    ("turns", "turn"),
    ("rev", "rev"),
    ("mm", "mm"),
    ("cm", "cm"),
    ("um", "um"),
];

/// Units of velocities and inputs by the word for them, each with its place in [`PREFIXES`].
const OTHERS: [(&str, &str, usize); 7] = [
    ("rpm", "rpm", 1),
    ("dps", "deg/s", 1),
    ("nm", "N*m", 3),
    ("mnm", "mN*m", 3),
    ("current", "A", 3),
    ("currents", "A", 3),
    ("voltage", "V", 3),
];

/// Units that no force has: a factor makes forces of them.
const ELECTRIC: [&str; 2] = ["A", "V"];

/// The text of a map: every channel that a model wants, each with the column that it most
/// likely is, to be checked and completed by hand. Units that columns do not state are the
/// model's.
pub fn template(columns: &[Seen], wanted: &Wanted) -> String {
    let names: Vec<String> = columns.iter().map(|seen| seen.name.clone()).collect();
    let mut text =
        String::from("# What the columns of the log are; docs/log-format.md has all keys.\n");
    text += match columns.iter().any(|seen| seen.glance.is_some()) {
        true => "# The log has no header: state the columns by their numbers, listed below.\n",
        false => "# Check every line: columns and units are guessed from their names.\n",
    };
    let time = time_of(columns);
    text += &format!("\n[time]\n{}", clock(time));
    text += "\n[columns]\n";
    let mut used: Vec<&String> = names.iter().filter(|name| Some(*name) == time).collect();
    let kinds = [
        (0, &wanted.coordinates, true),
        (1, &wanted.coordinates, false),
        (2, &wanted.coordinates, false),
        (3, &wanted.inputs, true),
    ];
    for (kind, axes, required) in kinds {
        let channel = |axis: &Axis| format!("{}{}", PREFIXES[kind], axis.name);
        // What is called as it should be needs no line.
        let (there, missing): (Vec<&Axis>, Vec<&Axis>) =
            axes.iter().partition(|axis| names.contains(&channel(axis)));
        let there: Vec<String> = there.into_iter().map(channel).collect();
        used.extend(names.iter().filter(|column| there.contains(column)));
        let candidates: Vec<&String> = names
            .iter()
            .filter(|column| kind_of(column) == Some(kind) && !used.contains(column))
            .collect();
        let called: Vec<&String> = missing.iter().map(|axis| &axis.name).collect();
        for (axis, guess) in missing.iter().zip(guesses(&candidates, &called)) {
            if guess.is_none() && !required {
                continue;
            }
            used.extend(guess);
            text += &line(kind, axis, guess.map(String::as_str));
        }
    }
    text + &unused(columns, &used)
}

/// The column of stamps: by its name, or the only one that rises as stamps do.
fn time_of(columns: &[Seen]) -> Option<&String> {
    let named = columns.iter().find(|seen| is_time(&seen.name));
    let rises = |seen: &&Seen| seen.glance.as_ref().is_some_and(|g| g.rises.is_some());
    let mut rising = columns.iter().filter(rises);
    let only = rising.next().filter(|_| rising.next().is_none());
    named.or(only).map(|seen| &seen.name)
}

/// What stands under `[time]`.
fn clock(time: Option<&String>) -> String {
    let unit = time.and_then(|name| unit_of_time(name)).unwrap_or("s");
    let column = source(time.map_or("", String::as_str));
    let rate = match time {
        Some(_) => "",
        None => {
            "# rate = 1000  # Hz: in place of both lines above, if there is no column of stamps\n"
        }
    };
    format!("column = {column}\nunit = \"{unit}\"  # s, ms, us or ns\n{rate}")
}

/// The line of a channel.
fn line(kind: usize, axis: &Axis, column: Option<&str>) -> String {
    let stated = column.and_then(|column| unit_for(column, kind));
    let unit = stated.unwrap_or_else(|| own_unit(kind, axis));
    let (channel, source) = (
        key(&format!("{}{}", PREFIXES[kind], axis.name)),
        source(column.unwrap_or("")),
    );
    let electric = kind == 3 && ELECTRIC.contains(&unit.as_str());
    let (factor, note) = match electric {
        true => (
            "factor = 1, ",
            format!("  # factor: {} per {unit}", own_unit(kind, axis)),
        ),
        false => ("", String::new()),
    };
    format!(
        "{channel} = {{ column = {source}, unit = {}, {factor}sign = 1, offset = 0 }}{note}\n",
        quoted(&unit)
    )
}

/// The unit in which a model has a channel, if a map can state it.
fn own_unit(kind: usize, axis: &Axis) -> String {
    let known = unit::factor(&axis.unit).is_ok();
    let (own, usual) = (axis.unit.trim(), if kind == 3 { "N*m" } else { "rad" });
    let unit = if known { own } else { usual };
    match kind {
        1 => format!("{unit}/s"),
        2 => format!("{unit}/s^2"),
        _ => unit.to_owned(),
    }
}

/// The columns that are left, for whoever completes the map.
fn unused(columns: &[Seen], used: &[&String]) -> String {
    if columns.iter().any(|seen| seen.glance.is_some()) {
        let listed = columns.iter().map(|seen| match &seen.glance {
            Some(glance) => format!("#   {}: {glance}\n", plain(&seen.name)),
            None => format!("#   {}\n", plain(&seen.name)),
        });
        return format!("\n# The columns:\n{}", listed.collect::<String>());
    }
    let left = columns.iter().filter(|seen| !used.contains(&&seen.name));
    let left: Vec<String> = left.map(|seen| plain(&seen.name)).collect();
    match left.is_empty() {
        true => String::new(),
        false => format!("\n# Columns not used above: {}\n", left.join(", ")),
    }
}

fn plain(name: &str) -> String {
    name.replace(char::is_control, " ")
}

fn is_time(name: &str) -> bool {
    let is = |name: &str| TIMES.iter().any(|time| name.eq_ignore_ascii_case(time));
    let bare = unit_of_time(name).and_then(|unit| {
        let bare = name.get(..name.len() - unit.len())?;
        bare.strip_suffix(['_', '.', ' '])
    });
    is(name) || bare.is_some_and(is)
}

/// The unit in which a column of stamps ends: `time_ms`.
fn unit_of_time(name: &str) -> Option<&'static str> {
    let last = words(name).pop()?;
    ["s", "ms", "us", "ns"]
        .into_iter()
        .find(|unit| *unit == last)
}

/// The unit that a column's name says, as a map writes it, and which kind of column has it:
/// `arm_deg`, `arm_deg_s`, `arm_deg_s2`, `arm_rpm`, `arm_Nm`, each also in front of a number.
fn unit_of(name: &str) -> Option<(usize, String)> {
    let words = words(name);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let mut rest = &words[..];
    let position = |word: &str| POSITIONS.iter().find(|(known, _)| *known == word);
    let speed = |word: &str| position(word).map_or((word == "m").then_some("m"), |(_, u)| Some(u));
    let is_number = |word: &str| word.bytes().all(|byte| byte.is_ascii_digit());
    loop {
        return match *rest {
            [.., base, "s", "2"] if speed(base).is_some() => {
                Some((2, format!("{}/s^2", speed(base)?)))
            }
            [.., base, "s"] if speed(base).is_some() => Some((1, format!("{}/s", speed(base)?))),
            [.., last] if position(last).is_some() => Some((0, position(last)?.1.into())),
            [ref front @ .., last] if is_number(last) && !front.is_empty() => {
                rest = front;
                continue;
            }
            [.., last] => {
                let other = OTHERS.iter().find(|(known, ..)| *known == last);
                other.map(|&(_, unit, kind)| (kind, unit.to_string()))
            }
            [] => None,
        };
    }
}

/// The unit of a column that is taken for one of a kind.
fn unit_for(name: &str, kind: usize) -> Option<String> {
    match unit_of(name)? {
        (own, unit) if own == kind => Some(unit),
        // `speed_deg`: per second, as speeds are.
        (0, unit) if kind == 1 => Some(format!("{unit}/s")),
        (0, unit) if kind == 2 => Some(format!("{unit}/s^2")),
        _ => None,
    }
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

/// What a column is, by the words in its name, rates before positions, or else by its unit.
fn kind_of(name: &str) -> Option<usize> {
    if is_time(name) {
        return None;
    }
    let words = words(name);
    let said = [2, 1, 3, 0].into_iter().find(|&kind| {
        words
            .iter()
            .any(|word| WORDS[kind].contains(&word.as_str()))
    });
    said.or_else(|| unit_of(name).map(|(kind, _)| kind))
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

/// A column as a map states it: a number where it has no name.
fn source(name: &str) -> String {
    match name.parse::<u32>() {
        Ok(number) if number > 0 && name == number.to_string() => name.to_owned(),
        _ => quoted(name),
    }
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
