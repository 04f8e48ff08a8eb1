//! What a log's channels look like before anything is estimated from them.

use super::frozen;
use super::quantum::quantisation_step;
use super::record::{GAP, Record, median_step};
use super::statistics::quantile;
use super::warning::Warning;
use super::{Log, spikes};
use std::f64::consts::TAU;

/// Relative deviation from the median above which a step is irregular.
const JITTER: f64 = 0.05;

/// Share of irregular steps that is reported.
const JITTER_SHARE: f64 = 0.01;

/// Median steps outside this range \[s\] are questioned.
const PLAUSIBLE_STEP: (f64, f64) = (1e-5, 0.5);

/// Steps longer than this \[s\] are no machine's that is worth sampling: nothing is made of them.
pub(super) const LONGEST_STEP: f64 = 100.0;

/// Share of its samples a channel must stand still for to be called stuck.
const STUCK_SHARE: f64 = 0.1;

/// Share of an input's samples that differ from the one before where it is not stuck.
const LIVELY: f64 = 0.9;

/// Share of samples at the extreme value that is called saturation.
const SATURATED_SHARE: f64 = 0.01;

/// Unwraps angles, sets wild samples aside and appends all warnings to the record, which has the
/// samples of `log`.
pub(super) fn examine(record: &mut Record, log: &Log) {
    let mut warnings = sampling(&record.t);
    for (name, values) in record.coordinates.iter().zip(&mut record.q) {
        // A recording that starts anew has turned by nobody knows how much.
        for part in log.recordings() {
            let (t, values) = (&record.t[part.clone()], &mut values[part]);
            warnings.extend(unwrap(&format!("q_{name}"), t, values, TAU));
        }
    }
    warnings.extend(spikes::set_aside(record, log));
    let mut moving = Vec::new();
    for (i, name) in record.coordinates.iter().enumerate() {
        moving.push((format!("q_{name}"), &record.q[i]));
        if let Some(values) = &record.dq[i] {
            moving.push((format!("dq_{name}"), values));
        }
        if let Some(values) = &record.ddq[i] {
            moving.push((format!("ddq_{name}"), values));
        }
    }
    for (column, values) in &moving {
        let others = moving.iter().filter(|(other, _)| other != column);
        let others: Vec<&[f64]> = others.map(|(_, values)| values.as_slice()).collect();
        warnings.extend(stillness(column, &record.t, values, &others));
        warnings.extend(quantised(column, values));
    }
    for (name, values) in record.inputs.iter().zip(&record.u) {
        let column = format!("u_{name}");
        let others: Vec<&[f64]> = moving.iter().map(|(_, values)| values.as_slice()).collect();
        let odd = constant(&column, values)
            .or_else(|| saturated(&column, values))
            .or_else(|| rests(&column, &record.t, values, &others));
        warnings.extend(odd);
    }
    let inputs = record.inputs.iter().zip(&record.u);
    let inputs = inputs.map(|(name, values)| (format!("u_{name}"), values));
    let channels: Vec<(String, &Vec<f64>)> = moving.into_iter().chain(inputs).collect();
    warnings.extend(repeated(&channels));
    record.warnings.extend(warnings);
    frozen::leave_out(record);
}

/// Steps that look as if stamps were not in seconds.
pub(crate) fn strange_rate(t: &[f64]) -> Option<Warning> {
    let step = median_step(t);
    let is_plausible = (PLAUSIBLE_STEP.0..=PLAUSIBLE_STEP.1).contains(&step);
    (!is_plausible).then_some(Warning::StrangeRate { step })
}

/// The unit in which a median step of so many is plausible.
pub(super) fn likely_unit(step: f64) -> &'static str {
    let units = [("ms", 1e-3), ("us", 1e-6)];
    let likely = units
        .iter()
        .find(|(_, seconds)| step * seconds < PLAUSIBLE_STEP.1);
    likely.map_or("ns", |(unit, _)| unit)
}

