//! When a sensor read that is slower than the rows of its log.
//!
//! What it read stands in the rows until it reads anew, so that a row in which its value changes says when that was:
//! since the row before. A log may begin anywhere between two readings, and the sensor's clock need not be the
//! log's. Where no row shows that values are held, the first row of a recording is taken for a reading.

use super::{Log, median_step};
use std::ops::Range;

/// A reading is due this share of a step before its row at the latest.
const INSTANT: f64 = 1e-3;
/// Changes on either side that say, with each one, when it was read. Three readings in ten rows meet these alike every
/// third time; over more than that a clock of its own would show.
const NEIGHBOURS: usize = 10;
/// Values that are held change no more often than their sensor reads, and this share of that.
const BESIDE: f64 = 0.05;

/// How long before each row of a log a sensor of this rate was read, where it read anew, s. Empty where
/// it reads in all rows.
pub(super) fn ages(log: &Log, values: &[f64], rate: f64) -> Vec<Option<f64>> {
    let step = median_step(&log.t);
    if rate * step >= 1.0 - INSTANT {
        return Vec::new();
    }
    let mut ages = vec![None; log.len()];
    for part in log.recordings() {
        let rows = Rows {
            t: &log.t,
            values,
            part,
            late: INSTANT * step,
        };
        rows.mark(&rows.ticks(1.0 / rate), &mut ages);
    }
    ages
}

/// One recording of a log.
struct Rows<'a> {
    t: &'a [f64],
    values: &'a [f64],
    part: Range<usize>,
    /// By how much a reading may be later than the row that shows it, s.
    late: f64,
}

