//! Machines that lack many things at once, and whose forces were measured.
//!
//! A real arm has friction, a rotor and an offset in every drive. Beside so much that is
//! missing no single effect makes its motion likely, and where a link has no inertia of its own
//! the model as given does not move at all. The balance of forces `M a − Q` needs no motion: what is
//! missing in it is linear in the strengths of all effects, so that many can be found together.
//! The price are accelerations, known only in the band that the log shows, and inputs that
//! must be right: they are what is explained here, so that nothing is said about channels.

mod balance;
mod choose;
mod equations;
mod floor;
mod judge;
mod narrowing;
mod own_shapes;
mod plainer;
mod reach;
mod settle;

pub(crate) use floor::force_floor;
pub(super) use judge::judge;

use super::corrected::corrected;
use super::dictionary::{Dictionary, Shape};
use super::error::TraceError;
use super::estimate::Observed;
use super::finding::says_no_strength;
use super::refine::Estimate;
use super::remaining::{Remaining, of_balance};
use super::remembered::is_memoryless;
use super::screen::{ShapedCandidate, options};
use super::selection::{Selection, Term};
use super::settings::{WORTH_A_NAME, WORTH_IT};
use crate::log::rms;
use crate::machine::{Machine, SolveError};
use balance::{Balance, Forces};
use choose::{Choice, State};
use equations::Equations;
use floor::left_by_noise;
use narrowing::in_telling_band;
use own_shapes::terms;
use plainer::Explained;
use rayon::prelude::*;
use reach::reaches;
use settle::Settled;
use std::collections::{BTreeMap, BTreeSet};

/// Damping of the fit of everything at once.
const EVERYTHING: f64 = 1e-6;
/// How often scales are adapted to what everything together leaves.
const ROUNDS: usize = 2;

/// What a machine lacks, if its forces were measured and effects explain much of what they miss;
/// `None` otherwise. The noise by which sensors would leave forces anyway is drawn with `seed`.
///
/// # Errors
/// If the log cannot be smoothed, or a state's equation has no solution along it.
pub(super) fn learn(
    dictionary: &Dictionary,
    observed: &Observed,
    seed: u64,
) -> Result<Option<Selection>, TraceError> {
    let machine = &dictionary.machine;
    // Forces are in balance with accelerations that were measured, not with what the model makes
    // of other readings.
    let is_measured = observed.record.is_wholly_measured();
    if machine.input_count() == 0 || machine.constraint_count() > 0 || !is_measured {
        return Ok(None);
    }
    let located = |error| TraceError::at(error, &observed.record.t);
    let balance = in_telling_band(dictionary, observed)?;
    let missing = (balance.missing(machine, &dictionary.defaults)).map_err(located)?;
    let columns = columns(dictionary, &balance).map_err(located)?;
    let (options, columns) = in_use(force_options(dictionary), columns);
    let equations = weighed(Equations::new(&missing, &columns), &first_columns(&options));
    drop(columns);
    let (gram, visible) = (equations.gram(), equations.visible());
    let choice = Choice {
        dictionary,
        options: &options,
        gram,
        visible,
        equations: &equations,
        reaches: reaches(dictionary),
    };
    let state = choice.choose();
    let before = 0.5 * choice.gram.data_misfit();
    if state.terms.is_empty() || state.left > (1.0 - WORTH_IT) * before {
        return Ok(None);
    }
    let first = values(&choice, &state);
    let explained = Explained::new((&choice, &balance), state.terms, first).map_err(located)?;
    let explained = explained.plainer(&choice, &balance);
    let considered = choice.considered();
    let terms = terms(choice, &balance, &explained).map_err(located)?;
    let values = explained.settled.values;
    let kept = without_idle(dictionary, (&balance, &equations), terms, values).map_err(located)?;
    let Some((terms, settled)) = kept else {
        return Ok(None);
    };
    let accepted: Vec<usize> = terms.iter().map(|term| term.candidate).collect();
    let focus = dictionary.focus(&accepted);
    let own = focus.values(&settled.values);
    let left = balance.missing(&focus.machine, &own).map_err(located)?;
    let exerted = balance.exerted(&focus.machine, &own).map_err(located)?;
    let exerted = known(exerted, observed, (&focus.machine, &own)).map_err(located)?;
    let looked = (&balance, observed);
    let by_noise = left_by_noise(looked, (&focus.machine, &own), None, seed)?;
    let unexplained =
        |left: &Forces| of_balance(dictionary, &balance.t(), left, [&by_noise, &exerted]);
    let rows = equations.effective();
    let [share_before, share_after] =
        [&missing, &left].map(|forces| share(forces, &by_noise, &exerted));
    Ok(Some(Selection {
        terms,
        estimate: Estimate {
            parameters: dictionary.parameters_of(&accepted),
            covariance: settled.covariance,
            cost: settled.left,
            rows: rows as usize,
            unexplained: share_after.powi(2),
            // What noise leaves of the forces is not in that share.
            beyond_inputs: share_after.powi(2),
        },
        values: settled.values,
        held_otherwise: None,
        reduced_misfit: 2.0 * settled.left / rows,
        nominal_misfit: 2.0 * before / rows,
        log_likelihood: [-before, -settled.left],
        remaining: Remaining {
            share_before,
            share_after,
            evidence: 0.0,
            forces: unexplained(&left),
        },
        given_forces: unexplained(&missing),
        considered,
        left_out_nameless: false,
        narrowing: balance.narrowing,
        averaged_over: balance.averaged_over(),
        observed: observed.clone(),
    }))
}

