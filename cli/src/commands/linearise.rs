//! `dynamics linearise`: matrices of the equations of motion at a state.

use super::simulate::positive;
use crate::answer::{Answer, Quantity};
use crate::mistake::Mistake;
use crate::model::ModelArguments;
use crate::state::State;
use crate::{output, start};
use clap::Args;
use dynamics_codegen::Model;
use identify::machine::{Linearisation, Lineariser, Memory, States};
use std::io::Write;

/// Arguments of `linearise`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics linearise models/cartpole.model --state '{\"q\": {\"x\": 0, \"theta\": 3.14159265}}'
  dynamics linearise models/fourbar.model --state crank.json --hold 0.002 --json

Fields of an answer:
  x, u, y      the state (on the constraints), the inputs, outputs and sensors, by name
  positions    how many of the free coordinates are positions
  basis        what the free coordinates do to the state, one row per name; of a body that
               floats by its twist, displacements along that twist
  chart        which free coordinates a deviation of the state is; chart basis = 1
  drift        how the free coordinates move by themselves; zero at a state of rest
  A, B, C, D   the matrices; rows of C and D by the names of outputs and sensors")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The state: a JSON file, or the JSON itself; fields as in `eval`. It is moved onto the
    /// constraints. Without it everything is zero
    #[arg(long, value_name = "STATE")]
    state: Option<String>,

    /// Sample with this interval and inputs held in between, instead of continuous time
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    hold: Option<f64>,

    /// Print one JSON object instead of text for people
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// If the model or the state is faulty, or the equations cannot be solved there.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let loaded = arguments.model.load()?;
    let model = &loaded.compiled.model;
    let mut state = match &arguments.state {
        Some(given) => start::read("--state", given, model, &loaded.parameters)?,
        None => State::zero(model, &loaded.parameters),
    };
    let u = state
        .u
        .clone()
        .unwrap_or_else(|| vec![0.0; model.inputs.len()]);
    let lineariser = Lineariser::new(loaded.compiled.clone());
    if let Some(moved) = start::settle(lineariser.machine(), &mut state, &u)? {
        output::complain(&moved);
    }
    let mut at = start::at(state.t, &state.q, &state.v, &u);
    at.memory.z = state
        .z
        .as_deref()
        .map_or_else(Vec::new, |z| z.iter().map(|&z| vec![z]).collect());
    let at = lineariser.machine().at_rest(&at, &state.parameters);
    let mut found = lineariser
        .at(&at, &state.parameters)
        .map_err(|error| start::stopped(error, state.t))?;
    if let Some(hold) = arguments.hold {
        found = found.sampled(hold).ok_or_else(|| {
            let message = format!("over {hold} s the linearisation grows beyond all numbers");
            Mistake::new(message).help("shorten `--hold`, or give a state closer to rest")
        })?;
    }
    let answer = answer(model, &at, &found);
    let mut out = output::stdout();
    if arguments.json {
        serde_json::to_writer(&mut out, &answer)?;
        writeln!(out)?;
    } else {
        let time = match arguments.hold {
            Some(hold) => format!("from one sample to the next, {hold} s later"),
            None => "per second".to_string(),
        };
        let title = format!("{}, {time}", loaded.path.display());
        write!(out, "{}", answer.page(&title))?;
    }
    Ok(out.flush()?)
}

fn answer(model: &Model, at: &States, found: &Linearisation) -> Answer {
    // A macro, so that the linear algebra library stays out of this crate's interface.
    macro_rules! rows {
        ($matrix:expr) => {
            $matrix
                .row_iter()
                .map(|row| row.iter().copied().collect::<Vec<f64>>())
        };
    }
    let Memory { delayed, z, .. } = &at.memory;
    let first = |columns: &[Vec<f64>]| -> Vec<f64> { columns.iter().map(|c| c[0]).collect() };
    let states = state_names(model);
    let outputs = || {
        let sensors = model.sensors.iter().map(|sensor| sensor.name.clone());
        let outputs = model.outputs.iter().map(|output| output.name.clone());
        outputs.chain(sensors)
    };
    let x = [first(&at.q), first(&at.v), first(z)].concat();
    let u = [first(&at.u), first(delayed)].concat();
    let mut answer = Answer::default();
    let by_name = |names: Vec<String>, values: Vec<f64>| {
        Quantity::Scalars(names.into_iter().zip(values).collect())
    };
    let positions = model.positions().into_iter();
    let positions = positions.map(|p| format!("q_{}", p.name));
    let behind = states[model.coordinates.len()..].iter().cloned();
    answer.push("x", by_name(positions.chain(behind).collect(), x));
    answer.push("u", by_name(input_names(model), u));
    answer.push("y", by_name(outputs().collect(), found.outputs.clone()));
    answer.push("positions", Quantity::Count(found.positions));
    let basis = states.into_iter().zip(rows!(found.basis));
    answer.push("basis", Quantity::Columns(basis.collect()));
    answer.push("chart", Quantity::Matrix(rows!(found.chart).collect()));
    let drift = found.drift.iter().copied().collect();
    answer.push("drift", Quantity::Vector(drift));
    answer.push("A", Quantity::Matrix(rows!(found.a).collect()));
    answer.push("B", Quantity::Matrix(rows!(found.b).collect()));
    let named = outputs().zip(rows!(found.c)).collect();
    answer.push("C", Quantity::Columns(named));
    let named = outputs().zip(rows!(found.d)).collect();
    answer.push("D", Quantity::Columns(named));
    answer
}

/// Positions (where a twist moves a body, displacements along it), velocities and internal
/// states, as a log calls the first two.
fn state_names(model: &Model) -> Vec<String> {
    let of = |group: &'static str| {
        let coordinates = model.coordinates.iter();
        coordinates.map(move |c| format!("{group}_{}", c.name))
    };
    let states = model.states.iter().map(|z| z.name.clone());
    of("q").chain(of("dq")).chain(states).collect()
}

/// The inputs, then the delayed ones.
fn input_names(model: &Model) -> Vec<String> {
    let inputs = model.inputs.iter().map(|u| u.name.clone());
    let delays = model.delays.iter();
    let delayed = delays.map(|d| model.graph.symbol_name(d.symbol).to_string());
    inputs.chain(delayed).collect()
}
