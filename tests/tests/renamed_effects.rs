//! What effects and their parameters are called changes no number: nothing but their templates says
//! what they are.

use dynamics_codegen::{Library, compile};
use identify::fit::{Inertia, Source, fit};
use identify::log::Log;
use identify::trace::{Silent, trace};
use integration_tests::files::root;
use integration_tests::random;
use rand::RngExt as _;
use std::collections::BTreeMap;
use std::fmt::Write;

const WHEEL: &str = "\
model wheel;
coordinate angle: rad;
input motor: N*m;
body rim { frame: rotate_z(angle); mass: 2; inertia: diag(0.01, 0.01, 0.02); }
force angle = motor;
";

/// A wheel with friction in its bearing, of which the model says nothing, turned by known torques:
/// 20 s at 100 Hz with noise of the angle.
fn log() -> Log {
    let mut text = String::from("t,q_angle,u_motor\n");
    let mut rng = random::generator(3);
    for k in 0..2000 {
        let t = 0.01 * f64::from(k);
        let wave = |f: fn(f64, f64, f64) -> f64| f(1.1, 1.9, t) + f(0.4, 5.3, t);
        let q = wave(|s, o, t| s * (o * t).sin());
        let v = wave(|s, o, t| s * o * (o * t).cos());
        let a = wave(|s, o, t| -s * o * o * (o * t).sin());
        let u = 0.02 * a + 0.05 * v + 0.1 * (v / 0.03).tanh();
        let noise = 2e-5 * rng.random_range(-1.0..1.0);
        writeln!(text, "{t},{},{u}", q + noise).unwrap();
    }
    Log::from_bytes("wheel.csv", text.as_bytes()).unwrap()
}

/// A name that no code can know, in the same place of the alphabet.
fn renamed(name: &str) -> String {
    format!("my_{name}_own")
}

fn is_of_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// The text with other names for some words, but for those behind a dot: `center(of).x`.
fn with_words(text: &str, words: &[String]) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(begin) = rest.find(is_of_word) {
        let (before, from) = rest.split_at(begin);
        let (word, behind) = from.split_at(from.find(|c| !is_of_word(c)).unwrap_or(from.len()));
        out.push_str(before);
        match words.iter().any(|w| w == word) && !out.ends_with('.') {
            true => out.push_str(&renamed(word)),
            false => out.push_str(word),
        }
        rest = behind;
    }
    out + rest
}

/// A template whose parameters have other names. Units stand between `:` and `=` where something is
/// declared, and are no names: a mass may be called `m`.
fn with_other_names(text: &str, parameters: &[String]) -> String {
    let declares = |line: &str| {
        let words = ["parameter ", "state ", "constant "];
        words.iter().any(|word| line.starts_with(word))
    };
    let lines = text.lines().map(|line| match line.split_once(':') {
        _ if line.starts_with("//") => line.to_string(),
        Some((name, rest)) if declares(line) => {
            let (unit, value) = rest.split_at(rest.find('=').unwrap_or(rest.len()));
            let value = with_words(value, parameters);
            format!("{}:{unit}{value}", with_words(name, parameters))
        }
        _ => with_words(line, parameters),
    });
    lines.map(|line| line + "\n").collect()
}

/// The library under other names.
fn other_library() -> Library {
    let known = Library::builtin();
    let mut library = Library::empty();
    for name in known.names() {
        let path = root().join(format!("models/effects/{name}.model"));
        let text = std::fs::read_to_string(path).unwrap();
        let parameters = known.describe(name).unwrap().parameters;
        let parameters: Vec<String> = parameters.into_iter().map(|p| p.name).collect();
        let heading = format!("effect {name}(");
        assert!(text.contains(&heading), "{name}");
        let text = with_other_names(&text, &parameters);
        let text = text.replace(&heading, &format!("effect {}(", renamed(name)));
        library.add(renamed(name), format!("{name}.model"), text);
        assert!(library.describe(&renamed(name)).is_some(), "{name}");
    }
    library
}

/// All numbers of an answer, in order.
fn numbers(answer: &serde_json::Value, found: &mut Vec<f64>) {
    match answer {
        serde_json::Value::Number(number) => found.extend(number.as_f64()),
        serde_json::Value::Array(all) => all.iter().for_each(|one| numbers(one, found)),
        serde_json::Value::Object(all) => all.values().for_each(|one| numbers(one, found)),
        _ => (),
    }
}

fn numbers_of(answer: &impl serde::Serialize) -> Vec<f64> {
    let mut found = Vec::new();
    numbers(&serde_json::to_value(answer).unwrap(), &mut found);
    assert!(found.len() > 10);
    found
}

/// The same but for round-off: the order of a sum may follow that of names.
fn assert_same(known: &impl serde::Serialize, other: &impl serde::Serialize) {
    let [known, other] = [numbers_of(known), numbers_of(other)];
    assert_eq!(known.len(), other.len());
    for (a, b) in known.iter().zip(&other) {
        assert!((a - b).abs() <= 1e-6 * a.abs() + 1e-12, "{a} {b}");
    }
}

#[test]
fn a_fit_does_not_know_names() {
    let log = log();
    let fitted = |library: &Library| {
        let compiled = compile("wheel", WHEEL, library).unwrap();
        let source = Source {
            name: "wheel",
            text: WHEEL,
            library,
        };
        let request = identify::fit::Request {
            source,
            compiled: &compiled,
            parameters: &[],
            train: &log,
            test: None,
            inertia: Inertia::Consistent,
            leave_out: &[],
            trust_columns: false,
        };
        fit(&request).unwrap()
    };
    let [known, other] = [&Library::builtin(), &other_library()].map(fitted);
    assert!(!known.terms.is_empty(), "{known:?}");
    let names: Vec<&String> = other.terms[0].coefficients.keys().collect();
    assert_eq!(names, [&renamed("coulomb"), &renamed("viscous")]);
    assert_same(&known, &other);
}

#[test]
fn a_trace_does_not_know_names() {
    let log = log();
    let traced = |library: &Library| {
        let request = identify::trace::Request {
            model_name: "wheel",
            model_text: WHEEL,
            library,
            parameters: BTreeMap::new(),
            train: &log,
            test: None,
            hold: None,
            horizon: 0.5,
            seed: 1,
            trust_columns: false,
            progress: &Silent,
        };
        trace(&request).unwrap()
    };
    let [known, other] = [&Library::builtin(), &other_library()].map(traced);
    let effects = |outcome: &identify::trace::Outcome| -> Vec<String> {
        outcome.findings.iter().map(|f| f.effect.clone()).collect()
    };
    let own: Vec<String> = effects(&known).iter().map(|name| renamed(name)).collect();
    assert!(!own.is_empty());
    assert_eq!(effects(&other), own);
    assert_same(&known, &other);
}
