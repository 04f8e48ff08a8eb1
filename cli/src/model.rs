//! The model that every command works on, with the values of its parameters.

use crate::mistake::Mistake;
use crate::{output, parameters};
use clap::Args;
use dynamics_codegen::file::{self, Limit};
use dynamics_codegen::model::LibraryError;
use dynamics_codegen::robot::Format;
use dynamics_codegen::{Compiled, Library, compile_bytes, model_limit, model_of_description};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The arguments that every command shares.
#[derive(Debug, Clone, Args)]
pub struct ModelArguments {
    /// The model: a `.model` file, or a robot description (URDF or MJCF)
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,

    /// A folder of your own effect templates (`*.model`); wins over the built-in ones
    #[arg(long, value_name = "DIR")]
    pub effects: Vec<PathBuf>,

    /// Values in place of the nominal ones: a JSON object, parameter name to number
    #[arg(long, value_name = "FILE.json")]
    pub parameters: Option<PathBuf>,
}

/// A model, ready to work with.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Where it came from, as the user wrote it.
    pub path: PathBuf,
    /// The file, byte for byte.
    pub bytes: Vec<u8>,
    /// The effect templates that it may name.
    pub library: Library,
    /// The model and its equations.
    pub compiled: Compiled,
    /// The parameters' values, in model order: nominal unless overridden.
    pub parameters: Vec<f64>,
}

impl Loaded {
    /// The model as a text that effects can be written into, and the file that it
    /// belongs in. A robot description is not written to: the text is a new model that
    /// names it, beside it.
    pub fn text(&self) -> (String, PathBuf) {
        let text = String::from_utf8_lossy(&self.bytes).into_owned();
        let Some(format) = Format::of(&text) else {
            return (text, self.path.clone());
        };
        let file = self.path.file_name().unwrap_or_default();
        let text = model_of_description(format, &file.to_string_lossy());
        (text, self.path.with_extension("model"))
    }

    /// The parameters whose values are not the nominal ones, by name.
    pub fn overrides(&self) -> BTreeMap<String, f64> {
        let named = self.compiled.model.parameters.iter().zip(&self.parameters);
        named
            .filter(|(parameter, value)| parameter.nominal != **value)
            .map(|(parameter, &value)| (parameter.name.clone(), value))
            .collect()
    }

    /// With some of its parameters folded in; the others keep their values.
    pub fn fold(&mut self, compiled: Compiled) {
        let names = self.compiled.model.parameters.iter();
        let values: BTreeMap<String, f64> = (names.zip(&self.parameters))
            .map(|(parameter, &value)| (parameter.name.clone(), value))
            .collect();
        let kept = compiled.model.parameters.iter();
        self.parameters = kept.map(|parameter| values[&parameter.name]).collect();
        self.compiled = compiled;
    }

    /// Whether there is no model file yet: the model is a robot description.
    pub fn is_robot_description(&self) -> bool {
        Format::of(&String::from_utf8_lossy(&self.bytes)).is_some()
    }
}

impl ModelArguments {
    /// Reads and compiles the model, and prints its warnings.
    ///
    /// # Errors
    /// Everything that is wrong with the model, the templates or the parameters.
    pub fn load(&self) -> Result<Loaded, Mistake> {
        let (loaded, warnings) = self.read()?;
        if !loaded.compiled.warnings.diagnostics.is_empty() {
            output::explain(&Mistake::from(loaded.compiled.warnings.clone()));
        }
        warnings.iter().for_each(output::warn);
        Ok(loaded)
    }

    /// Reads and compiles the model; also returns what should be known about the parameters.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn read(&self) -> Result<(Loaded, Vec<Mistake>), Mistake> {
        let mut library = self.library()?;
        library.look_in(self.model.parent().unwrap_or(Path::new("")));
        let bytes = read(&self.model, model_limit(&self.model))?;
        let compiled = compile_bytes(&self.model.display().to_string(), &bytes, &library)?;
        let mut values = compiled.model.nominal_parameters();
        let warnings = match &self.parameters {
            Some(path) => parameters::override_from(path, &compiled.model, &mut values)?,
            None => Vec::new(),
        };
        let loaded = Loaded {
            path: self.model.clone(),
            bytes,
            library,
            compiled,
            parameters: values,
        };
        Ok((loaded, warnings))
    }

    fn library(&self) -> Result<Library, Mistake> {
        let mut library = Library::builtin();
        for folder in &self.effects {
            library.add_folder(folder).map_err(|error| {
                let LibraryError::Unreadable { path, reason } = &error;
                Mistake::unreadable(path, reason)
                    .help("`--effects` takes a folder of effect templates, one `*.model` file each")
            })?;
        }
        Ok(library)
    }
}

/// The bytes of a file that the user names: of a regular one, up to a limit.
///
/// # Errors
/// If the system will not let us, or it is larger or no file at all.
pub fn read(path: &Path, limit: Limit) -> Result<Vec<u8>, Mistake> {
    file::read(path, limit).map_err(|error| Mistake::unreadable(path, &error))
}
