//! What a trace or a fit has found: texts, and what is written with them.

use crate::error::{mistaken, raised};
use crate::terms::Equations;
use cli::folder::Folder;
use cli::revision::Revision;
use cli::whole_file::WholeFile;
use dynamics_codegen::diagnostic::visible;
use identify::report::Portable;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Everything that was found, as text.
#[pyclass(frozen, module = "dynamics._native")]
pub struct Report {
    /// What the command line prints with `--json`.
    #[pyo3(get)]
    pub json: String,
    /// Curves, as JSON.
    #[pyo3(get)]
    pub series: String,
    /// What the command line prints without `--json`.
    #[pyo3(get)]
    pub summary: String,
    /// The change to the model's file; empty if nothing changes.
    #[pyo3(get)]
    pub diff: String,
    /// The page with figures.
    #[pyo3(get)]
    pub html: String,
    /// The model with what was found.
    #[pyo3(get)]
    pub text: String,
    /// Files beside these: their names and texts.
    pub more: Vec<(String, String)>,
    /// The model with what was found, and the files that it names.
    pub portable: Portable,
    /// What the model was before.
    pub equations: Arc<Equations>,
}

#[pymethods]
impl Report {
    /// Writes the model with what was found, and says whether there was something to write: into
    /// the model's own file if it is still as it was read (beside a robot description a new one),
    /// or into another.
    #[pyo3(signature = (path=None))]
    fn apply(&self, path: Option<PathBuf>) -> PyResult<bool> {
        if self.diff.is_empty() {
            return Ok(false);
        }
        let loaded = &self.equations.loaded;
        let (_, own) = loaded.text();
        let written = match path {
            Some(path) if path != own => WholeFile::write(&path, &self.text),
            _ => Revision::of(loaded, &own).and_then(|revision| revision.write(&self.text)),
        };
        written.map(|()| true).map_err(|mistake| mistaken(&mistake))
    }

    /// Writes the folder that `--report` writes.
    fn write(&self, folder: PathBuf) -> PyResult<()> {
        let (_, own) = self.equations.loaded.text();
        let texts = [
            &*self.html,
            &self.json,
            &self.series,
            &visible(&self.summary),
            &self.diff,
        ];
        let more: Vec<(String, &str)> = self
            .more
            .iter()
            .map(|(name, text)| (name.clone(), text.as_str()))
            .collect();
        Folder::at(&folder, &own)
            .and_then(|folder| folder.write(texts, &more, &self.portable))
            .map_err(|mistake| raised(&mistake.into()))
    }
}
