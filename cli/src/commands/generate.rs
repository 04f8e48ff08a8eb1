//! `dynamics generate`: a model as source code.

use crate::fold::folded;
use crate::mistake::Mistake;
use crate::model::ModelArguments;
use crate::output;
use crate::whole_file::{WholeFile, make_folder};
use clap::{Args, ValueEnum};
use dynamics_codegen::emit::{Emission, File, FunctionError};
use dynamics_codegen::file::holds;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `generate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics generate models/pendulum2.model --to rust --out src/generated
  dynamics generate arm.model --effects my_effects --to c --out firmware/src
  dynamics generate models/wheelbot.model --to c --fold all --out firmware/src
  dynamics generate arm.model --to rust --out src --functions inverse_dynamics,forward_dynamics_derivatives")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The language
    #[arg(long, value_enum, value_name = "LANGUAGE")]
    to: Language,

    /// Functions besides the terms and `equation_of_motion`, separated by commas: `full`, or
    /// names as `inverse_dynamics`, `forward_dynamics_derivatives`, `residual_derivatives`,
    /// `force_by_velocity`; with `+` between them, several in one function
    #[arg(
        long,
        value_name = "LIST",
        default_value = "",
        hide_default_value = true
    )]
    functions: String,

    /// Parameters that are constant on this machine: `all`, or names separated by commas. They
    /// become numbers, at the values of `--parameters`, and the code is the shorter for it
    #[arg(long, value_name = "NAMES")]
    fold: Option<String>,

    /// The folder for the files; made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// What a model can be turned into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// A module that needs nothing but the crate `dynamics`
    Rust,
    /// A header and a source file of C99 that need nothing but `math.h`
    C,
}

/// Runs the command.
///
/// # Errors
/// If the model is faulty or the folder cannot be written to.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut loaded = arguments.model.load()?;
    if let Some(list) = &arguments.fold {
        loaded.fold(folded(&loaded, list)?);
    }
    let parameters = loaded.compiled.model.parameters.iter_mut();
    for (parameter, &value) in parameters.zip(&loaded.parameters) {
        parameter.nominal = value;
    }
    let name = shown_path(&arguments.model.model);
    let functions = arguments.functions.parse().map_err(wrong)?;
    let emission = Emission::new(&loaded.compiled, &name, &functions).map_err(wrong)?;
    let files = match arguments.to {
        Language::Rust => vec![emission.rust_file()],
        Language::C => emission.c().to_vec(),
    };
    make_folder(&arguments.out)?;
    let lines = write_all(&arguments.out, &files)?;
    let mut out = output::stdout();
    out.write_all(lines.as_bytes())?;
    Ok(out.flush()?)
}

fn wrong(error: FunctionError) -> Mistake {
    let mistake = Mistake::new(error.to_string());
    match error.help() {
        Some(help) => mistake.help(help),
        None => mistake,
    }
}

/// The model's path as the first lines of a file name it, the same on every machine: as
/// given, or, of one that starts from the root, what leads there from the current folder,
/// or else the file's name.
fn shown_path(path: &Path) -> String {
    let shown = if path.is_absolute() {
        let here = std::env::current_dir().unwrap_or_default();
        let name = path.file_name().map_or(path, Path::new);
        path.strip_prefix(here).unwrap_or(name)
    } else {
        path
    };
    shown.display().to_string().replace('\\', "/")
}

/// Writes all files or none: first beside their places, then into them. Files that are
/// there already, word for word, are left alone, so that nothing is rebuilt for them.
fn write_all(folder: &Path, files: &[File]) -> anyhow::Result<String> {
    let (mut written, mut lines) = (Vec::new(), String::new());
    for file in files {
        let path = folder.join(&file.name);
        let unchanged = holds(&path, file.text.as_bytes());
        if !unchanged {
            let mut whole = WholeFile::create(&path)?;
            whole.write_all(file.text.as_bytes())?;
            written.push(whole);
        }
        let what = if unchanged { "unchanged" } else { "wrote" };
        lines.push_str(&format!("{what} {}\n", path.display()));
    }
    for whole in written {
        whole.finish()?;
    }
    Ok(lines)
}
