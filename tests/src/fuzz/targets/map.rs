//! A map of a log's columns, and a log that has the columns it names.

use crate::fuzz::Input;
use identify::log::{Axis, Log, Map, Seen, Wanted, template};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;

/// Rows of the log: more than a log must have.
const ROWS: usize = 60;
/// Columns of the log at most; a map that names more is refused by it.
const COLUMNS: usize = 200;

pub(super) fn run(input: &Input) -> bool {
    let Ok(text) = std::str::from_utf8(&input.bytes) else {
        // A map is read as text.
        return false;
    };
    let rng = &mut input.choices();
    let map = match Map::parse(input.file_name(), text) {
        Ok(map) => map,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            assert!(
                error
                    .line
                    .is_none_or(|line| line <= 1 + text.matches('\n').count())
            );
            return false;
        }
    };
    let columns: Vec<String> = quoted(text).into_iter().collect();
    match Log::from_bytes_with("log.csv", log(&columns, rng).as_bytes(), Some(&map)) {
        Ok(log) => check_log(&log),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let names = &columns[..columns.len().min(3)];
    let axes = |unit: &str| -> Vec<Axis> {
        let axis = |name: &String| Axis {
            name: name.clone(),
            unit: unit.to_owned(),
            assumed: false,
        };
        names.iter().map(axis).collect()
    };
    let wanted = Wanted {
        coordinates: axes("m"),
        inputs: axes(""),
        gauges: Vec::new(),
    };
    let seen: Vec<Seen> = columns.iter().map(|name| Seen::named(name)).collect();
    let start = template(&seen, &wanted);
    Map::parse("template.toml", &start).unwrap_or_else(|e| panic!("{e}\n{start}"));
    true
}

/// What a log promises, whatever its file says.
pub(super) fn check_log(log: &Log) {
    assert!(
        log.t.windows(2).all(|pair| pair[0] < pair[1]),
        "stamps increase"
    );
    assert!(log.t.iter().all(|t| t.is_finite()));
    assert_eq!(log.lines.len(), log.len());
    for (name, values) in &log.channels {
        assert_eq!(values.len(), log.len(), "{name}");
        assert!(values.iter().all(|x| x.is_finite()), "{name} is finite");
    }
    assert_eq!(log.columns().len(), 1 + log.channels.len());
    for warning in &log.warnings {
        assert!(!warning.to_string().is_empty());
    }
}

/// All that a text has in quotes and what a heading can be, each once.
fn quoted(text: &str) -> BTreeSet<String> {
    let quoted = text.split('"').skip(1).step_by(2);
    let plain = |name: &&str| !name.is_empty() && !name.contains([',', ';', '\t', '\n', '\r', '#']);
    let names = quoted.map(str::trim).filter(plain).take(COLUMNS);
    names
        .filter(|name| *name != "t")
        .map(str::to_string)
        .collect()
}

/// A log of these columns, with empty cells here and there.
fn log(columns: &[String], rng: &mut ChaCha8Rng) -> String {
    let gaps = rng.random_bool(0.3);
    let mut text = String::from("t");
    columns
        .iter()
        .for_each(|name| text = format!("{text},{name}"));
    for row in 0..ROWS {
        text.push_str(&format!("\n{}", row * 10));
        for _ in columns {
            if gaps && rng.random_bool(0.1) {
                text.push(',');
            } else {
                text.push_str(&format!(",{:.3}", rng.random_range(-400.0..400.0_f64)));
            }
        }
    }
    text
}
