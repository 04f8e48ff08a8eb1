//! Coordinates that no column of a log measures, estimated from the model's own sensors.
//!
//! A log of gyroscopes, accelerometers and encoders shows a motion all the same. It is looked for
//! in two steps. First without the model's dynamics: each coordinate's acceleration comes and
//! goes at random, and sensors and constraints are readings of positions, velocities and
//! accelerations ([`start`]). Then through the model: the departure from that curve, beside forces
//! without a name as large as the log says, so that a model that lacks something does not bend
//! the motion more than the sensors demand ([`smooth`]). The search works on with the same
//! sensors as rows of its likelihood ([`ErrorDynamics::shown`](crate::regression::ErrorDynamics::shown)); the estimates are the
//! curve that it begins with and what predictions are compared with.

mod cyclic;
mod determined;
mod dials;
mod echo;
mod noise;
mod start;

pub(super) use echo::{Echo, echo};

use super::dictionary::{Dictionary, Source};
use super::error::TraceError;
use super::estimate::Observed;
use super::focus::Focus;
use super::linearised::{linearised, smooth};
use super::refine::Explanation;
use crate::log::{Record, Sensed};
use crate::machine::{Hold, Machine, SolveError, States};
use crate::regression::Whitener;
use dynamics_codegen::Library;
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Standard deviation of an unmeasured position \[rad, m\] and velocity \[per s\] before anything
/// is known of them.
const UNKNOWN: [f64; 2] = [3.0, 30.0];
/// A filter begins within so many standard deviations of the curve.
const WITHIN: f64 = 30.0;
/// The same of a position whose beginning is chosen, not found.
const CHOSEN: f64 = 1e-6;

/// A record with estimates of the coordinates that nothing measures, and of the noise of the model's
/// sensors. Others are as they were.
///
/// # Errors
/// If the sensors do not determine a coordinate that something depends on; if the log cannot be
/// smoothed or the model not be evaluated along it.
pub(super) fn estimated(
    source: &Source<'_>,
    mut record: Record,
    hold: Hold,
) -> Result<Record, TraceError> {
    let Some(sensed) = &mut record.sensed else {
        return Ok(record);
    };
    begin_anywhere(sensed);
    noise::estimate(sensed, &record.t);
    if record.is_wholly_measured() {
        return Ok(record);
    }
    let mut observed = Observed::new(record, hold)?;
    let mut machine = Machine::new(source.compile().map_err(Box::new)?);
    let values = source.values(&machine);
    let logged = observed.record.clone();
    let none_found = |error| TraceError::no_motion(error, &logged);
    let cyclic = begin(&mut machine, &values, &mut observed).map_err(none_found)?;
    let dictionary = Dictionary::of_parameters(source, &observed.ranges()).map_err(Box::new)?;
    let known = through_model(&dictionary, observed).map_err(none_found)?;
    let Explanation {
        observed, noise, ..
    } = known;
    let mut record = observed.record.clone();
    take(&mut record, &observed.curve);
    determined::check(&dictionary, (&observed, &cyclic), &noise, &mut record)?;
    Ok(record)
}

/// A log with the motion that its sensors show without the model's dynamics, under these of the dictionary's values.
/// Sensors that misread show another than those of the model as given, too far from that for steps that are linear
/// in what they misread.
///
/// # Errors
/// If no motion is found.
pub(super) fn begun_anew(
    focus: &Focus,
    values: &[f64],
    observed: &Observed,
) -> Result<Observed, SolveError> {
    let mut observed = observed.clone();
    observed.record.sensed.iter_mut().for_each(begin_anywhere);
    let mut machine = focus.machine.clone();
    begin(&mut machine, &focus.values(values), &mut observed)?;
    Ok(observed)
}

/// Nothing is known of where a log begins.
fn begin_anywhere(sensed: &mut Sensed) {
    sensed.sd.fill(UNKNOWN.map(|sd| sd / WITHIN));
}

/// Moves the curve to where the sensors show it without the model's dynamics; says which coordinates are counted from
/// their beginning.
fn begin(
    machine: &mut Machine,
    values: &[f64],
    observed: &mut Observed,
) -> Result<Vec<bool>, SolveError> {
    let cyclic = cyclic::cyclic(machine, values, &observed.record);
    begin_at_zero(&cyclic, observed);
    let start = start::start(machine, values, observed, &cyclic)?;
    take(&mut observed.record, &start);
    observed.curve = start;
    Ok(cyclic)
}

/// Where a coordinate may begin anywhere, its beginning is known: it is zero.
fn begin_at_zero(cyclic: &[bool], observed: &mut Observed) {
    for i in (0..cyclic.len()).filter(|&i| cyclic[i]) {
        observed.position_sd[i] = CHOSEN;
        if let Some(sensed) = &mut observed.record.sensed {
            sensed.sd[i][0] = CHOSEN;
        }
    }
}

/// The same, of a model given by name, text and effects, with values that replace nominal ones.
///
/// # Errors
/// As of [`estimated`].
pub(crate) fn estimated_motion(
    (name, text, library): (&str, &str, &Library),
    parameters: &BTreeMap<String, f64>,
    record: Record,
    hold: Hold,
) -> Result<Record, TraceError> {
    let source = Source {
        name,
        text,
        library,
        parameters,
    };
    estimated(&source, record, hold)
}

/// Rounds in which noise and motion are brought to agree.
const ROUNDS: usize = 4;

/// The motion where the sensors and the model as given agree best, beside forces without a name,
/// with the sensors as noisy as they are there.
fn through_model(
    dictionary: &Dictionary,
    mut observed: Observed,
) -> Result<Explanation, SolveError> {
    let (focus, values) = (dictionary.focus(&[]), &dictionary.defaults);
    for round in 1.. {
        let known = smooth(dictionary, &[], observed, values)?;
        let dynamics = linearised(&focus, &known.observed, values)?;
        let accelerations = dynamics.accelerations();
        let readings = known.observed.readings(&focus, values, &accelerations);
        let whitener = Whitener::new(&dynamics, &readings, &known.noise);
        let evidence = whitener.noise_evidence(&DVector::zeros(0));
        let mut sharper = known.observed.clone();
        let sensed = sharper.record.sensed.as_mut();
        let changed = sensed.is_some_and(|sensed| noise::sharpen(sensed, &evidence));
        if !changed || round == ROUNDS {
            return Ok(known);
        }
        observed = sharper;
    }
    unreachable!("the loop ends by returning")
}

/// Puts the unmeasured coordinates of a curve into a record.
pub(super) fn take(record: &mut Record, curve: &States) {
    for i in 0..record.q.len() {
        if !record.is_measured(i) {
            record.q[i].clone_from(&curve.q[i]);
            record.dq[i] = Some(curve.v[i].clone());
        }
    }
}

#[cfg(test)]
mod tests;
