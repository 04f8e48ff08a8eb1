//! A log: read, with and without a map, looked at, smoothed.

use crate::fuzz::{Corpus, Input};
use dynamics_codegen::Model;
use identify::log::{Log, LogError, Map, Record};
use identify::smooth::{savgol_states, smooth};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;

/// How often a map explains the columns.
const MAPPED: f64 = 0.3;
/// How often the log is smoothed by maximum likelihood, which takes a hundred times as long as
/// to read it.
const SMOOTHED: f64 = 0.25;

pub(super) fn run(input: &Input) -> bool {
    let rng = &mut input.choices();
    let model = &Corpus::get().hosts()[input.host].compiled.model;
    let map = rng.random_bool(MAPPED).then(|| map(model, rng));
    let mut log = match Log::from_bytes_with(input.file_name(), &input.bytes, map.as_ref()) {
        Ok(log) => log,
        Err(error) => return refused(&error),
    };
    super::map::check_log(&log);
    let coordinates: Vec<String> = model.coordinates.iter().map(|c| c.name.clone()).collect();
    let inputs: Vec<String> = model.inputs.iter().map(|u| u.name.clone()).collect();
    log.name_by_number(&coordinates, &inputs);
    log.assume_no_input(inputs.iter().map(String::as_str));
    match log.select(&coordinates, &inputs) {
        Ok(record) => {
            check_record(record, rng);
            true
        }
        Err(error) => refused(&error),
    }
}

fn refused(error: &LogError) -> bool {
    assert!(!error.to_string().is_empty());
    false
}

/// A map of all channels of a model onto their own columns, otherwise of any content.
fn map(model: &Model, rng: &mut ChaCha8Rng) -> Map {
    const UNITS: [&str; 6] = ["", "deg", "mm", "rpm", "turn", "kN"];
    let mut text = String::from("[columns]\n");
    let positions = model.coordinates.iter().map(|c| format!("q_{}", c.name));
    let inputs = model.inputs.iter().map(|u| format!("u_{}", u.name));
    for channel in positions.chain(inputs) {
        let column = toml_text(&channel);
        write!(text, "{column} = {{ column = {column}").expect("text takes any text");
        let unit = UNITS.choose(rng).expect("there are units");
        if !unit.is_empty() {
            write!(text, ", unit = \"{unit}\"").expect("text takes any text");
        }
        for (key, values) in [
            ("sign", &["1", "-1"][..]),
            ("factor", &["0", "1e-3", "1e308"]),
            ("offset", &["0.5", "-1e300"]),
            ("wraps", &["360", "1e-300"]),
            ("fill", &["\"hold\"", "\"linear\""]),
        ] {
            if rng.random_bool(0.2) {
                let value = values.choose(rng).expect("there are values");
                write!(text, ", {key} = {value}").expect("text takes any text");
            }
        }
        text.push_str(" }\n");
    }
    Map::parse("log.toml", &text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A name as TOML writes it.
fn toml_text(name: &str) -> String {
    serde_json::Value::from(name).to_string()
}

/// What is done with the channels of every log, up to the search.
fn check_record(record: Record, rng: &mut ChaCha8Rng) {
    for warning in &record.warnings {
        assert!(!warning.to_string().is_empty());
    }
    let n = record.len();
    let segments = record.segments();
    assert_eq!(
        segments.iter().map(ExactSizeIterator::len).sum::<usize>(),
        n
    );
    assert!(record.step() > 0.0);
    assert!(record.thinned(3).len() <= n);
    assert_eq!(record.slice(0..n / 2).len(), n / 2);
    if let Err(error) = savgol_states(&record) {
        assert!(!error.to_string().is_empty());
    }
    if rng.random_bool(SMOOTHED) {
        match smooth(&record) {
            Ok(smoothed) => assert_eq!(smoothed.len(), record.q.len()),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}
