//! Logs, with the maps that say what their columns are.

use crate::mistake::Mistake;
use crate::output;
use clap::Args;
use dynamics_codegen::Model;
use dynamics_codegen::syntax::written_name;
use dynamics_codegen::tree::Joint;
use identify::log::{Axis, Gauge, Log, LogError, Map, Record, Seen, Wanted, template};
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
    /// Reads the logs to learn from and, if there are any, those to judge by. Several of a kind
    /// become one, one recording after the other. What should be known of it is printed.
    ///
    /// # Errors
    /// What is wrong with a log or its map; if recordings do not fit each other, if one is given twice, or
    /// `--map` puts the same file beside several logs.
    pub fn read_both(
        &self,
        train: &[PathBuf],
        test: &[PathBuf],
        model: &Model,
    ) -> Result<(Log, Option<Log>), Mistake> {
        self.read_telling(train, test, model, &output::complain)
    }

    /// As [`read_both`](Self::read_both), with what should be known told to `tell`.
    ///
    /// # Errors
    /// As there.
    pub fn read_telling(
        &self,
        train: &[PathBuf],
        test: &[PathBuf],
        model: &Model,
        tell: &dyn Fn(&str),
    ) -> Result<(Log, Option<Log>), Mistake> {
        self.check(train, test)?;
        let learnt = self.read_all(train, model, tell)?;
        let learnt = learnt.ok_or_else(|| Mistake::new("there is no log to learn from"))?;
        Ok((learnt, self.read_all(test, model, tell)?))
    }

    /// What can be said of the files before any of them is read.
    ///
    /// # Errors
    /// If one is given twice, or `--map` puts the same file beside several logs.
    pub fn check(&self, train: &[PathBuf], test: &[PathBuf]) -> Result<(), Mistake> {
        for paths in [train, test] {
            for (k, path) in paths.iter().enumerate() {
                if paths[..k].contains(path) {
                    let message = format!("`{}` is given twice", path.display());
                    return Err(Mistake::new(message).help("give each recording once"));
                }
            }
        }
        let all = train.len() + test.len();
        let Some(path) = self.map.as_ref().filter(|_| all > 1) else {
            return Ok(());
        };
        let map = Map::read(path).map_err(|error| Mistake::new(error.to_string()))?;
        match map.beside_all() {
            None => Ok(()),
            Some(file) => {
                let message = format!(
                    "`{}` holds for {all} logs and puts the one file `{file}` beside all of them",
                    path.display()
                );
                let help = format!(
                    "write `{{log}}` for a log's own name: `beside = [\"{{log}}-{file}\"]`"
                );
                Err(Mistake::new(message).help(help))
            }
        }
    }

    fn read_all(
        &self,
        paths: &[PathBuf],
        model: &Model,
        tell: &dyn Fn(&str),
    ) -> Result<Option<Log>, Mistake> {
        let mut whole: Option<Log> = None;
        for path in paths {
            let log = self.read(path, model, tell)?;
            match &mut whole {
                None => whole = Some(log),
                Some(whole) => whole
                    .follow(log)
                    .map_err(|error| Mistake::new(error.to_string()))?,
            }
        }
        Ok(whole)
    }

    /// Reads a log that is to have the channels of a model.
    ///
    /// # Errors
    /// What is wrong with the log or its map. If columns are missing, with a map to start
    /// from.
    pub fn read(&self, path: &Path, model: &Model, tell: &dyn Fn(&str)) -> Result<Log, Mistake> {
        let map = self.map_of(path, tell)?;
        let wanted = wanted(model);
        let log = wanted.read(path, map.as_ref());
        log.map_err(|error| refusal(&error, path, &map, &wanted, model))
    }

    /// Reads a log for the positions of a model's coordinates; inputs may be missing.
    ///
    /// # Errors
    /// As [`LogArguments::read`].
    pub fn positions(
        &self,
        path: &Path,
        model: &Model,
        tell: &dyn Fn(&str),
    ) -> Result<(Log, Record), Mistake> {
        let map = self.map_of(path, tell)?;
        let wanted = Wanted {
            inputs: Vec::new(),
            gauges: Vec::new(),
            ..wanted(model)
        };
        let names: Vec<String> = model.positions().into_iter().map(|p| p.name).collect();
        let read = wanted.read(path, map.as_ref());
        let read = read.and_then(|log| log.select(&names, &[]).map(|record| (log, record)));
        read.map_err(|error| refusal(&error, path, &map, &wanted, model))
    }

    /// A log of columns that are no file; `name` is what messages call it.
    ///
    /// # Errors
    /// As [`LogArguments::read`].
    pub fn take(
        &self,
        name: &Path,
        columns: Vec<(String, Vec<f64>)>,
        model: &Model,
    ) -> Result<Log, Mistake> {
        let read = |path: &PathBuf| Map::read(path);
        let map = self.map.as_ref().map(read).transpose();
        let map = map.map_err(|error| Mistake::new(error.to_string()))?;
        let wanted = wanted(model);
        let log = Log::from_columns(name, columns, map.as_ref());
        wanted
            .accept(log, map.as_ref())
            .map_err(|error| refusal(&error, name, &map, &wanted, model))
    }

    /// The map of a log, and word of it if nobody asked.
    fn map_of(&self, log: &Path, tell: &dyn Fn(&str)) -> Result<Option<Map>, Mistake> {
        let beside = Map::beside(log);
        let path = match &self.map {
            Some(path) => path,
            None if beside.is_file() => {
                let (log, map) = (log.display(), beside.display());
                tell(&format!(
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

/// Why a log cannot be used, with what to write if it lacks columns.
fn refusal(
    error: &LogError,
    path: &Path,
    map: &Option<Map>,
    wanted: &Wanted,
    model: &Model,
) -> Mistake {
    let mistake = Mistake::new(error.to_string());
    let Some(columns) = error.columns() else {
        return mistake;
    };
    let start = start(path, map, columns, wanted);
    match lockable(model, columns) {
        Some(locks) => mistake.help(locks).help(start),
        None => mistake.help(start),
    }
}

/// The channels of a model. A robot description has a motor at every joint; a log need not.
fn wanted(model: &Model) -> Wanted {
    let positions = model.positions().into_iter().map(|position| Axis {
        name: position.name,
        unit: position.unit,
        assumed: false,
    });
    let inputs = model.inputs.iter().map(|input| Axis {
        name: input.name.clone(),
        unit: input.unit.clone(),
        assumed: input.assumed,
    });
    Wanted {
        coordinates: positions.collect(),
        inputs: inputs.collect(),
        gauges: Gauge::of(model),
    }
}

/// How a model is written whose robot description has joints that the log lacks, if there are
/// some and not all: a gripper, the torso under an arm.
fn lockable(model: &Model, columns: &[Seen]) -> Option<String> {
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
    let absent = |name: &str| {
        let column = format!("q_{name}");
        !columns.iter().any(|seen| seen.name == column)
    };
    let coordinates = model.coordinates.iter().enumerate();
    let lacking = coordinates.filter(|(index, c)| is_joint(*index) && absent(&c.name));
    let lacking: Vec<String> = lacking.map(|(_, c)| written_name(&c.name)).collect();
    let some = !lacking.is_empty() && lacking.len() < model.coordinates.len();
    some.then(|| {
        // From the folder of the model: that of the description, if there is no model yet.
        let file = Path::new(&robot.file).file_name().unwrap_or_default();
        let (file, joints) = (file.to_string_lossy(), lacking.join(", "));
        let word = robot.format.word();
        format!(
            "if joints stood still, lock them in a model, each where it stood (`{} = 0.3`, if not \
             at zero): `{word} {file:?} {{ lock: {joints}; }}`",
            lacking[0]
        )
    })
}

/// What to write where, for a log that lacks columns.
fn start(path: &Path, map: &Option<Map>, columns: &[Seen], wanted: &Wanted) -> String {
    let file = map
        .as_ref()
        .map_or_else(|| Map::beside(path), |map| map.path.clone());
    let what = if map.is_some() { "correct" } else { "write" };
    format!(
        "{what} `{}` to say what the columns are, starting from this:\n\n{}",
        file.display(),
        template(columns, wanted)
    )
}