/// Terms without those that are idle, the weakest first, and where the others settle from `values`; `None`
/// where none is left.
fn without_idle(
    dictionary: &Dictionary,
    (balance, equations): (&Balance, &Equations),
    mut terms: Vec<Term>,
    mut values: Vec<f64>,
) -> Result<Option<(Vec<Term>, Settled)>, SolveError> {
    while !terms.is_empty() {
        let accepted: Vec<usize> = terms.iter().map(|term| term.candidate).collect();
        let settled = settle::settle(dictionary, balance, equations, &accepted, values)?;
        let idle = match undetermined(dictionary, &accepted, &settled) {
            None => negligible(dictionary, balance, &accepted, &settled)?,
            idle => idle,
        };
        let Some(idle) = idle else {
            return Ok(Some((terms, settled)));
        };
        let Term { candidate, .. } = terms.remove(idle);
        values = dictionary.without(&[candidate], &settled.values);
    }
    Ok(None)
}

/// The weakest of some terms, strongest first, of which the log does not say how strong it is now that
/// shapes have moved, too: it is not named, and holds no other one up.
fn undetermined(dictionary: &Dictionary, accepted: &[usize], settled: &Settled) -> Option<usize> {
    let parameters = dictionary.parameters_of(accepted);
    let known = (&parameters[..], &settled.covariance);
    let is_idle =
        |&candidate: &usize| says_no_strength(dictionary, candidate, &settled.values, known);
    accepted.iter().rposition(is_idle)
}

/// The weakest of some terms, strongest first, that exerts next to nothing beside the inputs on any
/// coordinate.
fn negligible(
    dictionary: &Dictionary,
    balance: &Balance,
    accepted: &[usize],
    settled: &Settled,
) -> Result<Option<usize>, SolveError> {
    let focus = dictionary.focus(accepted);
    let missing = |values: &[f64]| balance.missing(&focus.machine, &focus.values(values));
    let with = missing(&settled.values)?;
    let exerted = balance.exerted(&focus.machine, &focus.values(&settled.values))?;
    for (i, &candidate) in accepted.iter().enumerate().rev() {
        let without = missing(&dictionary.without(&[candidate], &settled.values))?;
        let mut each = with.iter().zip(&without).zip(&exerted);
        let is_small = each.all(|((with, without), exerted)| {
            let own: Vec<f64> = with.iter().zip(without).map(|(a, b)| a - b).collect();
            rms(&own) <= WORTH_A_NAME * rms(exerted)
        });
        if is_small {
            return Ok(Some(i));
        }
    }
    Ok(None)
}

/// What a selection leaves of the forces that were measured, in a band so many times narrower than that in which
/// the log shows accelerations: the mean logarithm of its size over coordinates.
///
/// # Errors
/// If the log cannot be smoothed, or a state's equation has no solution along it.
pub(super) fn left(
    dictionary: &Dictionary,
    selection: &Selection,
    (inputs, narrowing): (&[Vec<f64>], usize),
) -> Result<f64, TraceError> {
    let mut observed = selection.observed.clone();
    observed.record.u = inputs.to_vec();
    let focus = dictionary.focus(&selection.accepted());
    let values = focus.values(&selection.values);
    let faultless = corrected(&observed.record, &focus, &values)?;
    let balance = Balance::narrowed(&faultless, observed.hold, narrowing)?;
    let left = balance.missing(&focus.machine, &values);
    let left = left.map_err(|error| TraceError::at(error, &observed.record.t))?;
    let sizes = left.iter().map(|force| rms(force).ln());
    Ok(sizes.sum::<f64>() / left.len() as f64)
}

