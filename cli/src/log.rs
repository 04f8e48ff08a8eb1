//! Logs, with the maps that say what their columns are.

use crate::mistake::Mistake;
use crate::output;
use clap::Args;
use dynamics_codegen::Model;
use dynamics_codegen::syntax::written_name;
use dynamics_codegen::tree::Joint;
use identify::log::{Log, LogError, Map, template};
use std::path::{Path, PathBuf};

/// The arguments of every command that reads logs.
#[derive(Debug, Clone, Args)]
pub struct LogArguments {
    /// What the columns of the logs are: names, units, signs, offsets, gears; without it
    /// LOG.toml beside a log, if that is there (docs/log-format.md)
    #[arg(long, value_name = "FILE.toml")]
    pub map: Option<PathBuf>,
}

impl LogArguments {
    /// Reads a log that is to have the channels of a model.
    ///
    /// # Errors
    /// What is wrong with the log or its map. If columns are missing, with a map to start
    /// from.
    pub fn read(&self, path: &Path, model: &Model) -> Result<Log, Mistake> {
        let map = self.map_of(path)?;
        let names = |names: Vec<&String>| names.into_iter().cloned().collect::<Vec<String>>();
        let coordinates = names(model.coordinates.iter().map(|c| &c.name).collect());
        let inputs = names(model.inputs.iter().map(|u| &u.name).collect());
        let explained = |error: LogError| {
            let mistake = Mistake::new(error.to_string());
            match error.columns() {
                None => mistake,
                Some(columns) => {
                    let start = start(path, &map, columns, &coordinates, &inputs);
                    match lockable(model, columns) {
                        Some(locks) => mistake.help(locks).help(start),
                        None => mistake.help(start),
                    }
                }
            }
        };
        let mut log = Log::read_with(path, map.as_ref()).map_err(explained)?;
        if map.is_none() {
            log.name_by_number(&coordinates, &inputs);
        }
        // A robot description has a motor at every joint; a log need not.
        let assumed = model.inputs.iter().filter(|input| input.assumed);
        log.assume_no_input(assumed.map(|input| input.name.as_str()));
        log.select(&coordinates, &inputs).map_err(explained)?;
        Ok(log)
    }

    /// The map of a log, and word of it if nobody asked.
    fn map_of(&self, log: &Path) -> Result<Option<Map>, Mistake> {
        let beside = Map::beside(log);
        let path = match &self.map {
            Some(path) => path,
            None if beside.is_file() => {
                let (log, map) = (log.display(), beside.display());
                output::complain(&format!(
                    "note: the columns of {log} are read as {map} says"
                ));
                &beside
            }
            None => return Ok(None),
        };
        let map = Map::read(path).map_err(|error| Mistake::new(error.to_string()))?;
        Ok(Some(map))
    }
}

/// How a model is written whose robot description has joints that the log lacks, if there are
/// some and not all: a gripper, the torso under an arm.
fn lockable(model: &Model, columns: &[String]) -> Option<String> {
    let robot = model.robot.as_ref()?;
    let is_joint = |index: usize| {
        let mut joints = model.tree.bodies.iter().map(|body| &body.joint);
        joints.any(|joint| match joint {
            Joint::Revolute { coordinate, .. } | Joint::Prismatic { coordinate, .. } => {
                coordinate.index == index
            }
            _ => false,
        })
    };
    let absent = |name: &str| !columns.contains(&format!("q_{name}"));
    let coordinates = model.coordinates.iter().enumerate();
    let lacking = coordinates.filter(|(index, c)| is_joint(*index) && absent(&c.name));
    let lacking: Vec<String> = lacking.map(|(_, c)| written_name(&c.name)).collect();
    let some = !lacking.is_empty() && lacking.len() < model.coordinates.len();
    some.then(|| {
        // From the folder of the model: that of the description, if there is no model yet.
        let file = Path::new(&robot.file).file_name().unwrap_or_default();
        let (file, joints) = (file.to_string_lossy(), lacking.join(", "));
        format!(
            "if joints stood still, lock them in a model, each where it stood (`{} = 0.3`, if not \
             at zero): `urdf {file:?} {{ lock: {joints}; }}`",
            lacking[0]
        )
    })
}

/// What to write where, for a log that lacks columns.
fn start(
    path: &Path,
    map: &Option<Map>,
    columns: &[String],
    coordinates: &[String],
    inputs: &[String],
) -> String {
    let file = map
        .as_ref()
        .map_or_else(|| Map::beside(path), |map| map.path.clone());
    let what = if map.is_some() { "correct" } else { "write" };
    format!(
        "{what} `{}` to say what the columns are, starting from this:\n\n{}",
        file.display(),
        template(columns, coordinates, inputs)
    )
}
