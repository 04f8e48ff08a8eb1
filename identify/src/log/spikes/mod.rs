//! Wild samples: single values that their neighbours contradict, as a lost bit, a counter that
//! skipped or a line that was written twice leaves them.
//!
//! A machine has inertia: its position, and what its sensors say, goes on smoothly. Each sample is
//! held against the cubic through two neighbours on each side. One that is far off, by the measure
//! of what is usual there, is wild if all is usual without it. Corners and steps of a signal
//! remain: without the first sample after a step its neighbours do not agree either. An input, or
//! an acceleration, may well jump for a sample and return; if so, a velocity jumps with it, and that of
//! an acceleration by as much as it says.

mod answer;
mod change;
mod examine;
mod stretch;
#[cfg(test)]
mod tests;

use super::doubt::Doubt;
use super::statistics::{mad_sd, quantile};
use super::{Log, Record, Warning, segments};
use answer::Answers;
pub(crate) use examine::{BESIDE, ORDINARY, RARE, ordinary_sizes, stands_out};
use std::ops::Range;
use stretch::Stretch;

/// What is smaller than this share of a channel's spread is rounding.
const ROUNDING: f64 = 1e-9;
/// What is smaller than this share of an input's or an acceleration's spread moves nothing.
const MOVES: f64 = 1e-3;
/// A drive follows its command where its output changes by this many times as much as it does from
/// one sample to the next at nearly all times, within so many samples.
const FOLLOWS: (f64, f64, usize) = (2.0, 0.9, 4);
/// Shares of an input's samples below which, and above which, none need be looked at to know
/// where it usually is.
const USUAL: (f64, f64) = (0.02, 0.98);
/// An input that steps is wild this share of its usual range outside it.
const OUTSIDE: f64 = 0.5;
/// Where a log begins or ends a signal may have a corner: its values there go on from the next ones in steps of no
/// more than so many times the step after them (no unit). Without it the first commands of a controller that is
/// switched on far from its goal are set aside, and the true model leaves forces there.
const CORNER: f64 = 2.0;

/// The wild samples of an angle as it was read, which may jump by whole turns.
pub(super) fn of_angle(t: &[f64], values: &[f64]) -> Vec<bool> {
    examine::wild(t, values, &segments(t), ROUNDING, &|_| false)
}

/// Puts what neighbours say in the place of wild samples, and marks them in [`Record::aside`].
/// The record has the samples of `log`.
pub(super) fn set_aside(record: &mut Record, log: &Log) -> Vec<Warning> {
    let segments = segments(&record.t);
    let t = &record.t;
    let mut warnings = Vec::new();
    let said = |column: &str, first: usize, [value, beside]: [f64; 2], samples| Warning::Wild {
        column: column.to_string(),
        file: log.file_of(first).map(|path| path.display().to_string()),
        line: log.lines[first],
        value,
        beside,
        samples,
    };
    let mut mend = |column: String, values: &mut [f64], kind: &Kind<'_>| {
        let wild = kind.wild(t, values, &segments);
        if let Some(first) = wild.iter().position(|&w| w) {
            let found = values[first];
            kind.replace(t, values, &wild, &segments);
            let samples = wild.iter().filter(|&&w| w).count();
            warnings.push(said(&column, first, [found, values[first]], samples));
        }
        wild
    };
    for (i, name) in record.coordinates.iter().enumerate() {
        let column = |prefix| log.column(prefix, name);
        record.aside.q[i] = mend(column("q_"), &mut record.q[i], &Kind::Motion);
        if let Some(values) = &mut record.dq[i] {
            record.aside.dq[i] = mend(column("dq_"), values, &Kind::Motion);
        }
    }
    let answers = Answers::new(t, &record.q);
    for (i, name) in record.coordinates.iter().enumerate() {
        if let Some(values) = &mut record.ddq[i] {
            let kind = Kind::Acceleration(&answers, record.dq[i].as_deref());
            record.aside.ddq[i] = mend(log.column("ddq_", name), values, &kind);
        }
    }
    let mut doubts = Vec::new();
    for (i, name) in record.inputs.iter().enumerate() {
        let column = log.input_column(name);
        let kind = Kind::Input(&answers);
        let wild = mend(column.clone(), &mut record.u[i], &kind);
        let felt = doubtful(t, &record.u[i], &wild, &segments);
        doubts.extend(felt.into_iter().map(|(sample, beside)| Doubt {
            input: i,
            sample,
            beside,
            warning: said(&column, sample, [record.u[i][sample], beside], 1),
        }));
        if let Some(values) = &mut record.commanded[i] {
            let kind = Kind::Command(&answers, &record.u[i]);
            mend(log.column("ucmd_", name), values, &kind);
        }
    }
    record.doubts = doubts;
    warnings
}

