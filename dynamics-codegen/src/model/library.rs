//! The effects that a model may name: templates, one per file.

use crate::file::{self, Limit};
use crate::syntax;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a model may refer to: effect templates by name, and robot descriptions by
/// path. A user's own folder of templates takes part on equal terms with what is
/// built in, and wins over it.
#[derive(Debug, Clone, Default)]
pub struct Library {
    templates: BTreeMap<String, TemplateText>,
    folder: PathBuf,
    /// What paths are relative to where that is not the current folder.
    root: PathBuf,
    /// Texts that stand in for files, with the name shown in messages.
    files: BTreeMap<String, (String, String)>,
}

/// How large the file of a template may be.
pub(crate) const TEMPLATE_LIMIT: Limit = Limit {
    what: "an effect template",
    ..syntax::LIMIT
};

/// A template as text.
#[derive(Debug, Clone)]
pub(super) struct TemplateText {
    /// The name shown in messages.
    pub origin: String,
    /// The whole file.
    pub text: String,
}

/// Why a folder of templates could not be read.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// The folder or a file in it.
    #[error("cannot read `{path}`: {reason}; expected a folder of effect templates (`*.model`)", path = path.display())]
    Unreadable {
        /// Which.
        path: PathBuf,
        /// What the system says.
        reason: std::io::Error,
    },
}

macro_rules! builtin {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../effects/", $name, ".model")))),*]
    };
}

/// The templates under `models/effects/`, compiled in; `effects` is a link to that folder, so that the
/// package on the registry has them, too. A test asserts that the list is the folder's content.
const BUILTIN: &[(&str, &str)] = builtin![
    "armature",
    "asymmetric_coulomb",
    "backlash",
    "cogging",
    "com_offset",
    "constant_force",
    "contact_friction",
    "coulomb",
    "cubic_spring",
    "dead_band",
    "drive_friction",
    "gravity_tilt",
    "input_bias",
    "input_delay",
    "input_gain",
    "input_lag",
    "joint_coupling",
    "load_friction",
    "lugre",
    "measurement_offset",
    "measurement_scale",
    "mounting_tilt",
    "payload",
    "quadratic_drag",
    "rolling_resistance",
    "saturation",
    "speed_drag",
    "spring",
    "stribeck",
    "time_shift",
    "viscous",
];

impl Library {
    /// No template at all.
    pub fn empty() -> Self {
        Self::default()
    }

    /// The templates that come with this crate.
    pub fn builtin() -> Self {
        let mut library = Self::empty();
        for (name, text) in BUILTIN {
            library.add(*name, format!("models/effects/{name}.model"), *text);
        }
        library
    }

    /// Adds a template; it replaces one of the same name.
    pub fn add(
        &mut self,
        name: impl Into<String>,
        origin: impl Into<String>,
        text: impl Into<String>,
    ) {
        self.templates.insert(
            name.into(),
            TemplateText {
                origin: origin.into(),
                text: text.into(),
            },
        );
    }

    /// Adds every `*.model` file of a folder, in the order of their names.
    ///
    /// # Errors
    /// If the folder or one of the files cannot be read as text.
    pub fn add_folder(&mut self, folder: &Path) -> Result<(), LibraryError> {
        let unreadable = |path: &Path| {
            let path = path.to_path_buf();
            move |reason| LibraryError::Unreadable { path, reason }
        };
        let mut files = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable(folder))? {
            let path = entry.map_err(unreadable(folder))?.path();
            if path
                .extension()
                .is_some_and(|extension| extension == "model")
            {
                files.push(path);
            }
        }
        files.sort();
        for path in files {
            let text = file::read_text(&path, TEMPLATE_LIMIT).map_err(unreadable(&path))?;
            let name = path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            self.add(name, path.display().to_string(), text);
        }
        Ok(())
    }

    /// The text of a template that is not built in, or not as it is here.
    pub fn own(&self, name: &str) -> Option<&str> {
        let found = self.get(name)?;
        let builtin = BUILTIN.iter().any(|entry| *entry == (name, &found.text));
        (!builtin).then_some(found.text.as_str())
    }

    /// Says from which folder the paths in a model start: that of the model's file.
    /// Without it they start from the current one.
    pub fn look_in(&mut self, folder: impl Into<PathBuf>) {
        self.folder = folder.into();
    }

    /// Says what all paths are relative to, where that is not the current folder.
    /// Messages do not show it.
    pub fn start_from(&mut self, root: impl Into<PathBuf>) {
        self.root = root.into();
    }

    /// Puts a text in place of the file `path`; messages call it `shown`.
    pub fn add_file(
        &mut self,
        path: impl Into<String>,
        shown: impl Into<String>,
        text: impl Into<String>,
    ) {
        self.files.insert(path.into(), (shown.into(), text.into()));
    }

    /// A file that a model names: what messages call it, and its text.
    pub(super) fn read(&self, path: &str, limit: Limit) -> std::io::Result<(String, String)> {
        if let Some(known) = self.files.get(path) {
            return Ok(known.clone());
        }
        let shown = self.folder.join(path);
        let place = self.root.join(&shown);
        let text = file::read_text(&place, limit)?;
        Ok((shown.display().to_string(), text))
    }

    /// The names of all templates, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.templates.keys().map(String::as_str)
    }

    pub(super) fn get(&self, name: &str) -> Option<&TemplateText> {
        self.templates.get(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_builtin_list_is_the_folder() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../models/effects");
        let mut on_disk = Library::empty();
        on_disk.add_folder(Path::new(folder)).unwrap();
        let builtin = Library::builtin();
        assert_eq!(
            builtin.names().collect::<Vec<_>>(),
            on_disk.names().collect::<Vec<_>>()
        );
    }
}
