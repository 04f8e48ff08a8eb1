//! The motion that would tell two explanations apart.
//!
//! Two explanations that agree along a log may differ elsewhere. Both are asked for
//! accelerations where simple changes of the logged motion would lead: faster, the other way,
//! elsewhere, with other inputs.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::focus::Focus;
use crate::log::rms;
use crate::machine::States;
use crate::regression::{Hold, divided};
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// A change of the logged motion under which two explanations part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SeparatingMotion {
    /// How to change the logged motion, as in "the same motion *twice as fast*".
    pub motion: String,
    /// The coordinate whose accelerations differ most there.
    pub coordinate: String,
    /// Root mean square of that difference, in `unit`.
    pub apart: f64,
    /// The same along the log.
    pub apart_in_log: f64,
    /// Unit of the acceleration.
    pub unit: String,
}

/// A simple change of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// The time it takes is divided by this.
    Faster(f64),
    /// All velocities are reversed.
    Reversed,
    /// One coordinate's velocity is.
    Turned(usize),
    /// One coordinate is elsewhere, by this much.
    Moved(usize, f64),
    /// All inputs are multiplied.
    Inputs(f64),
}

/// Times by which the explanations must be further apart than along the log.
const WORTH_SAYING: f64 = 2.0;
/// Samples that are looked at.
const LOOKED_AT: usize = 500;
/// Samples in one piece, where a machine remembers or a sensor reads at another time.
const IN_ONE_PIECE: usize = 2000;
/// Accelerations that differ by less than this share are equal.
const EQUAL: f64 = 1e-6;

/// Two explanations side by side: how far their accelerations are apart along a log, and under
/// changes of its motion.
struct Comparison {
    focus: Arc<Focus>,
    /// Root mean square of the accelerations along the log, per coordinate.
    scale: Vec<f64>,
    /// The same of the differences.
    in_log: Vec<f64>,
    /// Where the machine can be so, by change.
    changed: Vec<(Change, Vec<f64>)>,
}

impl Comparison {
    /// `candidates` are those of both explanations, `values` all the dictionary's parameters under
    /// either. `None` where the machine cannot move as the log says.
    fn new(
        dictionary: &Dictionary,
        observed: &Observed,
        candidates: &[usize],
        values: [&[f64]; 2],
    ) -> Option<Self> {
        let focus = dictionary.focus(candidates);
        let logged = sample(&focus, observed);
        let under = |states: &States, which: usize| {
            accelerations(&focus, states, observed.hold, values[which])
        };
        let apart = |states: &States| -> Option<Vec<f64>> {
            let (a, b) = (under(states, 0)?, under(states, 1)?);
            let difference = |(a, b): (&Vec<f64>, &Vec<f64>)| {
                let each: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
                rms(&each)
            };
            Some(a.iter().zip(&b).map(difference).collect())
        };
        let changed = changes(&focus, &logged).into_iter();
        let changed = changed.filter_map(|change| Some((change, apart(&change.of(&logged))?)));
        Some(Self {
            scale: under(&logged, 0)?.iter().map(|a| rms(a)).collect(),
            in_log: apart(&logged)?,
            changed: changed.collect(),
            focus,
        })
    }

