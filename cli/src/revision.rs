//! `--apply`: the findings in the model's own file.

use crate::mistake::Mistake;
use crate::model::Loaded;
use crate::whole_file::WholeFile;
use std::path::Path;

/// The file that findings are written into, checked before the work begins.
#[derive(Debug, Clone, Copy)]
pub struct Revision<'a> {
    path: &'a Path,
    /// What stood there when the model was read; nothing where there is to be a new file.
    read: Option<&'a [u8]>,
}

impl<'a> Revision<'a> {
    /// Into the file `path` of a model; that of a robot description is new.
    ///
    /// # Errors
    /// If it may not be written to, or a file is in the way of a new one.
    pub fn of(loaded: &'a Loaded, path: &'a Path) -> Result<Self, Mistake> {
        let is_new = loaded.is_robot_description();
        if is_new && path.exists() {
            let message = format!(
                "`--apply` would write a new model `{}`, which exists already",
                path.display()
            );
            return Err(Mistake::new(message).help("give that model, or move it away"));
        }
        WholeFile::check(path)?;
        let read = (!is_new).then_some(loaded.bytes.as_slice());
        Ok(Self { path, read })
    }

    /// Writes the revised model, unless its file has been changed in the meantime.
    ///
    /// # Errors
    /// If it has, or cannot be written.
    pub fn write(&self, revised: &str) -> Result<(), Mistake> {
        let mut file = WholeFile::create(self.path)?;
        file.write_all(revised.as_bytes())?;
        let outcome = match self.read {
            Some(read) => file.replace(read),
            None => file.finish_new(),
        };
        let help = "what was found is in the patch: put it in by hand, or run the command again";
        outcome.map_err(|mistake| mistake.help(help))
    }
}
