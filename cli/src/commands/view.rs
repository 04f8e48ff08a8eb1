//! `dynamics view`: a page on which a model moves as a log says.

use crate::command_line;
use crate::log::LogArguments;
use crate::mistake::Mistake;
use crate::model::ModelArguments;
use crate::output;
use crate::view::{Frames, Scene, charts, page};
use crate::whole_file::WholeFile;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `view`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics view models/cartpole.model log.csv --out cartpole.html
  dynamics view models/panda.urdf move.mcap --map move.toml --out move.html")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log: the positions of all coordinates over time (docs/log-format.md)
    #[arg(value_name = "LOG")]
    log: PathBuf,

    #[command(flatten)]
    columns: LogArguments,

    /// Where the page goes
    #[arg(long, value_name = "PAGE.html")]
    out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// If the model has no bodies, or the model or the log is faulty.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    WholeFile::check(&arguments.out)?;
    let mut loaded = arguments.model.load()?;
    let Some(scene) = Scene::new(&mut loaded.compiled.model, &loaded.parameters) else {
        let message = format!("`{}` has no bodies to look at", loaded.path.display());
        let help = "a model that is written by its energies has no shape; say where its masses are by `body` statements";
        return Err(Mistake::new(message).help(help).into());
    };
    let model = &loaded.compiled.model;
    let (log, record) = arguments
        .columns
        .positions(&arguments.log, model, &output::complain)?;
    let frames = Frames::of(&record.t);
    let q: Vec<Vec<f64>> = record.q.iter().map(|column| frames.at(column)).collect();
    let columns = frames.arguments(&q, model, &loaded.parameters);
    let poses = scene.poses(&columns, frames.times.len());
    let title = format!("{} as in {}", model.name, arguments.log.display());
    let charts = charts(model, &log, &record, &frames);
    let command = command_line::command(None);
    let text = page(&title, &scene, &frames, &poses, &charts, &command)?;
    WholeFile::write(&arguments.out, &text)?;
    Ok(())
}