/// Jitter, gaps and the order of magnitude of the steps.
fn sampling(t: &[f64]) -> Vec<Warning> {
    let step = median_step(t);
    let mut warnings: Vec<Warning> = strange_rate(t).into_iter().collect();
    let steps = t.windows(2).map(|pair| (pair[0], pair[1] - pair[0]));
    let (gaps, ordinary): (Vec<_>, Vec<_>) = steps.partition(|(_, length)| *length > GAP * step);
    let deviations = ordinary.iter().map(|(_, length)| (length - step).abs());
    let irregular: Vec<f64> = deviations.filter(|d| *d > JITTER * step).collect();
    let share = irregular.len() as f64 / ordinary.len().max(1) as f64;
    if share > JITTER_SHARE {
        warnings.push(Warning::IrregularSampling {
            step,
            share,
            largest: irregular.iter().copied().fold(0.0, f64::max),
        });
    }
    let longest = gaps.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some(&first), Some(longest)) = (gaps.first(), longest) {
        warnings.push(Warning::Gaps {
            count: gaps.len(),
            first,
            longest,
        });
    }
    warnings
}

/// Removes jumps of a full `turn` from a channel that stays within one turn.
///
/// A jump is a wrap when it is within a fifth of a turn of a whole one while nine in
/// ten steps of the channel are shorter than a tenth of a turn. Wild samples hide none: they
/// come as near to the sample before as whole turns bring them.
pub(super) fn unwrap(column: &str, t: &[f64], values: &mut [f64], turn: f64) -> Option<Warning> {
    let is_jump = |step: f64| (step.abs() - turn).abs() < 0.2 * turn;
    let mut wild = spikes::of_angle(t, values);
    for k in 1..values.len().saturating_sub(1) {
        let (to, back) = (values[k] - values[k - 1], values[k + 1] - values[k]);
        wild[k] |= is_jump(to) && is_jump(back) && to * back < 0.0;
    }
    let tame: Vec<usize> = (0..values.len()).filter(|&k| !wild[k]).collect();
    let raw: Vec<f64> = tame.iter().map(|&k| values[k]).collect();
    let (least, most) = extremes(&raw);
    let steps: Vec<f64> = raw.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let magnitudes: Vec<f64> = steps.iter().map(|step| step.abs()).collect();
    let ordinary = quantile(&magnitudes, 0.9)?;
    if most - least > 1.01 * turn || most - least < 0.5 * turn || ordinary > 0.1 * turn {
        return None;
    }
    let first = steps.iter().position(|step| is_jump(*step))?;
    let mut turns = 0.0;
    let mut jumps = 0;
    for (&k, step) in tame[1..].iter().zip(&steps) {
        if is_jump(*step) {
            turns -= step.signum();
            jumps += 1;
        }
        values[k] += turns * turn;
    }
    for k in (1..values.len()).filter(|&k| wild[k]) {
        values[k] -= ((values[k] - values[k - 1]) / turn).round() * turn;
    }
    Some(Warning::Unwrapped {
        column: column.to_owned(),
        jumps,
        first: t[tame[first + 1]],
    })
}

fn extremes(values: &[f64]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    let widen = |(least, most): (f64, f64), value: &f64| (least.min(*value), most.max(*value));
    values.iter().fold(start, widen)
}

fn constant(column: &str, values: &[f64]) -> Option<Warning> {
    let (least, most) = extremes(values);
    (least == most).then(|| Warning::Constant {
        column: column.to_owned(),
        value: least,
    })
}

/// Lengths of runs of equal values, in order.
fn runs(values: &[f64]) -> Vec<usize> {
    let same = values.chunk_by(|a, b| a == b);
    same.map(<[f64]>::len).collect()
}

/// Constant, held or stuck: one of them at most.
fn stillness(column: &str, t: &[f64], values: &[f64], others: &[&[f64]]) -> Option<Warning> {
    constant(column, values)
        .or_else(|| held(column, values))
        .or_else(|| stuck(column, t, values, others))
}

