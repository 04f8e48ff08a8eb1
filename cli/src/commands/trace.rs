//! `dynamics trace`: what a log says that the model lacks.

use crate::command_line::command;
use crate::folder::{self, Folder, file_safe};
use crate::log::LogArguments;
use crate::mistake::Mistake;
use crate::model::{Loaded, ModelArguments};
use crate::output;
use crate::results::Results;
use crate::stages::Stages;
use clap::{Args, ValueEnum};
use dynamics_codegen::Model;
use dynamics_codegen::diagnostic::visible;
use identify::log::Log;
use identify::machine::Hold;
use identify::report::{self, Page, Portable, portable};
use identify::trace::{Ended, Outcome, Request, TraceError, UnnamedForce, trace};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Arguments of `trace`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics trace models/pendulum2.model train.csv --test test.csv
  dynamics trace arm.model log.csv.gz --parameters arm7.json --report out --json
  dynamics trace arm.model log.csv --apply
  dynamics trace arm.model run1.csv run2.csv --test run3.csv --test run4.csv

Without --test the last third of the log is kept apart and judged by. At the time limit, and when it
is interrupted once (Ctrl-C), the search ends with the best that it has and says so; what an
interrupt ended is not applied.")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log to learn from, or several recordings of one machine: CSV, Parquet, MCAP, db3 or
    /// ULog, with columns `t`, `q_<coordinate>`, `u_<input>` and, if measured, `dq_<coordinate>`
    /// and `ddq_<coordinate>`, or with a map
    #[arg(value_name = "TRAIN.csv", required = true)]
    train: Vec<PathBuf>,

    /// Another log of the same machine, to judge by; again for each of several
    #[arg(long, value_name = "TEST.csv")]
    test: Vec<PathBuf>,

    #[command(flatten)]
    log: LogArguments,

    /// Write what was found into the model file
    #[arg(long)]
    apply: bool,

    /// A folder for the report (`report.html`, `report.json`, `series.json`, `summary.txt`,
    /// `model.diff`, the model with the findings and the files that it names, forces without a
    /// name as processes); made if it is not there
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,

    /// Print one JSON object instead of a summary
    #[arg(long)]
    json: bool,

    /// Search although columns of the log look mistaken
    #[arg(long)]
    trust_columns: bool,

    /// What inputs do between samples; found from the log if not stated
    #[arg(long, value_enum, value_name = "HOLD")]
    hold: Option<HoldArgument>,

    /// How long open-loop predictions run, in seconds
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    horizon: f64,

    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// Seconds after which the search ends with the best that it has; `inf` for no limit
    #[arg(long, value_name = "S", default_value_t = 600.0)]
    time_limit: f64,
}

/// What inputs do between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum HoldArgument {
    /// Go straight from one sample to the next
    Linear,
    /// Stay at the earlier sample's value
    Previous,
}

/// Runs the command.
///
/// # Errors
/// If model or logs cannot be used together, or the results not be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if !(arguments.horizon > 0.0 && arguments.horizon.is_finite()) {
        let message = format!("`--horizon {}` is not a duration", arguments.horizon);
        return Err(Mistake::new(message)
            .help("give seconds, such as `--horizon 0.5`")
            .into());
    }
    let limit = time_limit(arguments.time_limit)?;
    let loaded = arguments.model.load()?;
    let model = &loaded.compiled.model;
    let (text, path) = loaded.text();
    let report = arguments.report.as_deref();
    let results = Results::prepare(&loaded, &path, arguments.apply, report)?;
    let (train, test) = arguments
        .log
        .read_both(&arguments.train, &arguments.test, model)?;
    let stages = Stages::new(limit)?;
    let outcome = run_trace(arguments, &loaded, &text, (&train, test.as_ref()), &stages);
    let took = stages.finish();
    let found = Found::new(outcome?, &loaded, &text, &path)?;
    let is_changed = !found.diff.is_empty() && !found.is_interrupted();
    let written = results.write(
        |folder| found.report(folder, model, &command(Some(arguments.seed))),
        is_changed.then_some(&found.outcome.patched_model),
    );
    found.tell(arguments.json, &took, written.is_applied())?;
    written.finish()
}

/// How long a search may take; no time at all is a limit, too.
fn time_limit(seconds: f64) -> Result<Option<Duration>, Mistake> {
    if seconds == f64::INFINITY {
        return Ok(None);
    }
    let limit = Duration::try_from_secs_f64(seconds);
    limit.map(Some).map_err(|_| {
        let message = format!("`--time-limit {seconds}` is not a duration");
        Mistake::new(message).help("give seconds, such as `--time-limit 60`, or `inf`")
    })
}