impl Rows<'_> {
    /// When the sensor read, s, in the order of time.
    fn ticks(&self, period: f64) -> Vec<f64> {
        let (start, end) = (self.t[self.part.start], self.t[self.part.end - 1]);
        let known = self.known(period);
        let first = known.first().copied().unwrap_or(start);
        let last = known.last().copied().unwrap_or(start);
        let before = ((first - start + self.late) / period).floor().max(0.0) as usize;
        let mut ticks: Vec<f64> = (0..before)
            .map(|n| first - (before - n) as f64 * period)
            .collect();
        for pair in known.windows(2) {
            let count = ((pair[1] - pair[0]) / period).round().max(1.0) as usize;
            let apart = (pair[1] - pair[0]) / count as f64;
            ticks.extend((0..count).map(|n| pair[0] + n as f64 * apart));
        }
        let after = ((end - last + self.late) / period).floor().max(0.0) as usize;
        ticks.extend((0..=after).map(|n| last + n as f64 * period));
        ticks
    }

    /// When those readings were made that changed what stands in the rows: the latest that all changes
    /// around allow. None where values are not held.
    fn known(&self, period: f64) -> Vec<f64> {
        let rows = self.part.clone().skip(1);
        let changed: Vec<usize> = rows
            .filter(|&k| self.values[k] != self.values[k - 1])
            .collect();
        let duration = self.t[self.part.end - 1] - self.t[self.part.start];
        if changed.len() as f64 > (1.0 + BESIDE) * duration / period + 1.0 {
            return Vec::new();
        }
        let counted = self.counted(&changed, period);
        let when = |i: usize| {
            let row = changed[i];
            let around = i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(changed.len());
            let latest = around
                .map(|j| self.t[changed[j]] - (counted[j] as f64 - counted[i] as f64) * period);
            let latest = latest.fold(self.t[row], f64::min);
            latest.max(self.earliest(row))
        };
        (0..changed.len()).map(when).collect()
    }

    /// What a row shows first was read later than for the row before, and not after the row, s.
    fn earliest(&self, row: usize) -> f64 {
        (self.t[row - 1] + 2.0 * self.late).min(self.t[row])
    }

    /// The number of the reading that each of these rows shows first: the one that is due nearest to the time
    /// since the row before.
    fn counted(&self, changed: &[usize], period: f64) -> Vec<usize> {
        let (mut number, mut due) = (0, None);
        let next = |&row: &usize| {
            let (earliest, latest) = (self.earliest(row), self.t[row]);
            let was = due.unwrap_or(latest);
            let middle = (earliest + latest) / 2.0;
            let passed = ((middle - was) / period).round().max(0.0);
            number += passed as usize;
            due = Some((was + passed * period).clamp(earliest, latest));
            number
        };
        changed.iter().map(next).collect()
    }

    /// Writes down how long before its row each reading was made.
    fn mark(&self, ticks: &[f64], ages: &mut [Option<f64>]) {
        let mut rows = self.part.clone().peekable();
        for tick in ticks {
            while rows.next_if(|&k| self.t[k] < tick - self.late).is_some() {}
            match rows.peek() {
                Some(&row) => ages[row] = Some((self.t[row] - tick).max(0.0)),
                None => break,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log of rows every 10 ms that shows what a sensor read at these times, from before its start on.
    fn held(rows: usize, times: &[f64], read: impl Fn(f64) -> f64) -> (Log, Vec<f64>) {
        let t: Vec<f64> = (0..rows).map(|k| 0.01 * k as f64).collect();
        let values = t.iter().map(|t| {
            let last = times.iter().rev().find(|tick| **tick <= t + 1e-9);
            read(*last.unwrap_or(&times[0]))
        });
        let values: Vec<f64> = values.collect();
        let columns = vec![("t".to_owned(), t), ("gyro".to_owned(), values.clone())];
        (Log::from_columns("log", columns, None).unwrap(), values)
    }

    /// Rows that read anew, and when.
    fn taken((log, values): &(Log, Vec<f64>), rate: f64) -> Vec<(usize, f64)> {
        let ages = ages(log, values, rate);
        let new = ages.iter().enumerate();
        new.filter_map(|(k, age)| Some((k, log.t[k] - (*age)?)))
            .collect()
    }

    fn ticks(start: f64, period: f64) -> Vec<f64> {
        (0..60).map(|n| start + period * f64::from(n)).collect()
    }

    #[test]
    fn a_log_may_begin_between_two_readings() {
        for late in 0..4 {
            let times = ticks(0.01 * f64::from(late) - 0.04, 0.04);
            let new = taken(&held(100, &times, |t| (3.0 * t).sin()), 25.0);
            for (n, (row, at)) in new.iter().enumerate() {
                assert_eq!(*row, 4 * n + late as usize);
                assert!((at - 0.01 * *row as f64).abs() < 1e-9, "{at}");
            }
            assert!(new.len() >= 24);
        }
    }

    /// Where a reading is the one before, it is one all the same.
    #[test]
    fn what_rests_is_read_as_often() {
        let turns = |t: f64| if (0.3..0.5).contains(&t) { t } else { 0.3 };
        let new = taken(&held(100, &ticks(-0.01, 0.02), turns), 50.0);
        let rows: Vec<usize> = new.iter().map(|(row, _)| *row).collect();
        assert_eq!(rows, (1..100).step_by(2).collect::<Vec<usize>>());
    }

    /// 30 readings in 100 rows, which stand in the third or the fourth row.
    #[test]
    fn readings_fall_between_rows() {
        let period = 1.0 / 30.0;
        let new = taken(&held(150, &ticks(0.0, period), |t| (5.0 * t).sin()), 30.0);
        for (n, (_, at)) in new.iter().enumerate() {
            assert!((at - period * n as f64).abs() < 1e-9, "{n}: {at}");
        }
        assert_eq!(new.len(), 45);
    }

    /// A clock that is 1 % slow is a row late after two seconds, and never more than that off here.
    #[test]
    fn another_clock_is_followed() {
        let period = 0.0202;
        let times = ticks(-0.013, period);
        let new = taken(&held(100, &times, |t| (5.0 * t).sin()), 50.0);
        for (row, at) in &new {
            let miss = times
                .iter()
                .map(|tick| (tick - at).abs())
                .fold(1.0, f64::min);
            assert!(miss < 0.0101, "{row}: {at}");
            let shown = times
                .iter()
                .rev()
                .find(|tick| **tick <= 0.01 * *row as f64 + 1e-9);
            assert!((at - shown.unwrap()).abs() < 0.0101, "{row}: {at}");
        }
    }

    /// Stamps of two rows may lie nearer to each other than readings are told apart.
    #[test]
    fn rows_may_be_stamped_at_almost_one_time() {
        let t: Vec<f64> = (0..60)
            .map(|k| 0.01 * f64::from(k) - if k % 7 == 0 { 0.009_999 } else { 0.0 })
            .collect();
        let values: Vec<f64> = (0..60).map(|k| f64::from((k + 1) / 2)).collect();
        let columns = vec![("t".to_owned(), t), ("gyro".to_owned(), values.clone())];
        let log = Log::from_columns("log", columns, None).unwrap();
        let new = taken(&(log, values), 50.0);
        assert!((28..=32).contains(&new.len()), "{new:?}");
    }

    /// Nothing is held: every so manieth row counts, from the first on.
    #[test]
    fn values_of_their_own_in_every_row_say_nothing() {
        let every = ticks(0.0, 0.01);
        let new = taken(&held(60, &every, |t| (5.0 * t).sin()), 50.0);
        let rows: Vec<usize> = new.iter().map(|(row, _)| *row).collect();
        assert_eq!(rows, (0..60).step_by(2).collect::<Vec<usize>>());
    }
}
