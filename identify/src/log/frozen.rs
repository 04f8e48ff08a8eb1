//! Stretches in which a sensor says the same over and over although its coordinate moves.
//!
//! A joint may stand still, for instance where friction holds it. A sensor that froze is told
//! from that by its own velocity channel, which goes on, or by the jump with which it wakes up.

use super::quantum::quantisation_step;
use super::record::Record;
use super::statistics::quantile;
use super::warning::Warning;
use std::ops::Range;

/// Fewest equal samples that are looked at.
const FEWEST: usize = 10;
/// Share of its range that a coordinate must have moved meanwhile.
const MOVED: f64 = 0.02;
/// Steps of its resolution that it must have moved.
const QUANTA: f64 = 3.0;
/// Times the largest ordinary step by which a sensor jumps as it wakes up.
const JUMP: f64 = 5.0;
/// Share of the steps that are ordinary.
const ORDINARY: f64 = 0.99;

/// Takes out the samples in which a position or a velocity is frozen; says which.
pub(super) fn leave_out(record: &mut Record) {
    let mut frozen: Vec<(String, Range<usize>)> = Vec::new();
    for (i, name) in record.coordinates.iter().enumerate() {
        let (q, dq) = (&record.q[i], record.dq[i].as_deref());
        let positions = runs(q).into_iter();
        let far = far(q);
        let jump = far.max(JUMP * ordinary_step(q));
        let positions = positions.filter(|run| match dq {
            // Out and back counts too.
            Some(dq) => travel(&record.t, dq, run).any(|gone| gone.abs() > far),
            None => wakes_up(q, run, jump),
        });
        frozen.extend(positions.map(|run| (format!("q_{name}"), run)));
        let velocities = dq.map_or_else(Vec::new, runs).into_iter();
        let velocities = velocities.filter(|run| disagree(&record.t, q, dq, run, far));
        frozen.extend(velocities.map(|run| (format!("dq_{name}"), run)));
    }
    if frozen.is_empty() {
        return;
    }
    let is_frozen = |k: usize| frozen.iter().any(|(_, run)| run.contains(&k));
    let mut kept: Vec<Range<usize>> = Vec::new();
    for k in (0..record.len()).filter(|&k| !is_frozen(k)) {
        match kept.last_mut() {
            Some(last) if last.end == k => last.end += 1,
            _ => kept.push(k..k + 1),
        }
    }
    let said = |column: &String| frozen.iter().any(|(name, _)| name == column);
    let is_news = |w: &Warning| !matches!(w, Warning::Stuck { column, .. } if said(column));
    record.warnings.retain(is_news);
    let warnings = frozen.into_iter().map(|(column, run)| Warning::Frozen {
        column,
        span: (record.t[run.start], record.t[run.end - 1]),
        samples: run.len(),
    });
    let warnings: Vec<Warning> = warnings.collect();
    *record = record.stretches(&kept);
    record.warnings.extend(warnings);
}

/// Long runs of one value.
fn runs(values: &[f64]) -> Vec<Range<usize>> {
    let mut end = 0;
    let all = values.chunk_by(|a, b| a == b).map(|run| {
        end += run.len();
        end - run.len()..end
    });
    all.filter(|run| run.len() >= FEWEST).collect()
}

/// What a coordinate must move so that its sensor should have noticed; infinite where it
/// never moves.
fn far(q: &[f64]) -> f64 {
    let least = q.iter().copied().fold(f64::INFINITY, f64::min);
    let most = q.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let quantum = quantisation_step(q).unwrap_or(0.0);
    match (MOVED * (most - least)).max(QUANTA * quantum) {
        far if far > 0.0 => far,
        _ => f64::INFINITY,
    }
}

/// How far a velocity says that a coordinate has gone since the beginning of a run, sample
/// after sample.
fn travel<'a>(t: &'a [f64], dq: &'a [f64], run: &Range<usize>) -> impl Iterator<Item = f64> + 'a {
    let steps = run.start..run.end - 1;
    steps.scan(0.0, |gone, k| {
        *gone += 0.5 * (dq[k] + dq[k + 1]) * (t[k + 1] - t[k]);
        Some(*gone)
    })
}

