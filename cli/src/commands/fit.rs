//! `dynamics fit`: inertias, friction and couplings of a machine whose forces were measured.

use crate::log::LogArguments;
use crate::mistake::Mistake;
use crate::model::ModelArguments;
use crate::output;
use clap::{Args, ValueEnum};
use identify::fit::{Inertia, Request, fit, page};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `fit`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics fit arm.urdf log.csv.gz
  dynamics fit arm.urdf train.csv --test test.csv --inertia consistent --json

Without --test the last third of the log is kept apart and judged by.")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log to learn from, with columns `t`, `q_<coordinate>` and `u_<input>`
    #[arg(value_name = "LOG")]
    log: PathBuf,

    /// A second log of the same machine, to judge by
    #[arg(long, value_name = "LOG")]
    test: Option<PathBuf>,

    #[command(flatten)]
    columns: LogArguments,

    /// How inertial parameters are treated
    #[arg(long, value_enum, value_name = "HOW", default_value = "linear")]
    inertia: InertiaArgument,

    /// Print one JSON object instead of a page
    #[arg(long)]
    json: bool,
}

/// How inertial parameters are treated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum InertiaArgument {
    /// They are the model's
    Fixed,
    /// Linear regression, near the model's where the log is silent
    Linear,
    /// Only numbers that a rigid body can have
    Consistent,
}

/// Runs the command.
///
/// # Errors
/// If model and log cannot be used together.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let loaded = arguments.model.load()?;
    let model = &loaded.compiled.model;
    let read = |path| arguments.columns.read(path, model);
    let train = read(arguments.log.as_path())?;
    let test = arguments.test.as_deref().map(read).transpose()?;
    let request = Request {
        compiled: &loaded.compiled,
        parameters: &loaded.parameters,
        train: &train,
        test: test.as_ref(),
        inertia: match arguments.inertia {
            InertiaArgument::Fixed => Inertia::Fixed,
            InertiaArgument::Linear => Inertia::Linear,
            InertiaArgument::Consistent => Inertia::Consistent,
        },
    };
    let found = fit(&request).map_err(|error| Mistake::new(error.to_string()))?;
    for warning in &found.warnings {
        output::complain(&format!("warning: {warning}"));
    }
    let mut out = output::stdout();
    if arguments.json {
        serde_json::to_writer_pretty(&mut out, &found)?;
        writeln!(out)?;
    } else {
        out.write_all(page(&found).as_bytes())?;
    }
    Ok(out.flush()?)
}
