//! `dynamics fit`: inertias, friction and couplings of a machine whose forces were measured.

use crate::command_line::command;
use crate::folder::{self, Folder};
use crate::log::LogArguments;
use crate::mistake::Mistake;
use crate::model::{Loaded, ModelArguments};
use crate::output;
use crate::results::Results;
use clap::{Args, ValueEnum};
use dynamics_codegen::diagnostic::visible;
use identify::fit::{
    Comparison, Fit, FitError, Inertia, Request, Settings, Source, Unwritable, compare,
    comparison_page, fit, page, written,
};
use identify::report::{self, FitPage, Portable, fit_html, portable};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Instant;

/// Arguments of `fit`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics fit arm.urdf log.csv.gz
  dynamics fit arm.model train.csv --test test.csv --apply --report out
  dynamics fit arm.urdf train.csv --test test.csv --inertia fixed --json
  dynamics fit arm.urdf train.csv --test test.csv --compare
  dynamics fit arm.urdf run1.csv run2.csv --test run3.csv --test run4.csv

Without --test the last third of the log is kept apart and judged by. What is looked for: friction,
rotors and constant forces in every joint, couplings of neighbouring joints, one payload, and other
inertias. Losses that the model states compete: they may be set to what the log says, down to zero.
A term is taken in if it predicts blocks of the log that it was not fitted to, and no joint's error
on them rises beyond chance. With a robot description as the model, --apply writes a new model
beside it.")]
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
    #[arg(long, value_enum, value_name = "HOW", default_value = "consistent")]
    inertia: InertiaArgument,

    /// Learn nothing from the effort of this coordinate; again for each of several
    #[arg(long, value_name = "COORDINATE")]
    leave_out: Vec<String>,

    /// Learn from efforts although they look like no forces of their joints
    #[arg(long)]
    trust_columns: bool,

    /// Write what was found into the model file
    #[arg(long)]
    apply: bool,

    /// A folder for the report (`report.html`, `report.json`, `series.json`, `summary.txt`,
    /// `model.diff`, the model with what was found and the files that it names); made if it is not
    /// there
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,

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
    /// Linear regression, near the model's where the log is silent; of no use in a model
    Linear,
    /// Only numbers that a rigid body can have
    Consistent,
}

/// Runs the command.
///
/// # Errors
/// If model and log cannot be used together, or the results not be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.inertia == InertiaArgument::Linear
        && (arguments.apply || arguments.report.is_some())
    {
        let message =
            "inertias by linear regression may be those of no body: no model is written with them";
        let help = "leave out `--inertia linear`, or say `--inertia fixed`";
        return Err(Mistake::new(message).help(help).into());
    }
    let loaded = arguments.model.load()?;
    let (text, path) = loaded.text();
    let report = arguments.report.as_deref();
    let results = Results::prepare(&loaded, &path, arguments.apply, report)?;
    let model = &loaded.compiled.model;
    let columns = &arguments.columns;
    let (train, test) = columns.read_both(&arguments.log, &arguments.test, model)?;
    let name = path.display().to_string();
    let request = Request {
        source: Source {
            name: &name,
            text: &text,
            library: &loaded.library,
        },
        compiled: &loaded.compiled,
        parameters: &loaded.parameters,
        train: &train,
        test: test.as_ref(),
        inertia: match arguments.inertia {
            InertiaArgument::Fixed => Inertia::Fixed,
            InertiaArgument::Linear => Inertia::Linear,
            InertiaArgument::Consistent => Inertia::Consistent,
        },
        leave_out: &arguments.leave_out,
        trust_columns: arguments.trust_columns,
    };
    let mut found = find(arguments, &request)?;
    let change = found
        .fit
        .as_mut()
        .map(|fit| Change::new(fit, &request, &loaded, &path));
    let change = change.transpose()?;
    let report = |folder: &Folder<'_>| match (&found.fit, &change) {
        (Some(fit), Some(change)) => change.report(folder, fit, &found, &request),
        _ => Ok(()),
    };
    let changed = change.as_ref().filter(|change| !change.diff.is_empty());
    let written = results.write(report, changed.map(|change| change.text.as_str()));
    found.tell(arguments.json, change.as_ref(), written.is_applied())?;
    written.finish()
}