    /// The coordinate that differs most, with its difference as a share of its scale.
    fn most(&self, apart: &[f64]) -> Option<(usize, f64)> {
        let share = |(i, scale): (usize, &f64)| match *scale > 0.0 {
            true => (i, apart[i] / scale),
            false => (i, 0.0),
        };
        let shares = self.scale.iter().enumerate().map(share);
        shares.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The largest share by which the explanations differ, along the log or under a change of it.
    fn furthest(&self) -> f64 {
        let all = self.changed.iter().map(|(_, apart)| apart);
        let all = all.chain([&self.in_log]);
        let shares = all.filter_map(|apart| Some(self.most(apart)?.1));
        shares.fold(0.0, f64::max)
    }

    /// The change under which they differ most, if it does more than the log itself.
    fn separating_motion(&self) -> Option<SeparatingMotion> {
        let (_, known) = self.most(&self.in_log)?;
        let changed = self.changed.iter().filter_map(|(change, apart)| {
            let (i, share) = self.most(apart)?;
            share.is_finite().then_some((change, apart, i, share))
        });
        // Of equals the first, which is the simplest.
        let (change, apart, i, share) =
            changed.reduce(|best, next| if next.3 > best.3 { next } else { best })?;
        let coordinate = &self.focus.machine.compiled.model.coordinates[i];
        (share > EQUAL && share > WORTH_SAYING * known).then(|| SeparatingMotion {
            motion: change.describe(&self.focus),
            coordinate: coordinate.name.clone(),
            apart: apart[i],
            apart_in_log: self.in_log[i],
            unit: format!("{}/s^2", coordinate.unit),
        })
    }
}

/// How two explanations of a log relate.
pub(super) enum Relation {
    /// Nothing tells them apart but what is less than the first one's own uncertainty.
    Same,
    /// They differ, if only elsewhere; with the change of the logged motion under which they do so
    /// most, if it does more than the log itself.
    Different(Option<SeparatingMotion>),
}

/// How two explanations relate. `candidates` are those of both, `values` all the dictionary's parameters
/// under either; `moved` are values under the first that are about as likely.
pub(super) fn relation(
    dictionary: &Dictionary,
    observed: &Observed,
    candidates: &[usize],
    values: [&[f64]; 2],
    moved: &[Vec<f64>],
) -> Relation {
    let compare =
        |other: &[f64]| Comparison::new(dictionary, observed, candidates, [values[0], other]);
    let Some(comparison) = compare(values[1]) else {
        return Relation::Different(None);
    };
    let furthest = comparison.furthest();
    let mut own = moved
        .iter()
        .filter_map(|moved| Some(compare(moved)?.furthest()));
    match own.any(|own| furthest <= own) {
        true => Relation::Same,
        false => Relation::Different(comparison.separating_motion()),
    }
}

/// States of the log: evenly spread, or one piece where it matters what was before.
fn sample(focus: &Focus, observed: &Observed) -> States {
    let curve = &observed.curve;
    if focus.machine.remembers() || focus.machine.has_sensor_errors() {
        let begin = curve.len().saturating_sub(IN_ONE_PIECE) / 2;
        return States {
            history: None,
            begun: Arc::default(),
            ..curve.slice(begin..curve.len().min(begin + IN_ONE_PIECE))
        };
    }
    curve.spread(LOOKED_AT)
}

/// Accelerations where `states` are what the sensors read; `None` where there are none.
fn accelerations(
    focus: &Focus,
    states: &States,
    hold: Hold,
    values: &[f64],
) -> Option<Vec<Vec<f64>>> {
    let own = focus.values(values);
    let n = focus.machine.coordinate_count();
    let solve = |states: &States| -> Option<Vec<Vec<f64>>> {
        let states = focus.machine.remember(states, hold, &own).ok()?;
        let motions = focus.machine.motion(&states, &own).ok()?;
        let column = |i: usize| motions.iter().map(|m| m.acceleration[i]).collect();
        Some((0..n).map(column).collect())
    };
    let found = solve(states)?;
    if !focus.machine.has_sensor_errors() {
        return Some(found);
    }
    let read = focus
        .sensors
        .read(&focus.machine.at_rest(states, &own), &found, &own);
    // One step towards the motion that is read so.
    let behind = |x: &[f64], read: &[f64], slope: &[f64]| -> Vec<f64> {
        let beyond: Vec<f64> = read.iter().zip(x).map(|(read, x)| read - x).collect();
        let step = divided(&beyond, slope);
        x.iter().zip(step).map(|(x, step)| x - step).collect()
    };
    let moved = |x: &[Vec<f64>], read_x: &[Vec<f64>]| -> Vec<Vec<f64>> {
        (0..n)
            .map(|i| behind(&x[i], &read_x[i], &read.slope[i]))
            .collect()
    };
    solve(&States {
        q: moved(&states.q, &read.q),
        v: moved(&states.v, &read.v),
        ..states.clone()
    })
}

/// What may be changed: single coordinates only where no constraint ties them to others.
fn changes(focus: &Focus, logged: &States) -> Vec<Change> {
    let mut changes = vec![
        Change::Faster(2.0),
        Change::Faster(0.25),
        Change::Reversed,
        Change::Inputs(2.0),
        Change::Inputs(-1.0),
        Change::Inputs(0.0),
    ];
    if logged.u.is_empty() {
        changes.retain(|change| !matches!(change, Change::Inputs(_)));
    }
    if focus.machine.constraint_count() == 0 && focus.machine.coordinate_count() > 1 {
        changes.extend((0..logged.q.len()).map(Change::Turned));
    }
    if focus.machine.constraint_count() == 0 {
        for (i, q) in logged.q.iter().enumerate() {
            let lowest = q.iter().copied().fold(f64::INFINITY, f64::min);
            let highest = q.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let travel = (highest - lowest).min(FRAC_PI_2);
            changes.extend([travel, -travel].map(|by| Change::Moved(i, by)));
        }
    }
    changes
}

impl Change {
    /// The motion so changed.
    fn of(self, logged: &States) -> States {
        let mut states = logged.clone();
        let multiply = |columns: &mut [Vec<f64>], by: f64| {
            columns.iter_mut().flatten().for_each(|x| *x *= by);
        };
        match self {
            Self::Faster(by) => {
                states.t.iter_mut().for_each(|t| *t /= by);
                multiply(&mut states.v, by);
            }
            Self::Reversed => multiply(&mut states.v, -1.0),
            Self::Turned(i) => multiply(&mut states.v[i..=i], -1.0),
            Self::Moved(i, by) => states.q[i].iter_mut().for_each(|q| *q += by),
            Self::Inputs(by) => multiply(&mut states.u, by),
        }
        states
    }

    /// In words, as "the same motion …".
    fn describe(self, focus: &Focus) -> String {
        let coordinate = |i: usize| &focus.machine.compiled.model.coordinates[i];
        match self {
            Self::Faster(by) if by > 1.0 => format!("{by} times as fast"),
            Self::Faster(by) => format!("at {by} of the speed"),
            Self::Reversed => "in the opposite direction".to_string(),
            Self::Turned(i) => format!("with {} moving the other way", coordinate(i).name),
            Self::Moved(i, by) => {
                let (name, unit) = (&coordinate(i).name, &coordinate(i).unit);
                let more = if by > 0.0 { "more" } else { "less" };
                format!("with {name} {:.2} {unit} {more}", by.abs())
            }
            Self::Inputs(0.0) => "without inputs".to_string(),
            Self::Inputs(by) if by < 0.0 => "under opposite inputs".to_string(),
            Self::Inputs(by) => format!("under inputs {by} times as large"),
        }
    }
}
