//! Runs damaged inputs by the thousand: `docs/robustness.md` says what was found.

use clap::Parser;
use integration_tests::fuzz::supervise::{Limits, Tally, supervise};
use integration_tests::fuzz::worker::{self, Stretch};
use integration_tests::fuzz::{Input, Kind, STACK};
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Damaged models, robots, effects, logs, maps, states and inputs.
#[derive(Debug, Clone, Parser)]
#[command(after_help = "\
Examples:
  fuzz --count 1000000                          all kinds
  fuzz --kind urdf --count 5000 --keep found    one kind; what fails is written to found/
  fuzz --kind model --from 4711 --count 1       one input again
  fuzz --kind model --from 4711 --print         what it is")]
struct Arguments {
    /// How many inputs, of all kinds together
    #[arg(long, default_value_t = 1)]
    count: u64,

    /// The kind: model, urdf, mjcf, effect, log, map, state, inputs, control; without it all, by their share
    #[arg(long)]
    kind: Option<Kind>,

    /// The seed: input i of a seed is always the same
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// The number of the first input of each kind
    #[arg(long, default_value_t = 0)]
    from: u64,

    /// A folder for the inputs that fail, shortened
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,

    /// Write the first input to standard output and run nothing
    #[arg(long, requires = "kind")]
    print: bool,

    /// Run them here, without a process that watches
    #[arg(long, requires = "kind", hide = true)]
    worker: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let done = match (arguments.kind, arguments.print, arguments.worker) {
        (Some(kind), true, _) => print(kind, &arguments),
        (Some(kind), _, true) => work(kind, arguments),
        _ => all(&arguments),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(2),
        Err(error) => {
            eprintln!("fuzz: {error}");
            ExitCode::FAILURE
        }
    }
}

fn print(kind: Kind, arguments: &Arguments) -> io::Result<bool> {
    let input = Input::new(kind, arguments.seed, arguments.from);
    io::stdout().write_all(&input.bytes)?;
    Ok(true)
}

impl Arguments {
    fn stretch(&self, kind: Kind) -> Stretch {
        let count = match self.kind {
            Some(_) => self.count,
            None => self.count * kind.per_mille() / 1000,
        };
        Stretch {
            kind,
            seed: self.seed,
            range: self.from..self.from + count,
        }
    }
}

/// Runs the inputs in this process, on a thread with as little stack as any reader may have.
fn work(kind: Kind, arguments: Arguments) -> io::Result<bool> {
    let run = move || {
        let mut out = io::stdout().lock();
        worker::run(
            &arguments.stretch(kind),
            &mut out,
            arguments.keep.as_deref(),
        )
    };
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(run)?;
    let died = || io::Error::other("the thread panicked outside of an input");
    thread.join().map_err(|_| died())??;
    Ok(true)
}

/// Runs the inputs in processes; whether nothing was found.
fn all(arguments: &Arguments) -> io::Result<bool> {
    if let Some(folder) = &arguments.keep {
        std::fs::create_dir_all(folder)?;
    }
    let kinds = match arguments.kind {
        Some(kind) => vec![kind],
        None => Kind::ALL.to_vec(),
    };
    println!(
        "{:8} {:>9} {:>9} {:>9} {:>8} {:>9} {:>9} {:>10} {:>10} {:>7}",
        "kind",
        "inputs",
        "accepted",
        "MB",
        "s",
        "slowest s",
        "(number)",
        "longest, B",
        "memory, MB",
        "failed"
    );
    let (mut clean, mut peak) = (true, 0);
    for kind in kinds {
        let stretch = arguments.stretch(kind);
        let program = std::env::current_exe()?;
        let start = |range| worker_command(&program, arguments, kind, range);
        let tally = supervise(&stretch, Limits::default(), start)?;
        report(kind, &tally);
        clean &= tally.failures.is_empty();
        peak = peak.max(tally.peak_kib);
    }
    println!("most memory: {} MB; seed {}", peak / 1000, arguments.seed);
    Ok(clean)
}

fn worker_command(program: &Path, arguments: &Arguments, kind: Kind, range: Range<u64>) -> Command {
    let mut command = Command::new(program);
    command.args(["--worker", "--kind", kind.name()]);
    for (name, value) in [
        ("--seed", arguments.seed),
        ("--from", range.start),
        ("--count", range.end - range.start),
    ] {
        command.args([name, &value.to_string()]);
    }
    if let Some(folder) = &arguments.keep {
        command.arg("--keep").arg(folder);
    }
    command
}

fn report(kind: Kind, tally: &Tally) {
    let (slowest, seconds) = tally.slowest;
    println!(
        "{:8} {:9} {:9} {:9.1} {:8.1} {:9.3} {:9} {:10} {:10} {:7}",
        kind.name(),
        tally.run,
        tally.accepted,
        tally.bytes as f64 / 1e6,
        tally.seconds,
        seconds,
        slowest,
        tally.longest.1,
        tally.peak_kib / 1000,
        tally.failures.len()
    );
    for (index, message) in &tally.failures {
        println!("  {kind} {index}: {message}");
    }
}