fn find(arguments: &Arguments, request: &Request<'_>) -> Result<Found, Mistake> {
    let mistake = |error: FitError| Mistake::new(error.to_string());
    if !arguments.compare {
        return Ok(Found {
            fit: Some(fit(request).map_err(mistake)?),
            comparison: None,
        });
    }
    let settings = Settings {
        points: arguments.points.map(|points| points as usize),
        seed: arguments.seed,
        clock: Some(seconds),
    };
    let (fit, comparison) = compare(request, &settings).map_err(mistake)?;
    Ok(Found {
        fit,
        comparison: Some(comparison),
    })
}

/// Seconds since it was first asked.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// What is printed.
#[derive(Debug, Serialize)]
pub struct Found {
    /// What was found, if the model has inputs.
    #[serde(flatten)]
    pub fit: Option<Fit>,
    /// What `--compare` adds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Comparison>,
}

impl Found {
    /// For people.
    pub fn summary(&self) -> String {
        let pages = [
            self.fit.as_ref().map(page),
            self.comparison.as_ref().map(comparison_page),
        ];
        let pages: Vec<String> = pages.into_iter().flatten().collect();
        pages.join("\n")
    }

    fn tell(&self, json: bool, change: Option<&Change<'_>>, applied: bool) -> anyhow::Result<()> {
        for warning in self.fit.iter().flat_map(|fit| &fit.warnings) {
            output::complain(&format!("warning: {warning}"));
        }
        let mut out = output::stdout();
        if json {
            serde_json::to_writer_pretty(&mut out, self)?;
            writeln!(out)?;
        } else {
            out.write_all(self.summary().as_bytes())?;
            if let Some(Change { name, diff, .. }) = change.filter(|c| !c.diff.is_empty()) {
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

/// The model with what was found.
#[derive(Debug)]
pub struct Change<'a> {
    loaded: &'a Loaded,
    /// Where it belongs.
    path: &'a Path,
    /// The same, as it is shown.
    name: String,
    /// The model with it.
    pub text: String,
    /// Against what stands there; empty if nothing changes.
    pub diff: String,
}

impl<'a> Change<'a> {
    /// Of a fit; why nothing is written is one of its warnings.
    ///
    /// # Errors
    /// If the changed model does not compile.
    pub fn new(
        fit: &mut Fit,
        request: &Request<'_>,
        loaded: &'a Loaded,
        path: &'a Path,
    ) -> anyhow::Result<Self> {
        let Source { name, text, .. } = request.source;
        let changed = match written(fit, request) {
            Ok(changed) => changed,
            Err(Unwritable::Model(report)) => {
                anyhow::bail!("the model with what was found does not compile:\n{report}")
            }
            Err(refusal) => {
                fit.warnings.push(refusal.to_string());
                text.to_string()
            }
        };
        let original = match loaded.is_robot_description() {
            true => "",
            false => text,
        };
        let diff = match changed == text {
            true => String::new(),
            false => report::diff(name, original, &changed),
        };
        Ok(Self {
            loaded,
            path,
            name: name.to_string(),
            text: changed,
            diff,
        })
    }

    /// The model with what was found and the files that it names, and the page of the report;
    /// `command` is what was called.
    ///
    /// # Errors
    /// If a figure cannot be drawn.
    pub fn html(
        &self,
        fit: &Fit,
        request: &Request<'_>,
        command: &str,
    ) -> anyhow::Result<(Portable, String)> {
        let Loaded {
            compiled, library, ..
        } = self.loaded;
        let portable = portable(&self.text, compiled, library);
        let reading = folder::reading(&portable, self.path);
        let html = fit_html(&FitPage {
            fit,
            model: &compiled.model,
            file: &self.name,
            log: &request.train.path.display().to_string(),
            diff: &self.diff,
            reading: reading.as_deref(),
            command,
        })?;
        Ok((portable, html))
    }

    fn report(
        &self,
        folder: &Folder<'_>,
        fit: &Fit,
        found: &Found,
        request: &Request<'_>,
    ) -> anyhow::Result<()> {
        let (portable, html) = self.html(fit, request, &command(None))?;
        let summary = found.summary();
        let texts = [
            &html,
            &serde_json::to_string_pretty(found)?,
            &serde_json::to_string(&fit.curves)?,
            &*visible(&summary),
            &self.diff,
        ];
        Ok(folder.write(texts, &[], &portable)?)
    }
}