/// The largest step that a position ordinarily makes from sample to sample.
fn ordinary_step(q: &[f64]) -> f64 {
    let steps: Vec<f64> = q.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    quantile(&steps, ORDINARY).unwrap_or(0.0)
}

/// Whether a position leaves one value, within the log, by more than a `jump`.
fn wakes_up(q: &[f64], run: &Range<usize>, jump: f64) -> bool {
    run.start > 0 && run.end < q.len() && (q[run.end] - q[run.end - 1]).abs() > jump
}

/// Whether the position goes elsewhere than a velocity of one value says.
fn disagree(t: &[f64], q: &[f64], dq: Option<&[f64]>, run: &Range<usize>, far: f64) -> bool {
    let gone = dq.and_then(|dq| travel(t, dq, run).last());
    let went = q[run.end - 1] - q[run.start];
    gone.is_some_and(|gone| (went - gone).abs() > far)
}

#[cfg(test)]
mod tests {
    use crate::log::{Log, Record, Warning};
    use std::fmt::Write;

    /// A swing, with the position frozen from 2 s to 3 s, or held there by a brake.
    fn swing(with_velocity: bool, is_held: bool) -> Record {
        let header = if with_velocity {
            "t,q_j,dq_j,u_j\n"
        } else {
            "t,q_j,u_j\n"
        };
        let mut text = header.to_string();
        let mut q = 0.0;
        for k in 0..600 {
            let t = 0.01 * f64::from(k);
            let stands = (2.0..3.0).contains(&t);
            // Away from the turning points, where a swing would stand still anyway.
            let (now, rate) = ((1.3 * t).sin(), 1.3 * (1.3 * t).cos());
            let (now, rate) = if is_held && t >= 2.0 {
                let later = (t - 3.0).max(0.0);
                ((2.6_f64).sin() + 0.2 * later.powi(2), 0.4 * later)
            } else {
                (now, rate)
            };
            q = if stands { q } else { now };
            write!(text, "{t},{q}").unwrap();
            if with_velocity {
                write!(text, ",{rate}").unwrap();
            }
            writeln!(text, ",{}", t.cos()).unwrap();
        }
        let joint = ["j".to_string()];
        let log = Log::from_bytes("swing.csv", text.as_bytes()).unwrap();
        log.select(&joint, &joint).unwrap()
    }

    #[test]
    fn a_frozen_sensor_is_left_out() {
        for with_velocity in [true, false] {
            let record = swing(with_velocity, false);
            assert_eq!(record.len(), 499, "{:?}", record.warnings);
            let frozen = |w: &&Warning| matches!(w, Warning::Frozen { samples: 101, .. });
            assert!(
                record.warnings.iter().any(|w| frozen(&w)),
                "{:?}",
                record.warnings
            );
            assert_eq!(record.segments().len(), 2);
        }
    }

    #[test]
    fn a_joint_that_stands_still_is_not() {
        for with_velocity in [true, false] {
            assert_eq!(swing(with_velocity, true).len(), 600);
        }
    }

    /// A velocity that was never wired up leaves nothing to look at.
    #[test]
    fn a_sensor_that_is_always_frozen_is_refused() {
        let mut text = String::from("t,q_j,dq_j,u_j\n");
        for k in 0..200 {
            let t = 0.01 * f64::from(k);
            writeln!(text, "{t},{},0,{}", (1.3 * t).sin(), t.cos()).unwrap();
        }
        let joint = ["j".to_string()];
        let log = Log::from_bytes("swing.csv", text.as_bytes()).unwrap();
        insta::assert_snapshot!(log.select(&joint, &joint).unwrap_err(), @r"
        swing.csv: 1 problem in the log
          column `dq_j`: the sensor says one value while its coordinate moves, so that 0 samples are left; expected at least 50
            mend: delete the column if it is a velocity's, which need not be there; repair a position's sensor and record again
        ");
    }
}