/// What a trace has found, and how it is told.
#[derive(Debug)]
pub struct Found {
    /// What was found.
    pub outcome: Outcome,
    /// The model's file.
    name: String,
    /// The change to it; empty if nothing changes.
    pub diff: String,
    /// What `--json` prints.
    pub json: String,
    /// What is printed without.
    pub summary: String,
    /// The model with the findings, and the files that it names.
    pub portable: Portable,
    /// How the model in the report's folder is read, if it takes more than its name.
    reading: Option<String>,
}

impl Found {
    /// Of an outcome; `text` and `path` are the model's.
    ///
    /// # Errors
    /// If it cannot be written as JSON.
    pub fn new(outcome: Outcome, loaded: &Loaded, text: &str, path: &Path) -> anyhow::Result<Self> {
        let name = path.display().to_string();
        let original = match loaded.is_robot_description() {
            true => "",
            false => text,
        };
        let diff = match outcome.patched_model == text {
            true => String::new(),
            false => report::diff(&name, original, &outcome.patched_model),
        };
        let portable = portable(&outcome.patched_model, &loaded.compiled, &loaded.library);
        Ok(Self {
            json: serde_json::to_string_pretty(&outcome)?,
            summary: report::summary(&outcome, &loaded.compiled.model),
            reading: folder::reading(&portable, path),
            portable,
            outcome,
            name,
            diff,
        })
    }

    fn is_interrupted(&self) -> bool {
        self.outcome.unfinished == Some(Ended::Interrupt)
    }

    /// The page of the report; `command` is what was called.
    ///
    /// # Errors
    /// If a figure cannot be drawn.
    pub fn html(&self, model: &Model, command: &str) -> anyhow::Result<String> {
        Ok(report::html(&Page {
            outcome: &self.outcome,
            model,
            file: &self.name,
            diff: &self.diff,
            reading: self.reading.as_deref(),
            command,
        })?)
    }

    /// Forces without a name as processes: names of files, and texts.
    pub fn processes(&self) -> Vec<(String, &str)> {
        let unnamed = self.outcome.unnamed.iter();
        let forces = unnamed.flat_map(|unnamed| &unnamed.forces);
        let process =
            |force: &'_ UnnamedForce| format!("force_{}.gp.json", file_safe(&force.coordinate));
        forces
            .map(|force| (process(force), force.saved.as_str()))
            .collect()
    }

    /// Writes the report.
    ///
    /// # Errors
    /// If a figure cannot be drawn, or there is no room.
    pub fn report(&self, folder: &Folder<'_>, model: &Model, command: &str) -> anyhow::Result<()> {
        let texts = [
            &self.html(model, command)?,
            &self.json,
            &serde_json::to_string(&self.outcome.details)?,
            &*visible(&self.summary),
            &self.diff,
        ];
        Ok(folder.write(texts, &self.processes(), &self.portable)?)
    }

    fn tell(&self, json: bool, took: &str, applied: bool) -> anyhow::Result<()> {
        for warning in &self.outcome.warnings {
            output::complain(&format!("warning: {warning}"));
        }
        let mut out = output::stdout();
        if json {
            writeln!(out, "{}", self.json)?;
            output::complain(&format!("Took {took}"));
        } else {
            write!(out, "{}\nTook {took}\n", self.summary)?;
            let Self { name, diff, .. } = self;
            if !diff.is_empty() {
                let applied = match applied {
                    true => "Written into",
                    false => "Patch (--apply writes it) for",
                };
                writeln!(out, "\n{applied} {name}:\n\n{diff}")?;
            }
        }
        Ok(out.flush()?)
    }
}

fn run_trace(
    arguments: &Arguments,
    loaded: &Loaded,
    text: &str,
    (train, test): (&Log, Option<&Log>),
    stages: &Stages,
) -> anyhow::Result<Outcome> {
    let name = loaded.path.display().to_string();
    let request = Request {
        model_name: &name,
        model_text: text,
        library: &loaded.library,
        parameters: loaded.overrides(),
        train,
        test,
        hold: arguments.hold.map(|hold| match hold {
            HoldArgument::Linear => Hold::Linear,
            HoldArgument::Previous => Hold::Previous,
        }),
        horizon: arguments.horizon,
        seed: arguments.seed,
        trust_columns: arguments.trust_columns,
        progress: stages,
    };
    trace(&request).map_err(|error| match error {
        TraceError::Model(report) => Mistake::from(*report).into(),
        other => Mistake::new(other.to_string()).into(),
    })
}
