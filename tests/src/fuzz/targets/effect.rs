//! An effect template, applied to a model.

use super::check_compiled;
use crate::fuzz::{Corpus, Input, Kind};
use dynamics_codegen::syntax::written_name;
use dynamics_codegen::{Library, Model, compile};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

pub(super) fn run(input: &Input) -> bool {
    let Ok(text) = std::str::from_utf8(&input.bytes) else {
        // A library is read as text, file by file.
        return false;
    };
    let rng = &mut input.choices();
    let corpus = Corpus::get();
    let (name, ports) = heading(&corpus.of(Kind::Effect)[input.base].text);
    let host = corpus.hosts().choose(rng).expect("there are models");
    let places = places(&host.compiled.model, ports, rng);
    let model = format!("{}\neffect {name}({places});\n", host.text);
    let mut library = Library::builtin();
    library.look_in(crate::files::root().join("models"));
    library.add(name, input.file_name(), text);
    check_compiled(compile("host.model", &model, &library), rng)
}

/// The name of a template, and how many places it asks for.
fn heading(text: &str) -> (&str, usize) {
    let mut lines = text.lines();
    let line = lines.find_map(|line| line.strip_prefix("effect "));
    let line = line.expect("a template has a heading");
    let (name, behind) = line.split_once('(').unwrap_or((line, ")"));
    let (ports, _) = behind.split_once(')').unwrap_or((behind, ""));
    let count = ports
        .split(',')
        .filter(|port| !port.trim().is_empty())
        .count();
    (name.trim_end_matches(';'), count)
}

/// Places of a model, separated by commas: mostly of one sort, since most effects act on
/// coordinates alone or on inputs alone.
fn places(model: &Model, count: usize, rng: &mut ChaCha8Rng) -> String {
    let coordinates: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
    let inputs: Vec<&str> = model.inputs.iter().map(|u| u.name.as_str()).collect();
    let constraints: Vec<&str> = model.constraints.iter().map(|c| c.name.as_str()).collect();
    let sort = match rng.random_range(0..8_u32) {
        0..5 => coordinates,
        5..7 => inputs,
        _ => constraints,
    };
    let first = rng.random_range(0..sort.len().max(1));
    let places = (first..first + count).filter_map(|i| sort.get(i % sort.len().max(1)));
    let places: Vec<String> = places.map(|place| written_name(place)).collect();
    places.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_read() {
        assert_eq!(
            heading("/// Drag.\neffect viscous(joint);\n"),
            ("viscous", 1)
        );
        assert_eq!(heading("effect both(a, b: coordinate);"), ("both", 2));
        assert_eq!(heading("effect tilt;"), ("tilt", 0));
        assert_eq!(heading("effect tilt();"), ("tilt", 0));
    }
}
