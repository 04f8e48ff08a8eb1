//! `dynamics trace`: what a log says that the model lacks.

use crate::log::LogArguments;
use crate::mistake::Mistake;
use crate::model::{Loaded, ModelArguments};
use crate::output::{self, WholeFile};
use crate::stages::Stages;
use clap::{Args, ValueEnum};
use identify::log::Log;
use identify::regression::Hold;
use identify::report::{self, Page};
use identify::trace::{Outcome, Request, TraceError, trace};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `trace`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics trace models/pendulum2.model train.csv --test test.csv
  dynamics trace arm.model log.csv.gz --parameters arm7.json --report out --json
  dynamics trace arm.model log.csv --apply

Without --test the last third of the log is kept apart and judged by.")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log to learn from: CSV, plain or gzipped, with columns `t`, `q_<coordinate>`,
    /// `u_<input>` and, if measured, `dq_<coordinate>` and `ddq_<coordinate>`, or with a map
    #[arg(value_name = "TRAIN.csv")]
    train: PathBuf,

    /// A second log of the same machine, to judge by
    #[arg(long, value_name = "TEST.csv")]
    test: Option<PathBuf>,

    #[command(flatten)]
    log: LogArguments,

    /// Write what was found into the model file
    #[arg(long)]
    apply: bool,

    /// A folder for the report (`report.html`, `report.json`, `series.json`, `summary.txt`,
    /// `model.diff`, the model with the findings, forces without a name as processes); made if it is not there
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
    let loaded = arguments.model.load()?;
    let model = &loaded.compiled.model;
    let train = arguments.log.read(&arguments.train, model)?;
    let test = arguments
        .test
        .as_deref()
        .map(|path| arguments.log.read(path, model));
    let test = test.transpose()?;
    let (text, path) = loaded.text();
    if arguments.apply && loaded.is_robot_description() && path.exists() {
        let message = format!(
            "`--apply` would write a new model `{}`, which exists already",
            path.display()
        );
        let help = "trace that model, or move it away";
        return Err(Mistake::new(message).help(help).into());
    }
    let stages = Stages::new();
    let outcome = run_trace(arguments, &loaded, &text, (&train, test.as_ref()), &stages);
    let took = stages.finish();
    let outcome = outcome?;
    for warning in &outcome.warnings {
        output::complain(&format!("warning: {warning}"));
    }
    let name = path.display().to_string();
    let original = if loaded.is_robot_description() {
        ""
    } else {
        &text
    };
    let diff = if outcome.patched_model == text {
        String::new()
    } else {
        report::diff(&name, original, &outcome.patched_model)
    };
    let json = serde_json::to_string_pretty(&outcome)?;
    let summary = report::summary(&outcome, &loaded.compiled.model);
    if let Some(folder) = &arguments.report {
        fs::create_dir_all(folder).map_err(|error| Mistake::unreadable(folder, &error))?;
        let model = path.file_name().unwrap_or("patched.model".as_ref());
        write(&folder.join("report.json"), &json)?;
        write(&folder.join("summary.txt"), &summary)?;
        write(&folder.join("model.diff"), &diff)?;
        let series = serde_json::to_string(&outcome.details)?;
        write(&folder.join("series.json"), &series)?;
        for force in outcome.unnamed.iter().flat_map(|unnamed| &unnamed.forces) {
            let file = format!("force_{}.gp.json", file_safe(&force.coordinate));
            write(&folder.join(file), &force.saved)?;
        }
        let page = Page {
            outcome: &outcome,
            model: &loaded.compiled.model,
            file: &name,
            diff: &diff,
            command: &command(arguments.seed),
        };
        write(&folder.join("report.html"), &report::html(&page)?)?;
        write(&folder.join(model), &outcome.patched_model)?;
    }
    if arguments.apply && !outcome.findings.is_empty() {
        write(&path, &outcome.patched_model)?;
    }
    let mut out = output::stdout();
    if arguments.json {
        writeln!(out, "{json}")?;
        output::complain(&format!("Took {took}"));
    } else {
        write!(out, "{summary}\nTook {took}\n")?;
        if !diff.is_empty() {
            let applied = if arguments.apply {
                "Written into"
            } else {
                "Patch (--apply writes it) for"
            };
            writeln!(out, "\n{applied} {name}:\n\n{diff}")?;
        }
    }
    Ok(out.flush()?)
}

fn run_trace(
    arguments: &Arguments,
    loaded: &Loaded,
    text: &str,
    (train, test): (&Log, Option<&Log>),
    stages: &Stages,
) -> anyhow::Result<Outcome> {
    let named = loaded
        .compiled
        .model
        .parameters
        .iter()
        .zip(&loaded.parameters);
    let parameters: BTreeMap<String, f64> = named
        .filter(|(parameter, value)| parameter.nominal != **value)
        .map(|(parameter, &value)| (parameter.name.clone(), value))
        .collect();
    let name = loaded.path.display().to_string();
    let request = Request {
        model_name: &name,
        model_text: text,
        library: &loaded.library,
        parameters,
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

/// A name as part of a file's name.
fn file_safe(name: &str) -> String {
    let safe = |c: char| {
        if c.is_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    name.chars().map(safe).collect()
}

/// The command line as a shell reads it, with the seed.
fn command(seed: u64) -> String {
    let given: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let seeded = given
        .iter()
        .any(|word| word == "--seed" || word.starts_with("--seed="));
    let mut line = "dynamics".to_string();
    for word in &given {
        line.push(' ');
        line.push_str(&quoted(word));
    }
    if !seeded {
        line.push_str(&format!(" --seed {seed}"));
    }
    line
}

/// A word for a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Writes a file whole or not at all.
fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(text.as_bytes())?;
    file.finish()
}
