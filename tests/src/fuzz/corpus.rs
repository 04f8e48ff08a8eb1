//! What damaged input grows from: the repository's own files.

use super::kind::Kind;
use super::token::{Class, tokens};
use crate::files::root;
use crate::models;
use dynamics_codegen::{Compiled, Model};
use flate2::read::GzDecoder;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Rows of a log: a little more than a log must have, so that a deletion does not make it too
/// short.
const ROWS: usize = 70;
/// Where most MJCF files are, and what they include.
pub(super) const MJCF: &str = "tests/mujoco/models";
/// States of a file of states.
const STATES: usize = 3;

/// A text that damaged ones grow from.
#[derive(Debug, Clone)]
pub struct Grown {
    /// The text.
    pub text: String,
    /// The model that it belongs to, an index into [`Corpus::hosts`]; 0 where it needs none.
    pub host: usize,
}

/// A model that logs, states, inputs and effects belong to.
#[derive(Debug, Clone)]
pub struct Host {
    /// Its text.
    pub text: String,
    /// Its equations.
    pub compiled: Compiled,
}

/// All texts, by kind, and the models that they need.
#[derive(Debug)]
pub struct Corpus {
    texts: BTreeMap<Kind, Vec<Grown>>,
    words: BTreeMap<Kind, Vec<String>>,
    hosts: Vec<Host>,
    recordings: Vec<Vec<u8>>,
}

impl Corpus {
    /// The repository's; read at the first call.
    ///
    /// # Panics
    /// If the repository's files are not there, or are faulty.
    pub fn get() -> &'static Self {
        static CORPUS: LazyLock<Corpus> = LazyLock::new(Corpus::read);
        &CORPUS
    }

    /// The texts of a kind; never empty.
    pub fn of(&self, kind: Kind) -> &[Grown] {
        &self.texts[&kind]
    }

    /// The words that occur in the texts of a kind, sorted; never empty.
    pub fn words(&self, kind: Kind) -> &[String] {
        &self.words[&kind]
    }

    /// The models of the language that come with the project.
    pub fn hosts(&self) -> &[Host] {
        &self.hosts
    }

    /// Logs in formats that are no text; never empty.
    pub fn recordings(&self) -> &[Vec<u8>] {
        &self.recordings
    }

    fn read() -> Self {
        let hosts: Vec<Host> = files("models", "model").iter().map(|p| host(p)).collect();
        let texts: BTreeMap<Kind, Vec<Grown>> = Kind::ALL
            .into_iter()
            .map(|kind| (kind, texts(kind, &hosts)))
            .collect();
        let words = texts.iter().map(|(&kind, texts)| (kind, words(texts)));
        Self {
            words: words.collect(),
            texts,
            hosts,
            recordings: recordings(),
        }
    }
}

