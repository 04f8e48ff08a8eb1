//! The equations of a model that compiles: as code, on tapes, solved.

use crate::emitted;
use dynamics_codegen::derive::{Group, Item, Term, Variable};
use dynamics_codegen::emit::{Emission, Functions, operation_counts};
use dynamics_codegen::{Compiled, Model, Tape};
use identify::machine::{Lineariser, Machine, Rollout, RolloutOptions, Simulated, States};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

/// How often each is done; what takes longer, less often.
const EMITTED: f64 = 0.6;
const PARSED: f64 = 0.3;
const SOLVED: f64 = 0.6;
const DERIVED: f64 = 0.3;
/// Functions of a list at most.
const FUNCTIONS: usize = 3;
/// A state moves for this long, in seconds, as steps of the default length.
const DURATION: f64 = 0.01;

/// The bundles of [`Functions`], and what it does not know.
const LISTS: [&str; 9] = [
    "full",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
    "constrained_dynamics",
    "constrained_dynamics_derivatives",
    "residual_derivatives",
    "residual_by_parameters",
    "mass_matrix+bias_force",
    "nothing",
];

pub(super) fn check(compiled: &Compiled, rng: &mut ChaCha8Rng) {
    check_tape(compiled, rng);
    if rng.random_bool(EMITTED) {
        check_emission(compiled, rng);
    }
    if rng.random_bool(SOLVED) {
        check_motion(compiled, rng);
    }
}

/// The tape computes what the graph does.
fn check_tape(compiled: &Compiled, rng: &mut ChaCha8Rng) {
    let Compiled { model, system, .. } = compiled;
    let mut outputs = system.mass_matrix.concat();
    outputs.extend(&system.force);
    outputs.extend(system.constraint_matrix.iter().flatten());
    outputs.extend(&system.constraint_bias);
    outputs.extend(&system.outputs);
    outputs.extend(&system.state_rates);
    let arguments = system.arguments_of_forces(model);
    let values: Vec<f64> = arguments
        .iter()
        .map(|_| rng.random_range(-2.0..2.0))
        .collect();
    let mut symbols = vec![0.0; model.graph.symbol_count()];
    for (symbol, &value) in arguments.iter().zip(&values) {
        symbols[symbol.index()] = value;
    }
    let by_graph = model.graph.evaluate(&outputs, &symbols);
    let by_tape = Tape::new(&model.graph, &outputs, &arguments).evaluate(&values);
    for (a, b) in by_graph.iter().zip(&by_tape) {
        assert!(
            a == b || a.is_nan() && b.is_nan(),
            "graph {a:e}, tape {b:e}"
        );
    }
}

/// Code in both languages and the review sheet, with functions on request.
fn check_emission(compiled: &Compiled, rng: &mut ChaCha8Rng) {
    let list = function_list(rng);
    let functions: Functions = match list.parse() {
        Ok(functions) => functions,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let emission = match Emission::new(compiled, "fuzz.model", &functions) {
        Ok(emission) => emission,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let rust = emission.rust();
    emitted::check_visible(&rust);
    if rng.random_bool(PARSED) {
        emitted::check_rust(&rust);
    }
    for file in emission.c() {
        emitted::check_c(&file.text);
    }
    emitted::check_visible(&emission.review());
    assert!(!emission.operation_counts().is_empty());
    assert!(!operation_counts(compiled).is_empty());
}

/// A list of functions as a user may write one.
fn function_list(rng: &mut ChaCha8Rng) -> String {
    let name = |rng: &mut ChaCha8Rng| {
        let term = *Term::ALL.choose(rng).expect("there are terms");
        let group = *Group::ALL.choose(rng).expect("there are groups");
        match rng.random_range(0..3_u32) {
            0 => (*LISTS.choose(rng).expect("there are lists")).to_string(),
            1 => term.name().to_string(),
            _ => Item::slope(term, group).to_string(),
        }
    };
    let count = rng.random_range(0..=FUNCTIONS);
    let names: Vec<String> = (0..count).map(|_| name(rng)).collect();
    names.join(if rng.random_bool(0.8) { "," } else { "+" })
}

/// The motion at a random state, its derivatives, and a few steps from there. A state in
/// which there is none is no fault.
fn check_motion(compiled: &Compiled, rng: &mut ChaCha8Rng) {
    let mut machine = Machine::new(compiled.clone());
    let parameters = machine.nominal_parameters();
    let state = random_state(&compiled.model, rng);
    let state = machine.at_rest(&state, &parameters);
    let motions = match machine.motion(&state, &parameters) {
        Ok(motions) => motions,
        Err(error) => return assert!(!format!("{error:?}").is_empty()),
    };
    let finite = motions
        .iter()
        .all(|m| m.acceleration.iter().all(|a| a.is_finite()));
    assert!(
        finite,
        "an acceleration that is no number passes for a motion"
    );
    if rng.random_bool(DERIVED) {
        let tape = machine.sensitivity(&variables(&compiled.model));
        let slopes = tape.evaluate(&state, &parameters, &motions);
        assert_eq!(slopes.len(), 1);
        check_linearisation(compiled, &state, &parameters);
    }
    let rollout = Rollout::new(&machine, &parameters, RolloutOptions::default());
    let mut simulated = Simulated {
        q: state.q.clone(),
        v: state.v.clone(),
        z: Vec::new(),
    };
    let inputs = [&state.u[..], &state.memory.delayed].concat();
    let advanced = rollout.advance(&mut simulated, &state.t, DURATION, &inputs, &inputs);
    if let Err(error) = advanced {
        assert!(!format!("{error:?}").is_empty());
    }
}

/// What moves freely there, with outputs and sensors: numbers, or a reason why not.
fn check_linearisation(compiled: &Compiled, state: &States, parameters: &[f64]) {
    match Lineariser::new(compiled.clone()).at(state, parameters) {
        Ok(found) => {
            let r = found.basis.ncols();
            let off = &found.chart * &found.basis;
            let off = (0..r)
                .map(|i| (off[(i, i)] - 1.0).abs())
                .fold(0.0, f64::max);
            assert!(off < 1e-6, "coordinates that are none: {off:e}");
            if let Some(sampled) = found.sampled(DURATION) {
                assert!(sampled.a.iter().all(|x| x.is_finite()));
            }
        }
        Err(error) => assert!(!format!("{error:?}").is_empty()),
    }
}

/// One state anywhere near the origin.
fn random_state(model: &Model, rng: &mut ChaCha8Rng) -> States {
    let mut columns = |count: usize| -> Vec<Vec<f64>> {
        (0..count)
            .map(|_| vec![rng.random_range(-1.5..1.5)])
            .collect()
    };
    States {
        q: columns(model.positions().len()),
        v: columns(model.coordinates.len()),
        u: columns(model.inputs.len()),
        t: vec![0.5],
        ..States::default()
    }
}

/// What `eval --derivatives` derives by.
fn variables(model: &Model) -> Vec<Variable> {
    let n = model.coordinates.len();
    let mut variables: Vec<Variable> = (0..n).map(Variable::Position).collect();
    variables.extend((0..n).map(Variable::Velocity));
    variables.extend((0..model.inputs.len()).map(Variable::Input));
    variables.extend((0..model.parameters.len()).map(Variable::Parameter));
    variables.push(Variable::Time);
    variables
}
