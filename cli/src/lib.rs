//! The command line: a thin shell over `dynamics-codegen` and `identify`.
//!
//! One file per command under [`commands`]; what they share stands beside it.
//! This is the only crate that prints. Exit codes: 0 success, 1 internal failure,
//! 2 bad input — with its place and a mend, and nothing half-written — and 130 for a job that an
//! interrupt ended early, with what it had.

pub mod answer;
pub mod command_line;
pub mod commands;
pub mod fold;
pub mod folder;
pub mod inputs;
pub mod json;
pub mod lines;
pub mod log;
pub mod mistake;
pub mod model;
pub mod noise;
pub mod output;
pub mod page;
pub mod parameters;
pub mod pending;
pub mod results;
pub mod revision;
pub mod signals;
pub mod simulation;
pub mod stages;
pub mod start;
pub mod state;
pub mod summary;
pub mod view;
pub mod whole_file;

use clap::{CommandFactory, Parser};
use commands::Command;
use std::io::{self, ErrorKind};
use std::process::ExitCode;

/// Equations of motion from a model file, and what a measured log says about them.
#[derive(Debug, Parser)]
#[command(
    name = "dynamics",
    bin_name = "dynamics",
    version,
    propagate_version = true
)]
#[command(after_help = "\
Examples:
  dynamics check models/pendulum2.model
  echo '{\"q\": [0.1, 0.2]}' | dynamics eval models/pendulum2.model --states - --json
  dynamics simulate models/pendulum2.model --init '{\"q\": [1, 0]}' --duration 10 --out log.csv
  dynamics trace models/pendulum2.model train.csv --test test.csv

Exit codes: 0 success, 1 internal failure, 2 bad input, 130 ended early by an interrupt.")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// What a shell says of a program that an interrupt ended.
const INTERRUPTED: u8 = 130;

/// Reads the arguments, runs the command, prints what went wrong.
pub fn main() -> ExitCode {
    match Arguments::try_parse() {
        Ok(arguments) => conclude(arguments.command.run(Arguments::command())),
        Err(usage) => {
            // A closed pipe is no reason to complain about the help text.
            usage.print().ok();
            ExitCode::from(u8::try_from(usage.exit_code()).unwrap_or(2))
        }
    }
}

/// The exit code of work that is over; says on standard error what went wrong. Who reads our output no
/// more has what it wanted.
pub fn conclude(result: anyhow::Result<()>) -> ExitCode {
    let Err(error) = result else {
        return match signals::asked_to_end() {
            true => ExitCode::from(INTERRUPTED),
            false => ExitCode::SUCCESS,
        };
    };
    if reader_has_gone(&error) {
        return ExitCode::SUCCESS;
    }
    if let Some(mistake) = error.downcast_ref::<mistake::Mistake>() {
        output::explain(mistake);
        return ExitCode::from(2);
    }
    let causes: Vec<String> = error.chain().map(ToString::to_string).collect();
    output::complain(&format!("internal failure: {}", causes.join(": ")));
    ExitCode::from(1)
}

/// Whoever read our output (`head`, a pager) has what it wanted.
fn reader_has_gone(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let io = cause.downcast_ref::<io::Error>().map(io::Error::kind);
        let json = cause
            .downcast_ref::<serde_json::Error>()
            .and_then(serde_json::Error::io_error_kind);
        io.or(json) == Some(ErrorKind::BrokenPipe)
    })
}
