//! Models that stand in a file, for build scripts and for the derive macro.
//!
//! A `build.rs` is one line per model:
//!
//! ```no_run
//! fn main() -> Result<(), dynamics_codegen::build::Error> {
//!     dynamics_codegen::build::module("models/cart.model")
//! }
//! ```
//!
//! and the crate itself takes the module up by the name that the model gives itself
//! (`model cart;`):
//!
//! ```text
//! #[allow(dead_code, clippy::all, reason = "a model offers more than one program uses")]
//! mod cart {
//!     include!(concat!(env!("OUT_DIR"), "/cart.rs"));
//! }
//! ```

use crate::compile::{Compiled, compile_keeping, model_limit, not_text};
use crate::diagnostic::Report;
use crate::emit::{Emission, FunctionError, Functions};
use crate::file::{self, Limit};
use crate::model::{Library, LibraryError, TEMPLATE_LIMIT, Variables};
use crate::robot::Format;
use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why there is no module.
///
/// Shown in full both by `{}` and by `{:?}`, since the latter is what Rust prints when
/// `main` returns an error.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that is not there, or may not be read.
    #[error("cannot read `{}`: {reason}", path.display())]
    Unreadable {
        /// Which.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// What is wrong with the model, with its places.
    #[error("{0}")]
    Model(Report),
    /// A parameter to be kept variable that the model does not have.
    #[error("the model has no parameter `{name}`: {help}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// What may have been meant.
        help: String,
    },
    /// Functions that there are not, or that the model cannot have.
    #[error("{0}{help}", help = help(.0))]
    Functions(FunctionError),
    /// Not called by a build script.
    #[error("`OUT_DIR` is not set: this is for a build script, which cargo runs (`build.rs`)")]
    NoOutDir,
    /// The module could not be written.
    #[error("cannot write `{}`: {reason}", path.display())]
    Unwritable {
        /// Where.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
}

/// The mend, in a line of its own.
fn help(error: &FunctionError) -> String {
    let help = error.help();
    help.map_or(String::new(), |help| format!("\nhelp: {help}"))
}

impl From<FunctionError> for Error {
    fn from(error: FunctionError) -> Self {
        Self::Functions(error)
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl From<LibraryError> for Error {
    fn from(LibraryError::Unreadable { path, reason }: LibraryError) -> Self {
        Self::Unreadable { path, reason }
    }
}

/// Writes the Rust module of a model file to `OUT_DIR` and tells cargo which files it was
/// made from: all that a `build.rs` has to do. The file is called after the model's own
/// name. [`ModelFile`] has choices to make.
///
/// # Errors
/// Everything that is wrong with the model, as a compiler would show it; or the files.
pub fn module(path: impl AsRef<Path>) -> Result<(), Error> {
    ModelFile::new(path.as_ref()).write()
}

/// A model file, or a robot description (URDF or MJCF), and what is to be made of it.
///
/// ```no_run
/// use dynamics_codegen::build::ModelFile;
///
/// fn main() -> Result<(), dynamics_codegen::build::Error> {
///     ModelFile::new("models/cart.model")
///         .effects("models/effects")
///         .keep(["mc", "l"])
///         .functions("inverse_dynamics,forward_dynamics_derivatives")
///         .write()
/// }
/// ```
#[derive(Debug, Clone)]
pub struct ModelFile {
    path: PathBuf,
    root: PathBuf,
    effects: Vec<PathBuf>,
    variables: Variables,
    functions: String,
}

/// A compiled model with the files that it was made from.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Read {
    /// The model.
    pub compiled: Compiled,
    /// The files, the model's own first: when one of them changes, so may the model.
    pub files: Vec<PathBuf>,
    /// What is emitted beside its terms.
    pub functions: Functions,
}

impl ModelFile {
    /// A model file by its path, relative to the folder of the manifest (where cargo runs
    /// build scripts).
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            root: PathBuf::new(),
            effects: Vec::new(),
            variables: Variables::All,
            functions: String::new(),
        }
    }

    /// Takes paths as relative to this folder. Messages show them as they are given.
    #[must_use]
    pub fn root(mut self, folder: impl Into<PathBuf>) -> Self {
        self.root = folder.into();
        self
    }

    /// Adds a folder of effect templates (`*.model`) of one's own; they win over those
    /// built in, and a later folder over an earlier one.
    #[must_use]
    pub fn effects(mut self, folder: impl Into<PathBuf>) -> Self {
        self.effects.push(folder.into());
        self
    }

    /// Keeps only these parameters variable. The others are folded in as numbers.
    #[must_use]
    pub fn keep<I: IntoIterator<Item: Into<String>>>(mut self, parameters: I) -> Self {
        self.variables = Variables::only(parameters);
        self
    }

    /// Emits these functions, too, a list as [`Functions`] reads it: `full`, or names separated by
    /// commas.
    #[must_use]
    pub fn functions(mut self, list: impl Into<String>) -> Self {
        self.functions = list.into();
        self
    }

    /// Reads and compiles the model.
    ///
    /// # Errors
    /// If there is no function of a name. If a file cannot be read, or everything that is wrong with the model. A parameter
    /// to keep that is none is left to [`Variables::unknown`].
    pub fn read(&self) -> Result<Read, Error> {
        let functions = self.functions.parse::<Functions>()?;
        let mut library = Library::builtin();
        let mut files = vec![self.root.join(&self.path)];
        for folder in &self.effects {
            let place = self.root.join(folder);
            for template in templates(&place, folder)? {
                let text = read_text(&place.join(&template.file), &template.shown, TEMPLATE_LIMIT)?;
                library.add(template.name, template.shown.display().to_string(), text);
                files.push(place.join(template.file));
            }
        }
        library.start_from(&self.root);
        library.look_in(self.path.parent().unwrap_or(Path::new("")));
        let text = read_text(&files[0], &self.path, model_limit(&self.path))?;
        let name = self.path.display().to_string();
        let compiled =
            compile_keeping(&name, &text, &library, &self.variables).map_err(Error::Model)?;
        if let Some(robot) = &compiled.model.robot {
            let mut description = files[0].clone();
            if Format::of(&text).is_none() {
                description = files[0].with_file_name("").join(&robot.file);
                files.push(description.clone());
            }
            let included = robot.included.iter();
            files.extend(included.map(|(path, _)| description.with_file_name("").join(path)));
        }
        let tables = compiled.model.tables.iter();
        let numbers = tables.filter_map(|table| table.file.as_ref());
        files.extend(
            numbers.map(|(file, _)| self.root.join(&self.path).with_file_name("").join(file)),
        );
        Ok(Read {
            compiled,
            files,
            functions,
        })
    }

    /// Writes the module to `OUT_DIR` and tells cargo what it was made from; warnings of
    /// the model become warnings of the build.
    ///
    /// # Errors
    /// As [`read`](Self::read); also if a parameter to keep is none, if the model cannot have one of
    /// the functions, or if the file cannot be written.
    pub fn write(&self) -> Result<(), Error> {
        let out = std::env::var_os("OUT_DIR").ok_or(Error::NoOutDir)?;
        let mut lines = vec![format!(
            "cargo::rerun-if-changed={}",
            self.root.join(&self.path).display()
        )];
        let folders = self.effects.iter().map(|folder| self.root.join(folder));
        lines.extend(folders.map(|f| format!("cargo::rerun-if-changed={}", f.display())));
        // Even if the model has faults: once mended it is to be read again.
        tell(&lines)?;
        let read = self.read()?;
        if let Some((name, help)) = self.variables.unknown(&read.compiled.model).pop() {
            return Err(Error::UnknownParameter { name, help });
        }
        let warnings = read.compiled.warnings.render();
        let mut lines: Vec<String> = warnings
            .lines()
            .map(|line| format!("cargo::warning={line}"))
            .collect();
        let files = read.files.iter();
        lines.extend(files.map(|f| format!("cargo::rerun-if-changed={}", f.display())));
        tell(&lines)?;
        let name = self.path.display().to_string();
        let file = Emission::new(&read.compiled, &name, &read.functions)?.rust_file();
        replace(&Path::new(&out).join(file.name), &file.text)
    }
}

