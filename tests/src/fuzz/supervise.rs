//! Watches a process that runs inputs: what a panic does not end can still hang, overflow the
//! stack or fill the memory.

use super::worker::{Stretch, field};
use std::io::{self, BufRead, BufReader};
use std::ops::Range;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// What an input may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// How long, by the clock.
    pub time: Duration,
    /// How much memory the process may have had, in KiB.
    pub memory_kib: u64,
}

impl Default for Limits {
    /// 10 s and 1 GB: what somebody waits for a page to be refused, and what a small machine
    /// has.
    fn default() -> Self {
        Self {
            time: Duration::from_secs(10),
            memory_kib: 1_000_000,
        }
    }
}

/// What became of the inputs of a stretch.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Inputs that were run.
    pub run: u64,
    /// Those that were read and worked with.
    pub accepted: u64,
    /// All their bytes.
    pub bytes: u64,
    /// The longest, with its bytes.
    pub longest: (u64, u64),
    /// All their time, s.
    pub seconds: f64,
    /// The slowest, with its time, s.
    pub slowest: (u64, f64),
    /// The most memory of the process, KiB.
    pub peak_kib: u64,
    /// What failed, by number: what was said about it.
    pub failures: Vec<(u64, String)>,
}

/// How often the memory of the process is looked at while it is silent.
const LOOK: Duration = Duration::from_millis(100);

/// Runs a stretch in processes that `start` makes for a range of it: one, and behind every
/// input that ends one, another.
///
/// # Errors
/// If a process cannot be started.
pub fn supervise(
    stretch: &Stretch,
    limits: Limits,
    start: impl Fn(Range<u64>) -> Command,
) -> io::Result<Tally> {
    let mut tally = Tally::default();
    let mut next = stretch.range.start;
    while next < stretch.range.end {
        let mut child = start(next..stretch.range.end)
            .stdout(Stdio::piped())
            .stdin(Stdio::null())
            .spawn()?;
        let lines = lines(&mut child);
        let mut watch = Watch {
            limits,
            child: &mut child,
            tally: &mut tally,
            under_way: next,
        };
        let verdict = watch.listen(&lines);
        let under_way = watch.under_way;
        // It may have ended by itself.
        child.kill().ok();
        let status = child.wait()?;
        next = match verdict.or_else(|| died(status)) {
            None => break,
            Some(message) => {
                tally.run += 1;
                tally.failures.push((under_way, message));
                under_way + 1
            }
        };
    }
    Ok(tally)
}

/// The lines of the child, from a thread that reads them.
fn lines(child: &mut Child) -> Receiver<String> {
    let (send, receive) = channel();
    let stdout = child.stdout.take();
    std::thread::spawn(move || {
        for line in stdout
            .into_iter()
            .flat_map(|out| BufReader::new(out).lines())
        {
            // Without a listener, or a line, there is nothing more to do.
            let Ok(line) = line else { break };
            if send.send(line).is_err() {
                break;
            }
        }
    });
    receive
}

fn died(status: ExitStatus) -> Option<String> {
    (!status.success()).then(|| format!("the process ended: {status}"))
}

/// A child under observation.
struct Watch<'a> {
    limits: Limits,
    child: &'a mut Child,
    tally: &'a mut Tally,
    under_way: u64,
}

