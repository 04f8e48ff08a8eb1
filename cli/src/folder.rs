//! `--report DIR`: the folder with all that a command has to say of a model.

use crate::command_line::quoted;
use crate::mistake::Mistake;
use crate::whole_file::{WholeFile, make_folder};
use identify::report::{EFFECTS, Portable};
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

impl<'a> Folder<'a> {
    /// The folder `path`, made if it is not there, for a report about the model file `model`.
    ///
    /// # Errors
    /// If it cannot be made, or a file of the report not be written into it.
    pub fn at(path: &'a Path, model: &Path) -> Result<Self, Mistake> {
        make_folder(path)?;
        let model = model.file_name().unwrap_or("patched.model".as_ref());
        let model = path.join(model);
        let mut files = FILES.iter().map(|name| path.join(name));
        files.try_for_each(|file| WholeFile::check(&file))?;
        WholeFile::check(&model)?;
        Ok(Self { path, model })
    }

    /// Writes a report: the page, what was found and the curves as JSON, the summary and the change to
    /// the model, `more` files by their names, then the model with what it names.
    ///
    /// # Errors
    /// If there is no room.
    pub fn write(
        &self,
        texts: [&str; FILES.len()],
        more: &[(String, &str)],
        portable: &Portable,
    ) -> Result<(), Mistake> {
        let more = more.iter().map(|(name, text)| (name.as_str(), *text));
        for (name, text) in FILES.into_iter().zip(texts).chain(more) {
            WholeFile::write(&self.path.join(name), text)?;
        }
        for (name, text) in &portable.files {
            let path = self.path.join(name);
            path.parent().map_or(Ok(()), make_folder)?;
            WholeFile::write(&path, text)?;
        }
        WholeFile::write(&self.model, &portable.model)
    }
}

/// How the model of a report is read, from the report's folder, if it takes more than its name.
pub fn reading(portable: &Portable, model: &Path) -> Option<String> {
    let name = model.file_name()?.to_string_lossy();
    (!portable.effects.is_empty())
        .then(|| format!("dynamics check {} --effects {EFFECTS}", quoted(&name)))
}

/// A name as part of a file's name.
pub fn file_safe(name: &str) -> String {
    let safe = |c: char| {
        if c.is_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    name.chars().map(safe).collect()
}
