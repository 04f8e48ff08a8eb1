//! Recordings one after the other: the same columns, later.

use super::error::{ProblemKind, Problems};
use super::{Log, LogError, Warning, limits, longest_step, median_step};
use std::ops::Range;
use std::path::Path;

/// Median steps of recordings that follow each other differ by this factor at most: gaps are told
/// by the median step of all.
const ALIKE: f64 = 1.5;

/// A recording that starts anew follows after so many of the longest steps that are no gap.
const PAUSE: f64 = 4.0;

impl Log {
    /// Appends a recording of the same machine. Where its stamps go on, they stay; where they start
    /// anew, they are put behind those that are there, with a gap that nothing is joined across, and
    /// a warning says so. Columns that only one of both has are left out.
    ///
    /// # Errors
    /// [`LogError::Invalid`] if it lacks a channel that this log has, was recorded at another rate,
    /// or both together are larger than a log may be.
    pub fn follow(&mut self, mut next: Log) -> Result<(), LogError> {
        let fail = |kind| Err(Problems::whole(kind).into_error(&next.path));
        let after = self.path.display().to_string();
        let (step, expected) = (median_step(&next.t), median_step(&self.t));
        if step > ALIKE * expected || expected > ALIKE * step {
            return fail(ProblemKind::OtherStep {
                step,
                after,
                expected,
            });
        }
        let lacking = |prefix: &str| {
            let columns = self
                .channels
                .keys()
                .filter(|column| column.starts_with(prefix));
            let lacking = columns.filter(|column| !next.channels.contains_key(*column));
            lacking.cloned().collect::<Vec<String>>()
        };
        let columns = [lacking("q_"), lacking("u_")].concat();
        if !columns.is_empty() {
            return fail(ProblemKind::OtherColumns { columns, after });
        }
        let rows = self.t.len() + next.t.len();
        if let Err(kind) = limits::check(rows, 1 + self.channels.len()) {
            return fail(kind);
        }
        let last = self.t.last().copied().unwrap_or(0.0);
        let first = next.t.first().copied().unwrap_or(0.0);
        if first <= last {
            let pause = PAUSE * longest_step(&self.t).max(longest_step(&next.t));
            let by = last + pause - first;
            next.t.iter_mut().for_each(|t| *t += by);
            let file = next.path.display().to_string();
            next.warnings.push(Warning::Shifted { file, by });
        }
        self.followed.push((self.t.len(), next.path));
        self.t.append(&mut next.t);
        self.lines.append(&mut next.lines);
        self.channels.retain(|column, values| {
            let more = next.channels.remove(column);
            more.is_some_and(|mut more| {
                values.append(&mut more);
                true
            })
        });
        self.warnings.append(&mut next.warnings);
        Ok(())
    }

    /// The names of its files, as reports show them: `a.csv`, or `a.csv, b.csv`.
    pub fn name(&self) -> String {
        let later = self.followed.iter().map(|(_, path)| path.as_path());
        let names = std::iter::once(self.path.as_path())
            .chain(later)
            .map(|path| {
                let name = path.file_name().unwrap_or_default();
                name.to_string_lossy().into_owned()
            });
        names.collect::<Vec<String>>().join(", ")
    }

    /// The samples of each recording.
    pub(super) fn recordings(&self) -> impl Iterator<Item = Range<usize>> {
        let firsts = self.followed.iter().map(|(first, _)| *first);
        let begins = std::iter::once(0).chain(firsts.clone());
        begins
            .zip(firsts.chain([self.len()]))
            .map(|(begin, end)| begin..end)
    }

    /// Where the sample that is nearest to an instant stands: the file, if the log has several, and the line.
    pub(crate) fn place(&self, t: f64) -> (Option<String>, u64) {
        let after = self.t.partition_point(|&stamp| stamp < t);
        let either = [after.saturating_sub(1), after.min(self.len() - 1)];
        let apart = |&sample: &usize| (self.t[sample] - t).abs();
        let nearest = either
            .into_iter()
            .min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let sample = nearest.expect("one of two");
        let file = self.file_of(sample);
        (
            file.map(|path| path.display().to_string()),
            self.lines[sample],
        )
    }

    /// The file of a sample, if the log has several.
    pub(super) fn file_of(&self, sample: usize) -> Option<&Path> {
        let of_first = self.followed.first().map(|_| self.path.as_path());
        let mut later = self.followed.iter().rev();
        let found = later.find(|(first, _)| *first <= sample);
        found.map(|(_, path)| path.as_path()).or(of_first)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{good, names};
    use super::*;

    fn log(name: &str, text: &str) -> Log {
        Log::from_bytes(name, text.as_bytes()).unwrap()
    }

    #[test]
    fn recordings_that_start_anew_follow_with_a_gap() {
        let mut all = log("a.csv", &good(60));
        all.follow(log("b.csv", &good(80))).unwrap();
        assert_eq!((all.len(), all.name()), (140, "a.csv, b.csv".to_owned()));
        assert_eq!(all.recordings().collect::<Vec<_>>(), [0..60, 60..140]);
        let record = all.select(&names(&["a"]), &names(&["a"])).unwrap();
        assert_eq!(record.segments(), [0..60, 60..140]);
        insta::assert_snapshot!(all.warnings[0], @"the stamps of `b.csv` start anew: 0.790000 s were added to them; nothing is joined across the gap");
        assert_eq!(all.file_of(59), Some(Path::new("a.csv")));
        assert_eq!(
            (all.file_of(60), all.lines[60]),
            (Some(Path::new("b.csv")), 2)
        );
    }

    #[test]
    fn stamps_that_go_on_stay() {
        let whole = good(120);
        let (first, second) = whole.split_at(whole.find("\n0.60").unwrap() + 1);
        let mut all = log("a.csv", first);
        all.follow(log("b.csv", &format!("t,q_a,u_a\n{second}")))
            .unwrap();
        let expected = log("c.csv", &whole);
        assert_eq!((&all.t, &all.channels), (&expected.t, &expected.channels));
        assert_eq!(all.warnings, []);
    }

    #[test]
    fn other_recordings_do_not_follow() {
        let refused = |text: &str| {
            let mut first = log("a.csv", &good(60));
            first.follow(log("b.csv", text)).unwrap_err().to_string()
        };
        insta::assert_snapshot!(refused(&good(60).replace("u_a", "u_b")), @r"
        b.csv: 1 problem in the log
          it has no column `u_a` as `a.csv` has, which it follows
            mend: give recordings of the same columns, each with its map if they are called otherwise
        ");
        let rows = (0..60).map(|k| format!("{k},0,0\n")).collect::<String>();
        insta::assert_snapshot!(refused(&format!("t,q_a,u_a\n{rows}")), @r"
        b.csv: 1 problem in the log
          it was recorded every 1.000000 s and `a.csv`, which it follows, every 0.010000 s
            mend: give recordings at one rate, or bring them to one
        ");
    }
}