impl Watch<'_> {
    /// Listens to the end of the lines; the reason if the child is to be ended before.
    fn listen(&mut self, lines: &Receiver<String>) -> Option<String> {
        let mut heard = Instant::now();
        loop {
            match lines.recv_timeout(LOOK) {
                Ok(line) => {
                    heard = Instant::now();
                    if let Some(reason) = self.note(&line) {
                        return Some(reason);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => return None,
                Err(RecvTimeoutError::Timeout) => {}
            }
            if heard.elapsed() > self.limits.time {
                return Some(format!("no answer after {:?}", self.limits.time));
            }
            if heard.elapsed() > LOOK && self.memory_kib() > self.limits.memory_kib {
                return Some(format!(
                    "more than {} KiB of memory",
                    self.limits.memory_kib
                ));
            }
        }
    }

    /// What the child has now, KiB; 0 where the system does not say.
    fn memory_kib(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id()));
        status.ok().and_then(|s| field(&s, "VmRSS:")).unwrap_or(0)
    }

    /// Notes a line of the protocol; the reason if it is one to stop for.
    fn note(&mut self, line: &str) -> Option<String> {
        let mut words = line.splitn(3, ' ');
        let (what, index) = (words.next(), words.next().and_then(|w| w.parse().ok()));
        let (rest, index) = (words.next().unwrap_or_default(), index?);
        match what {
            Some("start") => self.under_way = index,
            Some("failed") => self.tally.failures.push((index, rest.to_string())),
            Some("done") => return self.done(index, rest),
            _ => {}
        }
        None
    }

    fn done(&mut self, index: u64, rest: &str) -> Option<String> {
        let words: Vec<&str> = rest.split(' ').collect();
        let [word, bytes, seconds, peak] = words[..] else {
            return None;
        };
        let seconds = seconds.parse().unwrap_or(0.0);
        let peak = peak.parse().unwrap_or(0);
        if peak > self.limits.memory_kib {
            return Some(format!("{peak} KiB of memory"));
        }
        let tally = &mut *self.tally;
        tally.run += 1;
        tally.accepted += u64::from(word == "accepted");
        let bytes = bytes.parse().unwrap_or(0);
        tally.bytes += bytes;
        if bytes > tally.longest.1 {
            tally.longest = (index, bytes);
        }
        tally.seconds += seconds;
        tally.peak_kib = tally.peak_kib.max(peak);
        if seconds > tally.slowest.1 {
            tally.slowest = (index, seconds);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fuzz::Kind;

    /// A child that says what a shell script says, for inputs 0 to 2; from 1 on it is fine.
    fn watched(script: &'static str, limits: Limits) -> Tally {
        let stretch = Stretch {
            kind: Kind::Model,
            seed: 1,
            range: 0..2,
        };
        let fine = "echo start 1; echo done 1 accepted 10 0.5 2000";
        let start = |range: Range<u64>| {
            let mut command = Command::new("sh");
            command.args(["-c", if range.start == 0 { script } else { fine }]);
            command
        };
        supervise(&stretch, limits, start).unwrap()
    }

    #[test]
    fn what_is_told_is_counted() {
        let script = "echo start 0; echo failed 0 '{}'; echo done 0 failed 7 0.25 1000;
            echo start 1; echo done 1 accepted 3 2.5 900";
        let expected = Tally {
            run: 2,
            accepted: 1,
            bytes: 10,
            longest: (0, 7),
            seconds: 2.75,
            slowest: (1, 2.5),
            peak_kib: 1000,
            failures: vec![(0, "{}".to_string())],
        };
        assert_eq!(watched(script, Limits::default()), expected);
    }

    /// The one that was under way is named, and the others are run all the same.
    #[test]
    fn what_ends_the_process_is_found() {
        let short = Limits {
            time: Duration::from_millis(300),
            ..Limits::default()
        };
        for (script, limits, said) in [
            (
                "echo start 0; kill -ABRT $$",
                Limits::default(),
                "signal: 6",
            ),
            ("echo start 0; exec sleep 1000", short, "no answer"),
            (
                "echo start 0; echo done 0 refused 1 0.1 9000000",
                Limits::default(),
                "9000000 KiB",
            ),
        ] {
            let tally = watched(script, limits);
            let [(0, message)] = &tally.failures[..] else {
                panic!("{tally:?}");
            };
            assert!(message.contains(said), "{message}");
            assert_eq!((tally.run, tally.accepted), (2, 1), "{tally:?}");
        }
    }
}
