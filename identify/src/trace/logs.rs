//! What is learnt from and what is judged by.

use super::dictionary::Source;
use super::error::TraceError;
use super::outcome::Split;
use super::run::Request;
use super::unmeasured::estimated;
use crate::log::{Gauge, Log, LogError, MINIMUM_SAMPLES, Record, Warning, evenly_spread};
use crate::regression::Hold;
use dynamics_codegen::Compiled;
use dynamics_codegen::syntax::PortKind;

/// Fewest samples for learning, and for judging.
const FEWEST: usize = MINIMUM_SAMPLES;
/// Most samples that are learnt from, and that are judged by: what a trace takes half a minute for with one
/// joint. It goes through all of them many times.
const MOST: usize = 100_000;
/// In how many stretches that many are taken of a longer log.
const STRETCHES: usize = 20;
/// Between learning and judging, s.
const GUARD: f64 = 0.5;
/// Samples per second beyond which a log without inputs is thinned.
const FASTEST: f64 = 200.0;

/// Two parts of the measured motion that share no sample.
pub(super) struct Logs {
    /// What is learnt from.
    pub train: Record,
    /// What is judged by.
    pub test: Record,
    /// Which is which.
    pub split: Split,
}

impl Logs {
    /// The logs of a request as `plain`, the model of `source` as given, reads them.
    ///
    /// # Errors
    /// If the logs lack what the model needs, or nothing moves in them.
    pub fn of(
        request: &Request<'_>,
        source: &Source<'_>,
        plain: &Compiled,
    ) -> Result<Self, TraceError> {
        let (train, test, split) = split(request, plain)?;
        let hold = request.hold.unwrap_or(Hold::Linear);
        let train = estimated(source, as_driven(plain, thinned(train)), hold)?;
        let test = estimated(source, as_driven(plain, test), hold)?;
        check_motion(&train, &split.train_log)?;
        check_motion(&test, &split.test_log)?;
        Ok(Self { train, test, split })
    }
}

/// Of a record that is longer than can be searched stretches that are evenly spread over it, which a warning says.
fn shortened(mut record: Record) -> Record {
    let samples = record.len();
    if samples <= MOST {
        return record;
    }
    let ranges = evenly_spread(samples, STRETCHES, MOST / STRETCHES);
    record = record.stretches(&ranges);
    record.warnings.push(Warning::Shortened {
        samples,
        used: record.len(),
        stretches: STRETCHES,
    });
    record
}

/// The columns of a log that a model reads.
///
/// # Errors
/// If one that it needs is missing or of no use.
pub(super) fn selected(log: &Log, plain: &Compiled) -> Result<Record, LogError> {
    let model = &plain.model;
    let coordinates: Vec<String> = model.coordinates.iter().map(|c| c.name.clone()).collect();
    let inputs: Vec<String> = model.inputs.iter().map(|u| u.name.clone()).collect();
    log.select_sensed(&coordinates, &inputs, &Gauge::of(model))
}

/// What to learn from and what to judge by.
fn split(request: &Request<'_>, plain: &Compiled) -> Result<(Record, Record, Split), TraceError> {
    let select = |log: &Log| selected(log, plain);
    let whole = select(request.train)?;
    let (train, test, method) = match request.test {
        Some(test) => (whole, select(test)?, "a log of its own".to_string()),
        None => {
            let needed = 3 * FEWEST;
            if whole.len() < needed {
                return Err(TraceError::TooShort {
                    samples: whole.len(),
                    needed,
                    alone: FEWEST,
                });
            }
            let begin = whole.len() - whole.len() / 3;
            let guard = whole
                .t
                .partition_point(|&t| t < whole.t[begin] - GUARD)
                .max(FEWEST);
            let method = format!("the last third of the log, {GUARD} s apart");
            (
                whole.slice(0..guard),
                whole.slice(begin..whole.len()),
                method,
            )
        }
    };
    let (train, test) = (shortened(train), shortened(test));
    let split = Split {
        train_log: request.train.name(),
        train_samples: train.len(),
        test_log: request.test.unwrap_or(request.train).name(),
        test_samples: test.len(),
        method,
    };
    Ok((train, test, split))
}

/// Something must move.
fn check_motion(record: &Record, log: &str) -> Result<(), TraceError> {
    let moves = |q: &Vec<f64>| q.iter().any(|x| *x != q[0]);
    match record.q.iter().any(moves) {
        true => Ok(()),
        false => Err(TraceError::Motionless {
            log: log.to_string(),
        }),
    }
}

/// Without inputs nothing happens between samples that the model does not predict, and
/// sensor errors of neighbouring samples resemble each other more than white noise does:
/// a fast log is thinned before it is learnt from.
fn thinned(train: Record) -> Record {
    let stride = (1.0 / (FASTEST * train.step())).floor();
    if train.inputs.is_empty() && stride > 1.0 && train.len() as f64 / stride > FEWEST as f64 {
        train.thinned(stride as usize)
    } else {
        train
    }
}

/// The record with the command as the input wherever the model says what the drive makes of
/// it: elsewhere the input is what was measured.
fn as_driven(plain: &Compiled, mut record: Record) -> Record {
    for i in 0..record.inputs.len() {
        let mut effects = plain.model.effects.iter();
        let on_it =
            |kind: &PortKind, on: &String| *kind == PortKind::Input && *on == record.inputs[i];
        let is_driven = effects.any(|e| e.on.iter().any(|(kind, on)| on_it(kind, on)));
        if is_driven && let Some(command) = record.commanded[i].take() {
            record.u[i] = command;
        }
    }
    record
}
