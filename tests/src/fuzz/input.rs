//! One input, made from its number alone.

use super::bytes;
use super::corpus::Corpus;
use super::kind::Kind;
use super::mutate::mutated;
use crate::random::generator;
use flate2::Compression;
use flate2::write::GzEncoder;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::io::Write;

/// How many logs are compressed, how many are recordings in formats that are no text, and how many
/// inputs have damaged bytes.
const COMPRESSED: f64 = 0.15;
const RECORDED: f64 = 0.1;
const DAMAGED: f64 = 0.12;
/// Damages to bytes at most.
const DAMAGES: usize = 6;

/// A damaged file, with what else is random in a run of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// What it is.
    pub kind: Kind,
    /// The file.
    pub bytes: Vec<u8>,
    /// The model that it is meant for: an index into [`Corpus::hosts`].
    pub host: usize,
    /// Which text of the corpus it has grown from.
    pub base: usize,
    /// Seed of what the target chooses: functions to emit, states to evaluate at.
    pub choice: u64,
}

impl Input {
    /// Input `index` of a kind and a seed.
    pub fn new(kind: Kind, seed: u64, index: u64) -> Self {
        let mut rng = generator(seed);
        // A stream of its own: 2^56 inputs of every kind.
        rng.set_stream(((kind as u64) << 56) | index);
        let corpus = Corpus::get();
        let texts = corpus.of(kind);
        // Of two, the shorter one more often: more inputs in the same time.
        let any = |rng: &mut ChaCha8Rng| rng.random_range(0..texts.len());
        let (a, b) = (any(&mut rng), any(&mut rng));
        let longer = texts[a].text.len() > texts[b].text.len();
        let base = if longer && rng.random_bool(0.7) { b } else { a };
        let text = mutated(corpus, kind, &mut rng, &texts[base].text);
        Self {
            kind,
            bytes: encoded(kind, &mut rng, text),
            host: texts[base].host,
            base,
            choice: rng.random(),
        }
    }

    /// Random numbers for what the target chooses; the same at each call.
    pub fn choices(&self) -> ChaCha8Rng {
        generator(self.choice)
    }

    /// What a file of this kind is called.
    pub fn file_name(&self) -> &'static str {
        match self.kind {
            Kind::Model => "fuzz.model",
            Kind::Urdf => "fuzz.urdf",
            Kind::Mjcf => "fuzz.xml",
            Kind::Effect => "effect.model",
            Kind::Log => "log.csv",
            Kind::Map => "log.toml",
            Kind::Control => "control.toml",
            Kind::State => "states.jsonl",
            Kind::Inputs => "inputs.csv",
        }
    }
}

fn encoded(kind: Kind, rng: &mut ChaCha8Rng, text: String) -> Vec<u8> {
    if kind == Kind::Log && rng.random_bool(RECORDED) {
        let recordings = Corpus::get().recordings();
        let mut bytes = recordings[rng.random_range(0..recordings.len())].clone();
        let count = rng.random_range(1..=DAMAGES);
        bytes::damage(rng, &mut bytes, count);
        return bytes;
    }
    let mut bytes = text.into_bytes();
    if kind == Kind::Log && rng.random_bool(COMPRESSED) {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        let written = encoder.write_all(&bytes).and_then(|()| encoder.finish());
        bytes = written.expect("memory takes any bytes");
    }
    if rng.random_bool(DAMAGED) {
        let count = rng.random_range(1..=DAMAGES);
        bytes::damage(rng, &mut bytes, count);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn an_input_is_its_number() {
        for kind in Kind::ALL {
            let input = Input::new(kind, 7, 3);
            assert_eq!(input, Input::new(kind, 7, 3));
            let all: BTreeSet<Vec<u8>> = (0..20).map(|i| Input::new(kind, 7, i).bytes).collect();
            assert!(all.len() > 15, "{kind}: {} of 20 differ", all.len());
            assert_ne!(input.choice, Input::new(kind, 8, 3).choice);
        }
    }
}
