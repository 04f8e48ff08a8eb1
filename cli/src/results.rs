//! Where what was found goes beside the terminal: a report's folder, and the model's own file.

use crate::folder::Folder;
use crate::mistake::Mistake;
use crate::model::Loaded;
use crate::output;
use crate::revision::Revision;
use std::path::Path;

/// The files that were asked for, checked before time is spent on what could not be written
/// afterwards.
pub struct Results<'a> {
    folder: Option<Folder<'a>>,
    revision: Option<Revision<'a>>,
}

/// What became of them.
pub struct Written {
    reported: anyhow::Result<()>,
    applied: Result<bool, Mistake>,
}

impl<'a> Results<'a> {
    /// With `apply` the file `path` of a model, and the folder of a `report`, if there is to be one.
    ///
    /// # Errors
    /// If one of them could not be written.
    pub fn prepare(
        loaded: &'a Loaded,
        path: &'a Path,
        apply: bool,
        report: Option<&'a Path>,
    ) -> Result<Self, Mistake> {
        let revision = apply.then(|| Revision::of(loaded, path)).transpose()?;
        let folder = report.map(|folder| Folder::at(folder, path)).transpose()?;
        Ok(Self { folder, revision })
    }

    /// Writes the report, and the model if it is `changed`. What goes wrong waits for
    /// [`Written::finish`]: what was found is told first, whatever becomes of the files.
    pub fn write(
        &self,
        report: impl FnOnce(&Folder<'_>) -> anyhow::Result<()>,
        changed: Option<&str>,
    ) -> Written {
        Written {
            reported: self.folder.as_ref().map_or(Ok(()), report),
            applied: match self.revision.as_ref().zip(changed) {
                Some((revision, text)) => revision.write(text).map(|()| true),
                None => Ok(false),
            },
        }
    }
}

impl Written {
    /// Whether the model's file has the change.
    pub fn is_applied(&self) -> bool {
        matches!(self.applied, Ok(true))
    }

    /// # Errors
    /// If something could not be written; of two such, the second is told here.
    pub fn finish(self) -> anyhow::Result<()> {
        match (self.reported, self.applied) {
            (Err(first), Err(second)) => {
                output::explain(&second);
                Err(first)
            }
            (reported, applied) => reported.and(applied.map(drop).map_err(Into::into)),
        }
    }
}
