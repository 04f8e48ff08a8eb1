//! `--report DIR`: the folder with all that a trace has to say.

use crate::mistake::Mistake;
use crate::whole_file::{WholeFile, make_folder};
use dynamics_codegen::diagnostic::visible;
use identify::report::{self, EFFECTS, Page, Portable};
use std::path::{Path, PathBuf};

/// The files that every report has, beside the model.
const FILES: [&str; 5] = [
    "report.html",
    "report.json",
    "series.json",
    "summary.txt",
    "model.diff",
];

/// A folder for a report, checked before the work begins.
#[derive(Debug)]
pub struct Folder<'a> {
    path: &'a Path,
    /// The model's file in it.
    model: PathBuf,
}

/// What goes into it.
#[derive(Debug, Clone, Copy)]
pub struct Contents<'a> {
    /// The page.
    pub page: Page<'a>,
    /// The outcome as JSON.
    pub json: &'a str,
    /// The summary.
    pub summary: &'a str,
    /// The model with the findings.
    pub portable: &'a Portable,
}

impl<'a> Folder<'a> {
    /// The folder `path`, made if it is not there, for a report about the model file `model`.
    ///
    /// # Errors
    /// If it cannot be made, or a file of the report not be written into it.
    pub fn at(path: &'a Path, model: &Path) -> Result<Self, Mistake> {
        make_folder(path)?;
        let model = model.file_name().unwrap_or("patched.model".as_ref());
        let model = path.join(model);
        let mut files = FILES.map(|name| path.join(name)).into_iter();
        files.try_for_each(|file| WholeFile::check(&file))?;
        WholeFile::check(&model)?;
        Ok(Self { path, model })
    }

    /// Writes the report.
    ///
    /// # Errors
    /// If there is no room, or the page cannot be made.
    pub fn write(&self, contents: &Contents<'_>) -> anyhow::Result<()> {
        let Contents {
            page,
            json,
            summary,
            portable,
        } = contents;
        let write = |name: &str, text: &str| WholeFile::write(&self.path.join(name), text);
        let outcome = page.outcome;
        write("report.json", json)?;
        write("summary.txt", &visible(summary))?;
        write("model.diff", page.diff)?;
        write("series.json", &serde_json::to_string(&outcome.details)?)?;
        for force in outcome.unnamed.iter().flat_map(|unnamed| &unnamed.forces) {
            let name = format!("force_{}.gp.json", file_safe(&force.coordinate));
            write(&name, &force.saved)?;
        }
        write("report.html", &report::html(page)?)?;
        for (name, text) in &portable.files {
            let path = self.path.join(name);
            path.parent().map_or(Ok(()), make_folder)?;
            WholeFile::write(&path, text)?;
        }
        Ok(WholeFile::write(&self.model, &portable.model)?)
    }
}

/// How the model of a report is read, from the report's folder, if it takes more than its name.
pub fn reading(portable: &Portable, model: &Path) -> Option<String> {
    let name = model.file_name()?.to_string_lossy();
    (!portable.effects.is_empty()).then(|| {
        format!(
            "dynamics check {} --effects {EFFECTS}",
            super::quoted(&name)
        )
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