/// The recordings that other libraries wrote.
fn recordings() -> Vec<Vec<u8>> {
    let endings = ["db3", "mcap", "ulg"];
    let all = endings
        .iter()
        .flat_map(|ending| files("tests/tests/fixtures/logs", ending));
    all.map(|path| std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
        .collect()
}

fn host(path: &Path) -> Host {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Host {
        text: text(path),
        compiled: models::one(&name),
    }
}

fn texts(kind: Kind, hosts: &[Host]) -> Vec<Grown> {
    let alone = |text: String| Grown { text, host: 0 };
    let of_hosts = |write: &dyn Fn(&Model) -> String| -> Vec<Grown> {
        let numbered = hosts.iter().enumerate();
        numbered
            .map(|(host, Host { compiled, .. })| Grown {
                text: write(&compiled.model),
                host,
            })
            .collect()
    };
    let found = match kind {
        Kind::Model => {
            let folders = ["models", "tests/data/models", "tests/data/measured"];
            let files = folders.iter().flat_map(|folder| files(folder, "model"));
            let examples = fenced("docs/model-language.md", |tags| {
                tags.starts_with("model") && !tags.contains("effect")
            });
            let files = files.map(|path| text(&path));
            files.chain(examples).map(alone).collect()
        }
        Kind::Urdf => {
            let folders = ["models", "tests/data/fuzz"];
            let files = folders.iter().flat_map(|folder| files(folder, "urdf"));
            files.map(|path| alone(text(&path))).collect()
        }
        Kind::Mjcf => {
            let folders = ["models", MJCF];
            let files = folders.iter().flat_map(|folder| files(folder, "xml"));
            let texts = files.map(|path| text(&path));
            // What another includes is none by itself.
            let whole = texts.filter(|text| text.contains("<worldbody>"));
            whole.map(alone).collect()
        }
        Kind::Effect => {
            let files = files("models/effects", "model");
            let examples = fenced("docs/model-language.md", |tags| tags == "model,effect");
            let files = files.iter().map(|path| text(path));
            files.chain(examples).map(alone).collect()
        }
        Kind::Log => logs(hosts),
        Kind::Map => {
            let examples = fenced("docs/log-format.md", |tags| tags == "toml");
            examples.into_iter().map(alone).collect()
        }
        Kind::State => of_hosts(&states),
        Kind::Inputs => of_hosts(&inputs),
        Kind::Control => of_hosts(&control),
    };
    assert!(!found.is_empty(), "there is nothing to grow {kind} from");
    found
}

fn words(texts: &[Grown]) -> Vec<String> {
    let all = texts.iter().flat_map(|grown| tokens(&grown.text));
    let words = all.filter(|token| token.class == Class::Word);
    let words: BTreeSet<String> = words.map(|token| token.text.into_owned()).collect();
    words.into_iter().collect()
}

/// The files of a folder with an ending, sorted.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder));
    let entries = entries.unwrap_or_else(|e| panic!("{folder}: {e}"));
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap_or_else(|e| panic!("{folder}: {e}")).path())
        .filter(|path| path.extension().is_some_and(|found| found == ending))
        .collect();
    paths.sort();
    paths
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The blocks of a page whose fence has the tags that are wanted.
fn fenced(page: &str, wanted: impl Fn(&str) -> bool) -> Vec<String> {
    let page = text(&root().join(page));
    let (mut blocks, mut open) = (Vec::new(), None);
    for line in page.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(tags)) => open = Some((wanted(tags), String::new())),
            (Some((wanted, block)), Some(_)) => {
                if *wanted {
                    blocks.push(std::mem::take(block));
                }
                open = None;
            }
            (Some((_, block)), None) => {
                block.push_str(line);
                block.push('\n');
            }
            (None, None) => {}
        }
    }
    blocks
}

/// The beginnings of the logs of the scenarios that show coordinates, with the first model that fits: a log of
/// sensors alone has a model of its own, which stands in its test.
fn logs(hosts: &[Host]) -> Vec<Grown> {
    let folder = root().join("tests/data/scenarios");
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{e}"));
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap_or_else(|e| panic!("{e}")).path())
        .map(|path| path.join("train.csv.gz"))
        .filter(|path| path.is_file())
        .collect();
    paths.sort();
    let beginning = |path: &PathBuf| {
        let file = std::fs::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let lines = BufReader::new(GzDecoder::new(file)).lines().take(ROWS + 1);
        let text: String = lines
            .map(|line| line.unwrap_or_else(|e| panic!("{}: {e}", path.display())) + "\n")
            .collect();
        let header: Vec<&str> = text.lines().next().unwrap_or_default().split(',').collect();
        if !header.iter().any(|column| column.starts_with("q_")) {
            return None;
        }
        let host = hosts
            .iter()
            .position(|host| fits(&host.compiled.model, &header));
        let host = host.unwrap_or_else(|| panic!("no model fits {}", path.display()));
        Some(Grown { text, host })
    };
    paths.iter().filter_map(beginning).collect()
}

/// Whether a log with this header has what a model needs.
fn fits(model: &Model, header: &[&str]) -> bool {
    let positions = model.coordinates.iter().map(|c| format!("q_{}", c.name));
    let inputs = model.inputs.iter().map(|u| format!("u_{}", u.name));
    positions
        .chain(inputs)
        .all(|name| header.contains(&name.as_str()))
}