/// An effect template in a folder.
struct Template {
    name: String,
    file: PathBuf,
    /// What messages call it.
    shown: PathBuf,
}

/// The templates of a folder, in the order of their names.
fn templates(place: &Path, shown: &Path) -> Result<Vec<Template>, Error> {
    let unreadable = |reason| Error::Unreadable {
        path: shown.to_path_buf(),
        reason,
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(place).map_err(unreadable)? {
        let file = PathBuf::from(entry.map_err(unreadable)?.file_name());
        if file.extension().is_some_and(|ending| ending == "model") {
            let name = file.file_stem().unwrap_or_default();
            found.push(Template {
                name: name.to_string_lossy().into_owned(),
                shown: shown.join(&file),
                file,
            });
        }
    }
    found.sort_by(|a, b| a.file.cmp(&b.file));
    Ok(found)
}

fn read_text(path: &Path, shown: &Path, limit: Limit) -> Result<String, Error> {
    let bytes = file::read(path, limit).map_err(|reason| Error::Unreadable {
        path: shown.to_path_buf(),
        reason,
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let name = shown.display().to_string();
        Error::Model(not_text(&name, error.as_bytes(), error.utf8_error()))
    })
}

/// Speaks to cargo, which listens to the standard output of a build script.
fn tell(lines: &[String]) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    let written = lines.iter().try_for_each(|line| writeln!(out, "{line}"));
    written
        .and_then(|()| out.flush())
        .map_err(unwritable(Path::new("standard output")))
}

fn unwritable(path: &Path) -> impl Fn(io::Error) -> Error {
    move |reason| Error::Unwritable {
        path: path.to_path_buf(),
        reason,
    }
}

/// Whole or not at all, and not touched if it is the same: cargo would build again.
fn replace(path: &Path, text: &str) -> Result<(), Error> {
    if file::holds(path, text.as_bytes()) {
        return Ok(());
    }
    let beside = path.with_extension(format!("{}.part", std::process::id()));
    std::fs::write(&beside, text).map_err(unwritable(&beside))?;
    std::fs::rename(&beside, path).map_err(unwritable(path))
}
