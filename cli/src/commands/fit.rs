//! `dynamics fit`: inertias, friction and couplings of a machine whose forces were measured.

use crate::log::LogArguments;
use crate::mistake::Mistake;
use crate::model::ModelArguments;
use crate::output;
use clap::{Args, ValueEnum};
use identify::fit::{
    Comparison, Fit, Inertia, Request, Settings, compare, comparison_page, fit, page,
};
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use std::sync::LazyLock;
use std::time::Instant;

/// Arguments of `fit`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics fit arm.urdf log.csv.gz
  dynamics fit arm.urdf train.csv --test test.csv --inertia consistent --json
  dynamics fit arm.urdf train.csv --test test.csv --compare
  dynamics fit arm.urdf run1.csv run2.csv --test run3.csv --test run4.csv

Without --test the last third of the log is kept apart and judged by.")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log to learn from, or several recordings of one machine, with columns `t`,
    /// `q_<coordinate>` and `u_<input>`
    #[arg(value_name = "LOG", required = true)]
    log: Vec<PathBuf>,

    /// Another log of the same machine, to judge by; again for each of several
    #[arg(long, value_name = "LOG")]
    test: Vec<PathBuf>,

    #[command(flatten)]
    columns: LogArguments,

    /// How inertial parameters are treated
    #[arg(long, value_enum, value_name = "HOW", default_value = "linear")]
    inertia: InertiaArgument,

    /// Also learn what the model leaves by Gaussian processes (output residual, latent force,
    /// contact-invariant residual) and compare them on the data that is judged by
    #[arg(long)]
    compare: bool,

    /// Points that the processes of --compare learn from
    #[arg(long, value_name = "N", requires = "compare", value_parser = clap::value_parser!(u32).range(2..=5000))]
    points: Option<u32>,

    /// Seed of --compare
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

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
    let columns = &arguments.columns;
    let (train, test) = columns.read_both(&arguments.log, &arguments.test, model)?;
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
    let mistake = |error: identify::fit::FitError| Mistake::new(error.to_string());
    let found = if arguments.compare {
        let settings = Settings {
            points: arguments.points.map(|points| points as usize),
            seed: arguments.seed,
            clock: Some(seconds),
        };
        let (fit, comparison) = compare(&request, &settings).map_err(mistake)?;
        Found {
            fit,
            comparison: Some(comparison),
        }
    } else {
        Found {
            fit: Some(fit(&request).map_err(mistake)?),
            comparison: None,
        }
    };
    for warning in found.fit.iter().flat_map(|fit| &fit.warnings) {
        output::complain(&format!("warning: {warning}"));
    }
    let mut out = output::stdout();
    if arguments.json {
        serde_json::to_writer_pretty(&mut out, &found)?;
        writeln!(out)?;
    } else {
        let pages = [
            found.fit.as_ref().map(page),
            found.comparison.as_ref().map(comparison_page),
        ];
        let pages: Vec<String> = pages.into_iter().flatten().collect();
        out.write_all(pages.join("\n").as_bytes())?;
    }
    Ok(out.flush()?)
}

/// Seconds since it was first asked.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// What is printed.
#[derive(Debug, Serialize)]
struct Found {
    #[serde(flatten)]
    fit: Option<Fit>,
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<Comparison>,
}
