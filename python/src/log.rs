//! Logs as Python gives them: files, or columns that it has already.

use cli::log::LogArguments;
use cli::mistake::Mistake;
use dynamics_codegen::Model;
use identify::log::Log;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use std::path::PathBuf;

/// One recording.
pub enum Recording {
    /// A file.
    File(PathBuf),
    /// Columns, and what messages call them.
    Columns(PathBuf, Vec<(String, Vec<f64>)>),
}

impl<'py> FromPyObject<'_, 'py> for Recording {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        type Columns<'py> = Vec<(String, Bound<'py, PyArray1<f64>>)>;
        if let Ok((name, columns)) = value.extract::<(PathBuf, Columns<'_>)>() {
            let owned = columns
                .into_iter()
                .map(|(column, values)| Ok((column, values.try_readonly()?.as_array().to_vec())));
            return Ok(Self::Columns(name, owned.collect::<PyResult<_>>()?));
        }
        Ok(Self::File(value.extract()?))
    }
}

/// The logs to learn from and, if there are any, those to judge by.
pub struct Recordings {
    pub train: Vec<Recording>,
    pub test: Vec<Recording>,
    pub map: Option<PathBuf>,
}

impl Recordings {
    /// Reads them as the command line does. Several of a kind become one.
    ///
    /// # Errors
    /// What is wrong with one of them.
    pub fn read(self, model: &Model) -> Result<(Log, Option<Log>), Mistake> {
        let arguments = LogArguments { map: self.map };
        let files = |of: &[Recording]| -> Vec<PathBuf> {
            let file = |recording: &Recording| match recording {
                Recording::File(path) => Some(path.clone()),
                Recording::Columns(..) => None,
            };
            of.iter().filter_map(file).collect()
        };
        arguments.check(&files(&self.train), &files(&self.test))?;
        let train = join(self.train, &arguments, model)?;
        let train = train.ok_or_else(|| Mistake::new("there is no log to learn from"))?;
        Ok((train, join(self.test, &arguments, model)?))
    }
}

fn join(
    recordings: Vec<Recording>,
    arguments: &LogArguments,
    model: &Model,
) -> Result<Option<Log>, Mistake> {
    let mut whole: Option<Log> = None;
    for recording in recordings {
        let log = match recording {
            Recording::File(path) => arguments.read(&path, model, &|_| ())?,
            Recording::Columns(name, columns) => arguments.take(&name, columns, model)?,
        };
        match &mut whole {
            None => whole = Some(log),
            Some(whole) => {
                let joined = whole.follow(log);
                joined.map_err(|error| Mistake::new(error.to_string()))?;
            }
        }
    }
    Ok(whole)
}