/// Most runs have the same length of at least two: sample and hold.
fn held(column: &str, values: &[f64]) -> Option<Warning> {
    let runs = runs(values);
    let inner = runs.get(1..runs.len().saturating_sub(1))?;
    let mut sorted = inner.to_vec();
    sorted.sort_unstable();
    let repeats = *sorted.get(sorted.len() / 2)?;
    let equal = sorted.iter().filter(|run| **run == repeats).count();
    (repeats > 1 && inner.len() >= 10 && 10 * equal >= 8 * inner.len()).then(|| Warning::Held {
        column: column.to_owned(),
        repeats,
    })
}

/// The longest run is a good part of the log and some other channel uses a
/// tenth of its range meanwhile.
fn stuck(column: &str, t: &[f64], values: &[f64], others: &[&[f64]]) -> Option<Warning> {
    let mut end = 0;
    let spans = runs(values).into_iter().map(|samples| {
        end += samples;
        (end - samples)..end
    });
    let longest = spans.max_by_key(ExactSizeIterator::len)?;
    let moves = |other: &&[f64]| {
        let (least, most) = extremes(other);
        let (low, high) = extremes(&other[longest.clone()]);
        high - low > 0.1 * (most - least)
    };
    let long = longest.len() as f64 > STUCK_SHARE * values.len() as f64;
    (long && others.iter().any(moves)).then(|| Warning::Stuck {
        column: column.to_owned(),
        span: (t[longest.start], t[longest.end - 1]),
        samples: longest.len(),
    })
}

/// An input that changes from sample to sample, and then rests at a value for long while the machine
/// moves. At nothing it may rest: it was switched off.
fn rests(column: &str, t: &[f64], values: &[f64], others: &[&[f64]]) -> Option<Warning> {
    let longest = values.chunk_by(|a, b| a == b).max_by_key(|run| run.len())?;
    let changes = runs(values).len().saturating_sub(1);
    let is_lively = changes as f64 > LIVELY * (values.len() - longest.len()) as f64;
    stuck(column, t, values, others).filter(|_| is_lively && longest[0] != 0.0)
}

/// Channels of one kind that say the same in every row.
fn repeated(channels: &[(String, &Vec<f64>)]) -> Vec<Warning> {
    let kind = |column: &str| column.split('_').next().map(str::to_owned);
    let pairs = channels.iter().enumerate().flat_map(|(i, a)| {
        let rest = channels[i + 1..].iter();
        rest.map(move |b| (a, b))
    });
    let same = pairs.filter(|((a, x), (b, y))| {
        let (least, most) = extremes(x);
        kind(a) == kind(b) && x == y && least < most
    });
    let said = same.map(|((a, _), (b, _))| Warning::Repeated {
        columns: [a.clone(), b.clone()],
    });
    said.collect()
}

/// A step larger than the noise, so that rounding is not noise-like.
fn quantised(column: &str, values: &[f64]) -> Option<Warning> {
    let step = quantisation_step(values)?;
    let pairs = values.len().saturating_sub(1).max(1);
    let equal = values.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let third = values
        .windows(4)
        .map(|v| v[3] - 3.0 * v[2] + 3.0 * v[1] - v[0]);
    let square: f64 = third.map(|difference| difference * difference).sum();
    // White noise of variance s² gives third differences of variance 20 s².
    let noise = (square / (20.0 * pairs as f64)).sqrt();
    let coarse = noise < 0.5 * step;
    (coarse && equal > 0).then(|| Warning::Quantised {
        column: column.to_owned(),
        step,
        unchanged: equal as f64 / pairs as f64,
    })
}

/// Many samples exactly at an extreme value, in runs, of an input that takes
/// more than a few values.
fn saturated(column: &str, values: &[f64]) -> Option<Warning> {
    let mut levels = values.to_vec();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let (least, most) = extremes(values);
    let share_at = |limit: f64| {
        let runs = values.chunk_by(|a, b| a == b);
        let at = runs.filter(|run| run[0] == limit && run.len() >= 3);
        at.map(<[f64]>::len).sum::<usize>() as f64 / values.len() as f64
    };
    let worst = [least, most].map(|limit| (share_at(limit), limit));
    let (share, limit) = worst.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    (levels.len() > 8 && share > SATURATED_SHARE).then(|| Warning::Saturated {
        column: column.to_owned(),
        limit,
        share,
    })
}
