//! Where a motion begins: a state given on the command line, moved onto the constraints.

use crate::json::Text;
use crate::mistake::Mistake;
use crate::state::{SHAPE, State};
use crate::{model, output, parameters};
use dynamics_codegen::Model;
use dynamics_codegen::file::Limit;
use identify::machine::{Machine, Simulated, SolveError, States, Stepping, SteppingOptions};
use std::path::Path;

/// A violation of the constraints that is worth a word, relative to one.
const WORTH_A_WORD: f64 = 1e-9;
/// One takes a few Newton steps; from far away they need more.
const PROJECTIONS: usize = 20;
const LIMIT: Limit = Limit {
    what: "a state",
    bytes: 16 << 20,
};

/// The state that the argument `flag` gives: the JSON itself, or a file of it.
///
/// # Errors
/// If it is not a state of this model.
pub fn read(flag: &str, given: &str, model: &Model, nominal: &[f64]) -> Result<State, Mistake> {
    let inline = given.trim_start().starts_with('{');
    let (file, bytes) = if inline {
        (flag.to_string(), given.as_bytes().to_vec())
    } else {
        let bytes = model::read(Path::new(given), LIMIT).map_err(|mistake| {
            mistake.help(format!("`{flag}` takes a file, or the JSON itself"))
        })?;
        (given.to_string(), bytes)
    };
    let text = Text {
        file: &file,
        first_line: 1,
        text: parameters::text(&file, &bytes)?,
        shape: SHAPE,
    };
    let (state, warnings) = State::read(text, model, nominal)?;
    warnings.iter().for_each(output::warn);
    Ok(state)
}

/// Moves the state onto the constraints; `u` are the inputs there. What is to be said of it.
///
/// # Errors
/// If no state near it fulfils them, or has no unique motion.
pub fn settle(machine: &Machine, state: &mut State, u: &[f64]) -> Result<Option<String>, Mistake> {
    let before = state.clone();
    // First as it stands: the projection needs finite terms to begin with.
    violation(machine, state, u)?;
    let mut left = f64::INFINITY;
    for _ in 0..PROJECTIONS {
        machine.project(state.t, &mut state.q, &mut state.v, &state.parameters);
        left = violation(machine, state, u)?;
        if left <= WORTH_A_WORD {
            break;
        }
    }
    if left > WORTH_A_WORD {
        let message =
            format!("no state near the initial one fulfils the constraints (off by {left:.1e})");
        return Err(Mistake::new(message).help("begin closer to a state that fulfils them"));
    }
    let inside = push_out(machine, state, u)?;
    let distance = |a: &[f64], b: &[f64]| {
        let gaps = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        gaps.fold(0.0_f64, f64::max)
    };
    let (dq, dv) = (distance(&state.q, &before.q), distance(&state.v, &before.v));
    Ok((dq.max(dv) > WORTH_A_WORD).then(|| {
        format!(
            "initial state moved {}: positions by up to {}, velocities by up to {}",
            if inside {
                "out of the planes it touches"
            } else {
                "onto the constraints"
            },
            short(dq),
            short(dv)
        )
    }))
}

/// Moves what is inside of a plane out of it; whether anything was.
fn push_out(machine: &Machine, state: &mut State, u: &[f64]) -> Result<bool, Mistake> {
    if machine.contact_count() == 0 {
        return Ok(false);
    }
    let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
    let mut simulated = Simulated {
        q: column(&state.q),
        v: column(&state.v),
        z: state.z.as_deref().map_or_else(Vec::new, column),
    };
    let moved = Stepping::new(machine, &state.parameters, SteppingOptions::default())
        .push_out(&mut simulated, state.t, &column(u))
        .map_err(|error| stopped(error, state.t))?;
    if moved > 0.0 {
        state.q = simulated.q.iter().map(|column| column[0]).collect();
    }
    Ok(moved > WORTH_A_WORD)
}

fn short(value: f64) -> String {
    match value {
        0.0 => "0".to_string(),
        value if (1e-3..1e4).contains(&value) => format!("{value:.4}"),
        value => format!("{value:.2e}"),
    }
}

/// The largest of `|c|` and `|ċ|`.
fn violation(machine: &Machine, state: &State, u: &[f64]) -> Result<f64, Mistake> {
    let motion = machine
        .motion(&at(state.t, &state.q, &state.v, u), &state.parameters)
        .map_err(|error| stopped(error, state.t))?;
    let terms = &motion[0].terms;
    let all = terms
        .constraint_residual
        .iter()
        .chain(terms.constraint_rate.iter());
    Ok(all.fold(0.0_f64, |largest, c| largest.max(c.abs())))
}

/// One state as columns of one sample.
pub fn at(t: f64, q: &[f64], v: &[f64], u: &[f64]) -> States {
    let column = |values: &[f64]| values.iter().map(|&value| vec![value]).collect();
    States {
        t: vec![t],
        q: column(q),
        v: column(v),
        u: column(u),
        ..States::default()
    }
}

/// The motion cannot go on at time `t`.
pub fn stopped(error: SolveError, t: f64) -> Mistake {
    match error {
        SolveError::Singular { .. } => Mistake::new(format!(
            "at t = {t} s the mass matrix is singular, and the constraints do not make up for it"
        ))
        .help("give every coordinate some inertia"),
        SolveError::Indefinite { .. } => Mistake::new(format!(
            "at t = {t} s the mass matrix is not positive definite: some motion has negative kinetic energy"
        ))
        .help("correct the masses and inertias, or the signs in `kinetic`"),
        SolveError::Inconsistent { miss, .. } => Mistake::new(format!(
            "at t = {t} s the constraints contradict each other (by {miss:.3e} on acceleration level)"
        ))
        .help("drop or correct one of the constraints, or keep away from singular positions"),
        SolveError::Unsettled { .. } => Mistake::new(format!(
            "at t = {t} s the forces do not settle: they depend on multipliers or states that find no balance"
        ))
        .help("lower friction coefficients: with this much, the contact has no or several motions"),
        SolveError::Pinched { .. } => Mistake::new(format!(
            "at t = {t} s no motion keeps the contacts out of all planes"
        ))
        .help("make room between planes that touch the same body from two sides"),
        SolveError::NotFinite { .. } => {
            Mistake::new(format!("at t = {t} s the motion is not finite"))
                .help("lower `--max-step`, or look for forces that grow without bound")
        }
    }
}