/// What a channel may do.
enum Kind<'a> {
    /// It goes on as it was.
    Motion,
    /// It may jump for a sample where the machine is hit, and its velocity with it, if that was measured.
    Acceleration(&'a Answers<'a>, Option<&'a [f64]>),
    /// It may do as it likes, and the machine answers.
    Input(&'a Answers<'a>),
    /// It may do as it likes, and nobody asks the machine.
    Alone,
    /// As an input, and its drive may follow it: what that puts out.
    Command(&'a Answers<'a>, &'a [f64]),
}

impl Kind<'_> {
    fn wild(&self, t: &[f64], values: &[f64], segments: &[Range<usize>]) -> Vec<bool> {
        let may_be = |group: &Range<usize>| {
            let mut ends = segments.iter();
            let at_end = ends.any(|s| s.start == group.start || s.end == group.end);
            (at_end || steps(values)) && is_usual(values, group)
        };
        let nothing = vec![false; values.len()];
        let kept = |velocities: &[f64], group: &Range<usize>| {
            let stretch = Stretch {
                t,
                values,
                aside: &nothing,
            };
            change::agrees(&stretch, velocities, group).unwrap_or(true)
        };
        let is_real = |group: &Range<usize>| match self {
            _ if is_corner(values, segments, group) => true,
            Self::Motion => false,
            Self::Acceleration(answers, velocity) => {
                answers.to(group) && velocity.is_none_or(|v| kept(v, group))
            }
            Self::Command(_, driven) if *driven != values && follows(driven, group) => true,
            Self::Input(answers) | Self::Command(answers, _) => may_be(group) || answers.to(group),
            Self::Alone => may_be(group),
        };
        let share = match self {
            Self::Motion => ROUNDING,
            _ => MOVES,
        };
        examine::wild(t, values, segments, share, &is_real)
    }

    /// Puts what the other samples say in the place of wild ones.
    fn replace(&self, t: &[f64], values: &mut [f64], wild: &[bool], segments: &[Range<usize>]) {
        let stays = !matches!(self, Self::Motion | Self::Acceleration(..)) && steps(values);
        let read = values.to_vec();
        for range in segments {
            let stretch = Stretch {
                t: &t[range.clone()],
                values: &read[range.clone()],
                aside: &wild[range.clone()],
            };
            for k in range.clone().filter(|&k| wild[k]) {
                let mut before = (range.start..k).rev().filter(|&j| !wild[j]);
                let held = before.next().filter(|_| stays).map(|j| values[j]);
                let own = k - range.start;
                let drawn = || stretch.said(own, &(own..own)).map(|said| said.value);
                if let Some(value) = held.or_else(drawn) {
                    values[k] = value;
                }
            }
        }
    }
}

/// The samples of an input that are none of its `wild` ones only because the machine may have felt them,
/// with what their neighbours say.
fn doubtful(
    t: &[f64],
    values: &[f64],
    wild: &[bool],
    segments: &[Range<usize>],
) -> Vec<(usize, f64)> {
    let alone = Kind::Alone.wild(t, values, segments);
    let mut without = values.to_vec();
    let flags: Vec<bool> = alone.iter().zip(wild).map(|(a, w)| *a || *w).collect();
    Kind::Alone.replace(t, &mut without, &flags, segments);
    let each = (0..values.len()).filter(|&k| alone[k] && !wild[k]);
    each.map(|k| (k, without[k])).collect()
}

/// Whether a signal stays at most of its samples what it was at the one before.
fn steps(values: &[f64]) -> bool {
    let changes: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    mad_sd(&changes) == Some(0.0)
}

/// Whether samples at an end of the log, which have neighbours on one side only, go on from these in steps like theirs.
fn is_corner(values: &[f64], segments: &[Range<usize>], group: &Range<usize>) -> bool {
    let Some(segment) = segments.iter().find(|s| s.contains(&group.start)) else {
        return false;
    };
    let step = |k: usize| (values[k + 1] - values[k]).abs();
    let is_no_more = |mut steps: Range<usize>, beside: usize| {
        let most = CORNER * step(beside);
        steps.all(|k| step(k) <= most)
    };
    let begins = || group.end + 1 < segment.end && is_no_more(group.clone(), group.end);
    let ends = || {
        group.start > segment.start + 1
            && is_no_more(group.start - 1..group.end - 1, group.start - 2)
    };
    (group.start == segment.start && begins()) || (group.end == segment.end && ends())
}

/// Whether what a drive puts out changes with a command, or soon after.
fn follows(driven: &[f64], group: &Range<usize>) -> bool {
    let changes: Vec<f64> = driven.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let usual = quantile(&changes, FOLLOWS.1).unwrap_or(0.0);
    let last = (group.end + FOLLOWS.2).min(changes.len());
    let mut soon = changes[group.start.saturating_sub(1).min(last)..last].iter();
    soon.any(|change| *change > FOLLOWS.0 * usual)
}

/// Whether some samples of a signal are where it is at other times.
fn is_usual(values: &[f64], group: &Range<usize>) -> bool {
    let at = |share| quantile(values, share).unwrap_or(0.0);
    let (low, high) = (at(USUAL.0), at(USUAL.1));
    let beyond = OUTSIDE * (high - low);
    let usual = low - beyond..=high + beyond;
    group.clone().all(|k| usual.contains(&values[k]))
}