/// Values of all parameters by the linear fit.
fn values(choice: &Choice<'_>, state: &State) -> Vec<f64> {
    let mut values = choice.dictionary.defaults.clone();
    let (_, strengths) = choice.strengths(&state.terms);
    let mut strengths = strengths.into_iter();
    for term in &state.terms {
        let option = &choice.options[term.option];
        let candidate = &choice.dictionary.candidates[option.candidate];
        for &(parameter, value) in &candidate.shapes[option.shape] {
            values[parameter] = value;
        }
        for (&i, strength) in term.kept.iter().zip(strengths.by_ref()) {
            values[candidate.strengths[i]] += strength;
        }
    }
    values
}

/// The columns of all options, shape after shape, as [`options`] counts them. None of these changes what is remembered.
fn columns(dictionary: &Dictionary, balance: &Balance) -> Result<Vec<Forces>, SolveError> {
    let (machine, defaults) = (&dictionary.machine, &dictionary.defaults);
    let states = balance.remembered(machine, defaults)?;
    let first = || balance.added(&states, &dictionary.by_parameter, defaults);
    let in_shape = |(shape, of_shape): (usize, &Shape)| {
        let mut values = defaults.clone();
        for candidate in &dictionary.candidates {
            for &(parameter, value) in candidate.shapes.get(shape + 1).into_iter().flatten() {
                values[parameter] = value;
            }
        }
        balance.added(&states, &of_shape.slopes, &values)
    };
    let further = || {
        let shapes = dictionary.by_shape.par_iter().enumerate();
        shapes.map(in_shape).collect::<Vec<_>>()
    };
    let (first, further) = rayon::join(first, further);
    Ok(first
        .into_iter()
        .chain(further.into_iter().flatten())
        .collect())
}

/// Options with their own columns out of all: products of others are never asked for.
fn in_use(
    mut options: Vec<ShapedCandidate>,
    all: Vec<Forces>,
) -> (Vec<ShapedCandidate>, Vec<Forces>) {
    let used = options.iter().flat_map(|option| &option.columns);
    let used: BTreeSet<usize> = used.copied().collect();
    let places: BTreeMap<usize, usize> = used.iter().copied().zip(0..).collect();
    for column in options.iter_mut().flat_map(|option| &mut option.columns) {
        *column = places[column];
    }
    let own = all.into_iter().enumerate();
    let own = own.filter(|(column, _)| used.contains(column));
    (options, own.map(|(_, column)| column).collect())
}

/// Laws that act as forces and forget, and losses that a description states: with a gain of nothing, or friction as large as the load,
/// an input would leave nothing to explain, and of a hysteresis the ripple of measured forces
/// shows little. Other parameters are left to the motion, which knows them more exactly: asked here, the place of a centre of
/// mass stood for a rotor on a measured double pendulum, which foretold less, and took ten times as long.
fn force_options(dictionary: &Dictionary) -> Vec<ShapedCandidate> {
    let compiled = &dictionary.machine.compiled;
    let mut model = compiled.model.clone();
    let inputs = model.input_symbols();
    let mut follows_inputs = |parameter: usize| {
        let seeds = model.parameter_seeds(model.parameters[parameter].symbol);
        let slopes = model.graph.directional(&compiled.system.force, &seeds);
        inputs.iter().any(|&u| model.graph.depends_on(&slopes, u))
    };
    let candidates = dictionary.candidates.iter();
    let following = candidates.map(|c| c.strengths.iter().any(|&p| follows_inputs(p)));
    let following: Vec<bool> = following.collect();
    let mut options = options(dictionary, &[]);
    options.retain(|option| {
        let is_loss = dictionary.candidates[option.candidate].is_loss;
        let is_law = is_loss || is_memoryless(dictionary, option.candidate);
        is_law && !following[option.candidate]
    });
    options
}

