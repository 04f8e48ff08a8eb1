//! Runs inputs one after the other and tells each step, so that whoever listens knows which
//! input is under way when the telling stops.
//!
//! ```text
//! start 17               before input 17, and again and again while its failure is shortened
//! failed 17 {…}          a failure, as JSON
//! done 17 refused 212 0.000314 51234
//!                        behind it: bytes, seconds, and the peak of memory so far in KiB
//! ```

use super::{Failure, Input, Kind, Outcome, outcome, shrink};
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// Characters of a message and of an input that are told; `keep` has all of the input.
const SHOWN: usize = 600;

/// Which inputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stretch {
    /// Of which kind.
    pub kind: Kind,
    /// Of which seed.
    pub seed: u64,
    /// Which of them.
    pub range: Range<u64>,
}

/// Runs the inputs of a stretch and tells of them on `out`. The first failure at each place
/// is shortened, and what is left written to a file in `keep`, if there is such a folder.
///
/// # Errors
/// If nobody listens any more, or the folder cannot be written to.
pub fn run(stretch: &Stretch, out: &mut impl Write, keep: Option<&Path>) -> io::Result<()> {
    let mut places = BTreeSet::new();
    for index in stretch.range.clone() {
        writeln!(out, "start {index}")?;
        out.flush()?;
        let input = Input::new(stretch.kind, stretch.seed, index);
        let begin = Instant::now();
        let outcome = outcome(&input);
        let seconds = begin.elapsed().as_secs_f64();
        if let Outcome::Failed(failure) = &outcome {
            let shortest = if places.insert(failure.place.clone()) {
                shortened(&input, failure, index, out)?
            } else {
                input.clone()
            };
            tell(out, index, failure, &shortest)?;
            if let Some(folder) = keep {
                let name = format!("{}-{index}-{}", stretch.seed, input.file_name());
                std::fs::write(folder.join(name), &shortest.bytes)?;
            }
        }
        let word = match outcome {
            Outcome::Accepted => "accepted",
            Outcome::Refused => "refused",
            Outcome::Failed(_) => "failed",
        };
        let (bytes, peak) = (input.bytes.len(), peak_kib());
        writeln!(out, "done {index} {word} {bytes} {seconds:.6} {peak}")?;
        // Nothing points into the texts that the parsers of Rust's tokens keep of each thread;
        // a program reads a few, here they would be a million.
        proc_macro2::extra::invalidate_current_thread_spans();
    }
    out.flush()
}

fn shortened(
    input: &Input,
    failure: &Failure,
    index: u64,
    out: &mut impl Write,
) -> io::Result<Input> {
    let mut told = Ok(());
    let shortest = shrink(input, |shorter| {
        told = writeln!(out, "start {index}").and_then(|()| out.flush());
        matches!(outcome(shorter), Outcome::Failed(found) if found.place == failure.place)
    });
    told.map(|()| shortest)
}

fn tell(out: &mut impl Write, index: u64, failure: &Failure, input: &Input) -> io::Result<()> {
    let beginning = |text: &str| text.chars().take(SHOWN).collect::<String>();
    let told = serde_json::json!({
        "place": failure.place,
        "message": beginning(&failure.message),
        "input": beginning(&String::from_utf8_lossy(&input.bytes)),
        "host": input.host,
        "choice": input.choice,
    });
    writeln!(out, "failed {index} {told}")
}

/// The most memory that this process has had so far, in KiB; 0 where the system does not say.
fn peak_kib() -> u64 {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| field(&status, "VmHWM:"))
        .unwrap_or(0)
}

/// A number of a process's status.
pub(super) fn field(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_input_is_told_of_before_and_behind() {
        let stretch = Stretch {
            kind: Kind::Map,
            seed: 1,
            range: 5..8,
        };
        let mut told = Vec::new();
        run(&stretch, &mut told, None).unwrap();
        let told = String::from_utf8(told).unwrap();
        let starts: Vec<&str> = told.lines().step_by(2).collect();
        assert_eq!(starts, ["start 5", "start 6", "start 7"], "{told}");
        let ends = told.lines().skip(1).step_by(2);
        assert!(
            ends.into_iter().all(|line| line.starts_with("done ")),
            "{told}"
        );
    }

    #[test]
    fn fields_of_a_status_are_read() {
        let status = "Name:\tfuzz\nVmHWM:\t   51234 kB\n";
        assert_eq!(field(status, "VmHWM:"), Some(51234));
        assert_eq!(field(status, "VmRSS:"), None);
    }
}
