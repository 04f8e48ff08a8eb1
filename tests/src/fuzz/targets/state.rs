//! States in JSON lines, and the motion there.

use super::{check_mistake, file};
use crate::fuzz::{Corpus, Input};
use dynamics_cli::json::Text;
use dynamics_cli::lines::Lines;
use dynamics_cli::mistake::Mistake;
use dynamics_cli::parameters;
use dynamics_cli::state::{SHAPE, State};
use dynamics_codegen::Model;
use identify::machine::{Machine, States};
use rand::RngExt;

/// How often the whole file is one state, as `--init` takes it.
const WHOLE: f64 = 0.2;
/// Lines of a batch, as few as make several.
const BATCH: usize = 2;

pub(super) fn run(input: &Input) -> bool {
    let compiled = &Corpus::get().hosts()[input.host].compiled;
    let model = &compiled.model;
    let read = if input.choices().random_bool(WHOLE) {
        whole(input, model)
    } else {
        lines(input, model)
    };
    let states = match read {
        Ok(states) => states,
        Err(mistake) => {
            check_mistake(&mistake);
            return false;
        }
    };
    let machine = Machine::new(compiled.clone());
    for state in &states {
        check_motion(&machine, state);
    }
    true
}

fn lines(input: &Input, model: &Model) -> Result<Vec<State>, Mistake> {
    let file = file(input);
    let mut lines = Lines::open(file.path())?;
    let mut states = Vec::new();
    while let Some(batch) = lines.batch(BATCH)? {
        for line in &batch {
            states.push(state(line.text(), model)?);
        }
    }
    Ok(states)
}

fn whole(input: &Input, model: &Model) -> Result<Vec<State>, Mistake> {
    let text = Text {
        file: "--init",
        first_line: 1,
        text: parameters::text("--init", &input.bytes)?,
        shape: SHAPE,
    };
    Ok(vec![state(text, model)?])
}

fn state(text: Text<'_>, model: &Model) -> Result<State, Mistake> {
    let (state, warnings) = State::read(text, model, &model.nominal_parameters())?;
    warnings.iter().for_each(check_mistake);
    let numbers = state.q.iter().chain(&state.v).chain(&state.parameters);
    assert!(numbers.copied().all(f64::is_finite) && state.t.is_finite());
    assert_eq!(state.q.len(), model.coordinates.len());
    assert_eq!(state.v.len(), model.coordinates.len());
    Ok(state)
}

fn check_motion(machine: &Machine, state: &State) {
    let column = |values: &[f64]| -> Vec<Vec<f64>> { values.iter().map(|&x| vec![x]).collect() };
    let inputs = vec![0.0; machine.input_count()];
    let plain = States {
        t: vec![state.t],
        q: column(&state.q),
        v: column(&state.v),
        u: column(state.u.as_ref().unwrap_or(&inputs)),
        ..States::default()
    };
    let mut states = machine.at_rest(&plain, &state.parameters);
    for (column, &z) in states.memory.z.iter_mut().zip(state.z.iter().flatten()) {
        column[0] = z;
    }
    match machine.motion(&states, &state.parameters) {
        Ok(motions) => {
            let accelerations = motions.iter().flat_map(|motion| motion.acceleration.iter());
            assert!(accelerations.copied().all(f64::is_finite));
        }
        Err(error) => assert!(!format!("{error:?}").is_empty()),
    }
}
