//! `dynamics check`: what a model contains.

use crate::model::ModelArguments;
use crate::output;
use crate::summary::Summary;
use clap::Args;
use std::io::Write;

/// Arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics check models/pendulum2.model
  dynamics check models/fourbar.model --json | jq .operations")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Print one JSON object instead of a page
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// If the model is faulty.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let summary = Summary::of(&arguments.model.load()?);
    let mut out = output::stdout();
    if arguments.json {
        serde_json::to_writer_pretty(&mut out, &summary)?;
        writeln!(out)?;
    } else {
        out.write_all(summary.page().as_bytes())?;
    }
    Ok(out.flush()?)
}
