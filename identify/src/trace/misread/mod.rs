//! Columns that are not what they are taken for.
//!
//! A sensor that counts the other way, degrees in place of radians, two cables swapped: such a
//! log is far from any model, and no force explains it. So columns are looked at before anything
//! is searched for: each velocity beside the rate of its position, which needs no model, and then
//! each of these mistakes, one after the other, to see whether the model explains the log
//! without.

mod mistake;
mod outcome;
mod rates;
mod seen;
#[cfg(test)]
mod tests;

pub(super) use outcome::outcome;

use crate::log::{Log, Record};
use crate::machine::Machine;
use dynamics_codegen::dimension::Dimension;
use mistake::{Column, Kind, Mistake, UNITS};
use seen::{Given, Seen};
use serde::Serialize;
use std::fmt;

/// The model's accelerations are far off beyond this share of the measured ones.
const FAR_OFF: f64 = 0.5;
/// A mistake must explain the log this many times as well.
const TELLING: f64 = 3.0;
/// Another mistake that leaves no more than this many times what the best one leaves explains
/// the log as well: a reversed position of a pendulum is a reversed torque.
const ALIKE: f64 = 1.1;
/// Mistakes at most.
const MOST: usize = 4;

/// Columns of a log that are probably not what they are taken for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Misread {
    /// The mistakes, one after the other; each stands for itself.
    pub mistakes: Vec<MistakenColumns>,
    /// Error of the model's accelerations along the log as a share of their size, as the columns
    /// are read. Unlike [`Score::acceleration`](super::Score::acceleration) it is a first look.
    pub error_as_read: f64,
    /// The same if the columns are read without the mistakes.
    pub error_otherwise: f64,
    /// Whether the log is read otherwise beyond doubt, so that nothing else was searched for.
    pub is_decisive: bool,
    #[serde(skip)]
    mends: Vec<Mistake>,
}

/// One mistake in the columns of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MistakenColumns {
    /// The columns by their names in the log.
    pub columns: Vec<String>,
    /// What seems to be wrong with them: a sentence without its full stop.
    pub mistake: String,
    /// The lines under `[columns]` of a map that read them as they are; none where it is not
    /// known what they are.
    pub map: Vec<String>,
    /// What would explain the log as well: sentences like `mistake`.
    pub or: Vec<String>,
}

/// What a look at the columns needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look<'a> {
    /// The model as given.
    pub machine: &'a Machine,
    /// The values of its parameters.
    pub values: &'a [f64],
    /// The motion.
    pub record: &'a Record,
    /// The log that it was read from.
    pub log: &'a Log,
}

/// What seems to be wrong with the columns; `None` if they seem to be right, or too odd to say.
pub(super) fn misread(look: Look<'_>) -> Option<Misread> {
    if !look.record.is_wholly_measured() {
        // Estimates through the model agree with it whatever the columns are.
        return None;
    }
    let seen = Seen::of(look.record).ok()?;
    let given = Given {
        machine: look.machine,
        values: look.values,
    };
    let error_as_read = seen.error(given);
    let coordinates = &look.machine.compiled.model.coordinates;
    let is_angle = coordinates
        .iter()
        .map(|c| c.dimension == Some(Dimension::ONE));
    let is_angle: Vec<bool> = is_angle.collect();
    let mut found = Found {
        look,
        given,
        seen,
        mistakes: Vec::new(),
        mends: Vec::new(),
    };
    found.compare_rates(&is_angle);
    let error = found.explain(&is_angle);
    let Found {
        mistakes, mends, ..
    } = found;
    (!mistakes.is_empty()).then_some(Misread {
        is_decisive: !mends.is_empty(),
        mistakes,
        error_as_read,
        error_otherwise: error,
        mends,
    })
}

/// What has been found so far.
struct Found<'a> {
    look: Look<'a>,
    given: Given<'a>,
    /// The motion with all of it mended.
    seen: Seen,
    mistakes: Vec<MistakenColumns>,
    mends: Vec<Mistake>,
}