/// The columns of all options in their first shape.
fn first_columns(options: &[ShapedCandidate]) -> Vec<usize> {
    let first = options.iter().filter(|option| option.shape == 0);
    let mut all: Vec<usize> = first.flat_map(|option| option.columns.clone()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The equations in units of what these columns leave together: what one alone leaves is not noise yet.
fn weighed(mut equations: Equations, columns: &[usize]) -> Equations {
    for _ in 0..ROUNDS {
        let own: Vec<usize> = (0..columns.len()).collect();
        let fit = equations.gram_of(columns).damped_fit(&own, EVERYTHING);
        equations.reweigh(columns, fit.coefficients.as_slice());
    }
    equations
}

/// What inputs exert, and nothing where noise that the machine did not feel is larger than all that is
/// left of them: there the log does not say what acts.
pub(super) fn known(
    mut exerted: Forces,
    observed: &Observed,
    (machine, values): (&Machine, &[f64]),
) -> Result<Forces, SolveError> {
    let noise = observed.forces_of_noise((machine, values), |noise| noise.taken)?;
    for (force, noise) in exerted.iter_mut().zip(noise) {
        if rms(force) < noise {
            force.fill(0.0);
        }
    }
    Ok(exerted)
}

/// Root mean square over coordinates of forces, beyond what noise leaves of them, as shares of others;
/// not a number where none of these acts.
fn share(forces: &Forces, by_noise: &Forces, of: &Forces) -> f64 {
    let each = forces.iter().zip(by_noise).zip(of);
    let acting = each.filter(|(_, of)| rms(of) > 0.0);
    let squares = acting.map(|((force, noise), of)| {
        let beyond = rms(force).powi(2) - rms(noise).powi(2);
        beyond.max(0.0) / rms(of).powi(2)
    });
    let squares: Vec<f64> = squares.collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::regression::Hold;
    use dynamics_codegen::{Library, compile};
    use std::fmt::Write;

    /// An arm whose second joint nobody drives.
    const ARM: &str = "
        model arm; coordinate a: rad; coordinate b: rad; input a: N*m;
        body upper { frame: rotate_z(a); mass: 2; center: (0.2, 0, 0); inertia: diag(0.02, 0.02, 0.02); }
        body lower { frame: upper * translate(0.4, 0, 0) * rotate_z(b); mass: 1;
                     center: (0.15, 0, 0); inertia: diag(0.01, 0.01, 0.01); }
        gravity (0, -9.81, 0);
        force a = input(a);";

    /// What is missing in a joint that no input drives is no share of what its inputs exert.
    #[test]
    fn an_undriven_joint_has_no_share() {
        let mut text = String::from("t,q_a,q_b,u_a\n");
        for k in 0..400 {
            let t = 0.01 * f64::from(k);
            let (a, b, u) = ((1.3 * t).sin(), (2.1 * t).cos(), 3.0 * (1.7 * t).sin());
            writeln!(text, "{t},{a},{b},{u}").unwrap();
        }
        let log = Log::from_bytes("arm.csv", text.as_bytes()).unwrap();
        let (joints, inputs) = (["a".to_string(), "b".to_string()], ["a".to_string()]);
        let record = log.select(&joints, &inputs).unwrap();
        let machine = Machine::new(compile("arm", ARM, &Library::empty()).unwrap());
        let balance = Balance::narrowed(&record, Hold::Linear, 1).unwrap();
        let exerted = balance.exerted(&machine, &[]).unwrap();
        let missing = balance.missing(&machine, &[]).unwrap();
        assert!(rms(&exerted[0]) > 1.0 && rms(&missing[1]) > 0.1);
        assert!(exerted[1].iter().all(|force| *force == 0.0));
        let of_driven = rms(&missing[0]) / rms(&exerted[0]);
        let nothing = vec![vec![0.0; exerted[0].len()]; 2];
        assert!((share(&missing, &nothing, &exerted) / of_driven - 1.0).abs() < 1e-12);
        assert!(share(&missing, &nothing, &nothing).is_nan());
        // What noise leaves is no force.
        assert_eq!(share(&missing, &missing, &exerted), 0.0);
        // An input of which noise is more than half says nothing.
        let mut observed = Observed::new(record, Hold::Linear).unwrap();
        for (noise, is_known) in [(0.1, true), (10.0, false)] {
            observed.input_noise[0].taken = noise;
            let told = known(exerted.clone(), &observed, (&machine, &[])).unwrap();
            assert_eq!(told[0] == exerted[0], is_known);
        }
    }
}
