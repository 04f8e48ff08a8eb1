//! From the attribute to the text of the model's module.

use crate::attribute::Attributes;
use crate::input::{Input, add};
use dynamics_codegen::build::{Error as Fault, ModelFile};
use dynamics_codegen::emit::{self, Emission};
use dynamics_codegen::{Compiled, Variables};
use std::path::{Path, PathBuf};
use syn::{Error, Result};

/// The module, and what it was made from.
pub struct Module {
    pub text: String,
    /// Field names of the parameters, in the order of the struct's fields.
    pub fields: Vec<String>,
    /// Warnings of the model, rendered.
    pub warnings: String,
    /// The files, as absolute paths.
    pub files: Vec<PathBuf>,
}

/// Reads and compiles the model, with all but the struct's fields folded in.
pub fn open(attributes: &Attributes, input: &Input) -> Result<Module> {
    let place = attributes.model.span();
    let folder = std::env::var_os("CARGO_MANIFEST_DIR")
        .ok_or_else(|| Error::new(place, "`CARGO_MANIFEST_DIR` is not set: build with cargo"))?;
    let path = attributes.model.value();
    let names = input.variables.iter().map(|v| v.parameter.clone());
    let mut file = ModelFile::new(&path).root(&folder).keep(names);
    for effects in &attributes.effects {
        file = file.effects(effects.value());
    }
    if let Some(functions) = &attributes.functions {
        file = file.functions(functions.value());
    }
    let read = file.read().map_err(|fault| located(fault, attributes))?;
    known(&read.compiled, input)?;
    let emission = Emission::new(&read.compiled, &path, &read.functions);
    let emission = emission.map_err(|fault| located(fault.into(), attributes))?;
    let fields = input
        .variables
        .iter()
        .map(|v| emit::identifier(&v.parameter));
    Ok(Module {
        text: emission.rust(),
        fields: fields.collect(),
        warnings: read.compiled.warnings.render(),
        files: read.files,
    })
}

/// What is wrong with a file, at the attribute that names it.
fn located(fault: Fault, attributes: &Attributes) -> Error {
    match fault {
        Fault::Unreadable { path, reason } => {
            let named = |text: &&syn::LitStr| path.starts_with(Path::new(&text.value()));
            let place = attributes.effects.iter().find(named);
            let place = place.unwrap_or(&attributes.model).span();
            let message = format!(
                "cannot read `{}`: {reason}; paths are relative to the folder of `Cargo.toml`",
                path.display()
            );
            Error::new(place, message)
        }
        Fault::Model(report) => {
            let message = format!("the model has faults\n\n{}\n", report.render());
            Error::new(attributes.model.span(), message)
        }
        Fault::Functions(_) => {
            let place = attributes.functions.as_ref().unwrap_or(&attributes.model);
            Error::new(place.span(), fault.to_string())
        }
        other => Error::new(attributes.model.span(), other.to_string()),
    }
}

/// Every field is a parameter.
fn known(compiled: &Compiled, input: &Input) -> Result<()> {
    let names = input.variables.iter().map(|v| v.parameter.clone());
    let unknown = Variables::only(names).unknown(&compiled.model);
    let mut errors = None;
    for variable in &input.variables {
        if let Some((name, help)) = unknown.iter().find(|(name, _)| *name == variable.parameter) {
            let message = format!("the model has no parameter `{name}`: {help}");
            add(&mut errors, Error::new(variable.field.span(), message));
        }
    }
    errors.map_or(Ok(()), Err)
}