impl Found<'_> {
    /// Takes velocities for the rates of their positions. Which of the two columns is wrong the
    /// model says.
    fn compare_rates(&mut self, is_angle: &[bool]) {
        let mut known = Vec::new();
        while known.len() < self.seen.coordinates()
            && let Some(odd) = rates::odd(&self.seen, is_angle, &known)
        {
            known.push(odd.coordinate);
            match self.weighed(&odd.mistakes) {
                Some((best, alike, _)) => self.take(best, &alike),
                None => self.wonder(odd.coordinate, odd.factor),
            }
        }
    }

    /// Takes mistakes, one after the other, that explain what the model does not. Half an
    /// explanation is none. The error that remains.
    fn explain(&mut self, is_angle: &[bool]) -> f64 {
        let (begin, mut error) = (self.mends.len(), self.seen.error(self.given));
        let (first, as_begun) = (error, self.seen.clone());
        let possible = possible(&self.seen, is_angle);
        while error > FAR_OFF && self.mends.len() < begin + MOST {
            match self.weighed(&possible) {
                Some((best, alike, left)) if left * TELLING < error => {
                    self.take(best, &alike);
                    error = left;
                }
                _ => break,
            }
        }
        if error > FAR_OFF && self.mends.len() > begin {
            let taken = self.mends.len() - begin;
            self.mends.truncate(begin);
            self.mistakes.truncate(self.mistakes.len() - taken);
            self.seen = as_begun;
            error = first;
        }
        error
    }

    /// The mistake without which the model is nearest to the log, those without which it is
    /// nearly as near, and the error that the first leaves.
    fn weighed(&self, possible: &[Mistake]) -> Option<(Mistake, Vec<Mistake>, f64)> {
        let error = |mistake: &Mistake| self.seen.with(&mistake.changes()).error(self.given);
        let mut tried: Vec<(f64, &Mistake)> = possible.iter().map(|m| (error(m), m)).collect();
        // Stable: of equals the one that comes first is told.
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let &(least, best) = tried.first()?;
        let alike = tried[1..]
            .iter()
            .take_while(|(error, _)| *error <= ALIKE * least);
        let alike = alike.map(|(_, mistake)| (*mistake).clone()).collect();
        Some((best.clone(), alike, least))
    }

    fn take(&mut self, best: Mistake, alike: &[Mistake]) {
        let Look { record, log, .. } = self.look;
        self.seen = self.seen.with(&best.changes());
        self.mistakes.push(MistakenColumns {
            columns: best.columns(record, log),
            mistake: best.sentence(record, log),
            map: best.map(record, log),
            or: alike.iter().map(|m| m.sentence(record, log)).collect(),
        });
        self.mends.push(best);
    }

    /// A velocity that is not the rate of its position, by no unit's factor.
    fn wonder(&mut self, coordinate: usize, factor: f64) {
        let Look { record, log, .. } = self.look;
        let name = &record.coordinates[coordinate];
        let [q, dq] = ["q_", "dq_"].map(|prefix| log.column(prefix, name));
        let mistake = format!("`{dq}` is {factor:.4} times the rate of `{q}`");
        self.mistakes.push(MistakenColumns {
            columns: vec![dq, q],
            mistake,
            map: Vec::new(),
            or: Vec::new(),
        });
    }
}

/// The mistakes that are tried on whole coordinates and on inputs.
fn possible(seen: &Seen, is_angle: &[bool]) -> Vec<Mistake> {
    let (n, k) = (seen.coordinates(), seen.inputs());
    let pairs = |n: usize| (0..n).flat_map(move |i| (i + 1..n).map(move |k| (i, k)));
    let unit = |angle: bool| UNITS.iter().find(move |unit| unit.angle == angle);
    let input = |index: usize| Column {
        kind: Kind::Input,
        index,
    };
    let mut all: Vec<Mistake> = Vec::new();
    for angle in [true, false] {
        let own: Vec<usize> = (0..n).filter(|&i| is_angle[i] == angle).collect();
        let Some(unit) = unit(angle) else { continue };
        if own.len() > 1 {
            let columns = own.iter().flat_map(|&i| seen.columns(i));
            all.push(Mistake::in_unit(columns.collect(), unit));
        }
        all.extend(own.iter().map(|&i| Mistake::in_unit(seen.columns(i), unit)));
    }
    all.extend((0..n).map(|i| Mistake::reversed(seen.columns(i))));
    all.extend((0..k).map(|i| Mistake::reversed(vec![input(i)])));
    all.extend(pairs(n).filter_map(|(i, k)| {
        let (own, other) = (seen.columns(i), seen.columns(k));
        let alike = own.iter().map(|c| c.kind).eq(other.iter().map(|c| c.kind));
        let alike = alike && is_angle[i] == is_angle[k];
        alike.then(|| Mistake::Swapped(own.into_iter().zip(other).collect()))
    }));
    all.extend(pairs(k).map(|(i, k)| Mistake::Swapped(vec![(input(i), input(k))])));
    all
}

impl Misread {
    /// The record as it would be without the mistakes.
    fn mended(&self, record: &Record) -> Record {
        let mut mended = record.clone();
        self.mends
            .iter()
            .for_each(|mistake| mistake.mend(&mut mended));
        mended
    }
}

impl fmt::Display for Misread {
    /// In one sentence.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = self.mistakes.iter().map(|m| match &m.or[..] {
            [] => m.mistake.clone(),
            or => format!("{}, or {}", m.mistake, or.join(", or ")),
        });
        let each = each.collect::<Vec<_>>().join("; ");
        match self.is_decisive {
            true => write!(
                f,
                "The columns of the log are not what they are taken for: {each}."
            ),
            false => write!(
                f,
                "The columns of the log may not be what they are taken for: {each}."
            ),
        }
    }
}
