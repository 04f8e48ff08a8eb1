//! Coordinates that no column of a log measures, estimated from the model's own sensors.
//!
//! A log of gyroscopes, accelerometers and encoders shows a motion all the same. It is looked for
//! in two steps. First without the model's dynamics: each coordinate's acceleration comes and
//! goes at random, and sensors and constraints are readings of positions, velocities and
//! accelerations ([`start`]). Then through the model: the departure from that curve, beside forces
//! without a name as large as the log says, so that a model that lacks something does not bend
//! the motion more than the sensors demand ([`smooth`]). The search works on with the same
//! sensors as rows of its likelihood ([`Shown`](crate::regression::Shown)); the estimates are the
//! curve that it begins with and what predictions are compared with.

mod determined;
mod dials;
mod noise;
mod start;

use super::dictionary::{Dictionary, Source};
use super::error::TraceError;
use super::estimate::Observed;
use super::linearised::smooth;
use super::refine::Explanation;
use crate::log::Record;
use crate::machine::{Hold, Machine, States};

/// Standard deviation of an unmeasured position \[rad, m\] and velocity \[per s\] before anything
/// is known of them.
const UNKNOWN: [f64; 2] = [3.0, 30.0];
/// A filter begins within so many standard deviations of the curve.
const WITHIN: f64 = 30.0;

/// A record with estimates of the coordinates that nothing measures. Others are as they were.
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
    sensed.sd.fill(UNKNOWN.map(|sd| sd / WITHIN));
    noise::estimate(sensed, &record.t);
    let mut observed = Observed::new(record, hold)?;
    let mut machine = Machine::new(source.compile().map_err(Box::new)?);
    let values = source.values(&machine);
    let start = start::start(&mut machine, &values, &observed)
        .map_err(|error| TraceError::at(error, &observed.record.t))?;
    take(&mut observed.record, &start);
    observed.curve = start;
    let dictionary = Dictionary::of_parameters(source, &observed.ranges()).map_err(Box::new)?;
    let times = observed.record.t.clone();
    let located = |error| TraceError::at(error, &times);
    let Explanation {
        observed, noise, ..
    } = smooth(&dictionary, &[], observed, &dictionary.defaults).map_err(located)?;
    let mut record = observed.record.clone();
    take(&mut record, &observed.curve);
    determined::check(&dictionary, &observed, &noise, &mut record)?;
    Ok(record)
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