/// States of a model: by name, in order, and the positions alone.
fn states(model: &Model) -> String {
    let named = |names: Vec<&String>, value: f64| -> String {
        let members = names.iter().map(|name| format!("{name:?}: {value}"));
        members.collect::<Vec<String>>().join(", ")
    };
    let listed = |count: usize, value: f64| vec![value.to_string(); count].join(", ");
    let coordinates: Vec<&String> = model.coordinates.iter().map(|c| &c.name).collect();
    let inputs: Vec<&String> = model.inputs.iter().map(|u| &u.name).collect();
    let states: Vec<&String> = model.states.iter().map(|z| &z.name).collect();
    let parameters: Vec<&String> = model.parameters.iter().map(|p| &p.name).collect();
    let n = coordinates.len();
    let mut text = String::new();
    for state in 0..STATES {
        let value = 0.1 * (1 + state) as f64;
        let line = match state {
            0 => format!(
                "{{\"q\": {{{}}}, \"v\": {{{}}}, \"u\": {{{}}}, \"z\": {{{}}}, \"t\": {value}, \"parameters\": {{{}}}}}",
                named(coordinates.clone(), value),
                named(coordinates.clone(), -value),
                named(inputs.clone(), value),
                named(states.clone(), value),
                named(parameters.clone(), 1.0),
            ),
            1 => format!(
                "{{\"q\": [{}], \"v\": [{}], \"u\": [{}]}}",
                listed(n, value),
                listed(n, -value),
                listed(inputs.len(), value),
            ),
            _ => format!("{{\"q\": [{}]}}", listed(n, value)),
        };
        // A model without internal states has no `z` to speak of.
        writeln!(text, "{line}").expect("text takes any number of lines");
    }
    text
}

/// A second of inputs of a model.
fn inputs(model: &Model) -> String {
    let names = model.inputs.iter().map(|u| format!(",u_{}", u.name));
    let mut text = format!("t{}\n", names.collect::<String>());
    for row in 0..20 {
        let t = f64::from(row) / 20.0;
        let values = (0..model.inputs.len()).map(|i| format!(",{:.4}", (3.0 * t + i as f64).sin()));
        writeln!(text, "{t}{}", values.collect::<String>()).expect("text takes any line");
    }
    text
}

/// A controller of a model that feeds back all positions and their rates.
fn control(model: &Model) -> String {
    let names: Vec<&String> = model.coordinates.iter().map(|c| &c.name).collect();
    let positions = names.iter().map(|name| format!("\"q_{name}\""));
    let rates = names.iter().map(|name| format!("\"rate(q_{name})\""));
    let feedback: Vec<String> = positions.chain(rates).collect();
    let row = |value: f64| vec![value.to_string(); feedback.len()].join(", ");
    let mut text = format!(
        "rate = 200\ndelay = 1\nfeedback = [{}]\nreference = [{}]\n\n[gain]\n",
        feedback.join(", "),
        row(0.0)
    );
    for (k, u) in model.inputs.iter().enumerate() {
        writeln!(text, "{:?} = [{}]", u.name, row(1.0 + k as f64)).expect("text takes any line");
    }
    text.push_str("\n[limits]\n");
    for u in model.inputs.iter().take(1) {
        writeln!(text, "{:?} = [-5, 5.5]", u.name).expect("text takes any line");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_texts_and_words() {
        let corpus = Corpus::get();
        for kind in Kind::ALL {
            assert!(
                !corpus.of(kind).is_empty() && !corpus.words(kind).is_empty(),
                "{kind}"
            );
        }
        assert!(corpus.of(Kind::Model).len() > 30);
        assert!(corpus.of(Kind::Effect).len() >= 29);
        assert!(corpus.of(Kind::Log).len() >= 9);
        assert_eq!(corpus.of(Kind::Map).len(), 7);
        let models: BTreeSet<usize> = corpus.of(Kind::Log).iter().map(|log| log.host).collect();
        assert!(models.len() >= 4, "{models:?}");
    }
}
