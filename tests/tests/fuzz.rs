//! A few damaged inputs of every kind, always the same: `docs/robustness.md` tells of the many.

use integration_tests::fuzz::{Corpus, Input, Kind, Outcome, STACK, outcome};

const SEED: u64 = 1;
/// Inputs in all; their share of each kind is as in a long run.
const COUNT: u64 = 3000;

/// Runs the inputs of a kind; how many were accepted.
fn run(kind: Kind) -> u64 {
    let count = COUNT * kind.per_mille() / 1000;
    let mut accepted = 0;
    for index in 0..count {
        match outcome(&Input::new(kind, SEED, index)) {
            Outcome::Accepted => accepted += 1,
            Outcome::Refused => {}
            Outcome::Failed(failure) => panic!(
                "{}: {}\nagain: cargo run -p integration-tests --bin fuzz -- \
                 --kind {kind} --seed {SEED} --from {index}",
                failure.place, failure.message
            ),
        }
    }
    // Damage that nothing survives would say nothing about what comes behind a parser, and
    // damage that does no harm nothing about messages.
    assert!(
        accepted * 20 > count,
        "{kind}: {accepted} of {count} are accepted"
    );
    assert!(
        accepted * 20 < 19 * count,
        "{kind}: {accepted} of {count} are accepted"
    );
    accepted
}

#[test]
fn models_are_read_or_refused() {
    run(Kind::Model);
}

#[test]
fn robots_are_read_or_refused() {
    run(Kind::Urdf);
    run(Kind::Mjcf);
}

#[test]
fn effects_are_read_or_refused() {
    run(Kind::Effect);
}

#[test]
fn logs_are_read_or_refused() {
    run(Kind::Log);
}

#[test]
fn maps_are_read_or_refused() {
    run(Kind::Map);
}

#[test]
fn states_and_inputs_are_read_or_refused() {
    run(Kind::State);
    run(Kind::Inputs);
}

#[test]
fn controllers_are_read_or_refused() {
    run(Kind::Control);
}

/// What the targets do to what grows is more than to refuse it.
#[test]
fn undamaged_texts_are_accepted() {
    let whole = |kind: Kind| {
        Corpus::get()
            .of(kind)
            .iter()
            .enumerate()
            .map(move |(base, grown)| Input {
                kind,
                bytes: grown.text.clone().into_bytes(),
                host: grown.host,
                base,
                choice: 1,
            })
    };
    let check = move || {
        for input in [
            Kind::Urdf,
            Kind::Mjcf,
            Kind::Map,
            Kind::Inputs,
            Kind::Control,
        ]
        .into_iter()
        .flat_map(whole)
        {
            let text = String::from_utf8_lossy(&input.bytes);
            assert_eq!(outcome(&input), Outcome::Accepted, "{text}");
        }
    };
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(check);
    thread.unwrap().join().unwrap();
}
