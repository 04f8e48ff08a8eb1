//! The whole pipeline on one screen.

use crate::derive::{System, derive};
use crate::diagnostic::{Diagnostic, Report};
use crate::emit::identifier;
use crate::file::Limit;
use crate::model::{Library, Model, Variables, build};
use crate::parts;
use crate::plausible;
use crate::robot::{self, Format};
use crate::source::{Sources, Span};
use crate::syntax::{self, parse};
use std::path::Path;
use std::str::Utf8Error;

/// A model with its equations.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Compiled {
    /// The checked model; its graph holds all expressions.
    pub model: Model,
    /// The terms of the equation of motion.
    pub system: System,
    /// Warnings, with the texts they point into.
    pub warnings: Report,
}

/// Compiles the text of a model file. `name` is what messages call it; effects
/// that the model names are looked up in `library`.
///
/// # Errors
/// Everything that is wrong with the text, each with its place and a mend.
///
/// ```
/// use dynamics_codegen::{Library, compile};
///
/// let text = "
///     model pendulum;
///     coordinate j1: rad;
///     parameter m: kg = 1;
///     parameter l: m = 0.5;
///     constant g: m/s^2 = 9.81;
///     kinetic m*l^2/2*dot(j1)^2;
///     potential -m*g*l*cos(j1);
/// ";
/// let compiled = compile("pendulum.model", text, &Library::builtin())?;
/// assert_eq!(compiled.model.coordinates.len(), 1);
/// # Ok::<(), dynamics_codegen::Report>(())
/// ```
pub fn compile(name: &str, text: &str, library: &Library) -> Result<Compiled, Report> {
    compile_keeping(name, text, library, &Variables::All)
}

/// As [`compile`], with every parameter but `variables` folded in: it is its nominal
/// value in all expressions, which simplify accordingly, and stands in
/// [`Model::fixed`] instead of [`Model::parameters`].
///
/// # Errors
/// As [`compile`]; also if a value that is folded in makes an expression meaningless.
///
/// ```
/// use dynamics_codegen::{Library, Variables, compile_keeping, emit};
///
/// let text = "
///     model slider;
///     coordinate x: m;
///     parameter m: kg = 2;
///     parameter k: N/m = 0;
///     kinetic m/2*dot(x)^2;
///     potential k/2*x^2;
/// ";
/// let variables = Variables::only(["m"]);
/// let compiled = compile_keeping("slider.model", text, &Library::empty(), &variables)?;
/// assert_eq!(compiled.model.parameters.len(), 1);
/// assert!(!emit::rust(&compiled, "slider.model").contains("p.k"));
/// # Ok::<(), dynamics_codegen::Report>(())
/// ```
pub fn compile_keeping(
    name: &str,
    text: &str,
    library: &Library,
    variables: &Variables,
) -> Result<Compiled, Report> {
    // Some editors put a byte-order mark in front.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if let Some(format) = Format::of(text) {
        return compile_description(format, name, text, library, variables);
    }
    let mut sources = Sources::new();
    let id = sources.add(name, text);
    let (file, mut diagnostics) = parse(&sources, id);
    let readable = diagnostics.is_empty();
    let derived = file.and_then(|file| {
        let expanded = parts::expand(file, &sources, &mut diagnostics);
        let model = build(
            &expanded.file,
            expanded.uses,
            &mut sources,
            library,
            variables,
            &mut diagnostics,
        );
        let derived = model.filter(|_| readable).map(|mut model| {
            let system = derive(&mut model);
            plausible::check(&model, &system, &expanded.file, &mut diagnostics);
            (model, system)
        });
        expanded.readings.explain(&mut diagnostics);
        derived
    });
    let warnings = Report {
        sources,
        diagnostics,
    };
    match derived {
        Some((model, system)) if !warnings.has_errors() => Ok(Compiled {
            model,
            system,
            warnings,
        }),
        _ => Err(warnings),
    }
}

/// How large a file may be that somebody calls a model: a page, unless it may be a robot
/// description.
pub fn model_limit(path: &Path) -> Limit {
    match path.extension() {
        Some(ending) if ending == "model" => syntax::LIMIT,
        _ => robot::LIMIT,
    }
}

/// The model that says nothing but that its base is the robot description `path`:
/// what effects can be written into.
pub fn model_of_description(format: Format, path: &str) -> String {
    model_with(format, path, ";")
}

fn model_with(format: Format, path: &str, options: &str) -> String {
    let stem = Path::new(path).file_stem();
    let stem = stem.unwrap_or_default().to_string_lossy();
    let (stem, word) = (identifier(&stem), format.word());
    format!("model {stem};\n\n{word} {path:?}{options}\n")
}

/// A robot description by itself: the model is called what the robot is called. What is
/// named as variable may be an inertial parameter of any link or a length.
fn compile_description(
    format: Format,
    name: &str,
    text: &str,
    library: &Library,
    variables: &Variables,
) -> Result<Compiled, Report> {
    const FILE: &str = "robot";
    let mut library = library.clone();
    library.add_file(FILE, name, text);
    let options = match variables {
        Variables::All => ";",
        Variables::Only(_) | Variables::Except(_) => " { parameters: all; origins: all; }",
    };
    let model = model_with(format, FILE, options);
    let compiled = compile_keeping(name, &model, &library, variables);
    let mut compiled = compiled.map_err(|report| about_robot(format, report, text))?;
    compiled.warnings = about_robot(format, compiled.warnings, text);
    if let Some(robot) = &mut compiled.model.robot {
        robot.file = name.to_string();
        if !robot.name.is_empty() {
            compiled.model.name.clone_from(&robot.name);
        }
    }
    Ok(compiled)
}

/// Findings about a robot description by itself: what points into the model that was put
/// around it, which its author has never seen, points at the outermost element of the text instead,
/// or is left out where it only explains.
fn about_robot(format: Format, mut report: Report, text: &str) -> Report {
    let mut ids = report.sources.ids();
    let around = ids.next();
    let Some(robot) = ids.find(|&id| report.sources.get(id).text == text) else {
        return report;
    };
    let start = text.find(&format!("<{}", format.root())).unwrap_or(0);
    let length = text[start..].find('>').map_or(0, |end| end + 1);
    let whole = Span {
        source: robot,
        start,
        end: start + length,
    };
    for diagnostic in &mut report.diagnostics {
        let seen = |span: Span| Some(span.source) != around;
        diagnostic.secondary.retain(|label| seen(label.span));
        if !seen(diagnostic.primary.span) {
            diagnostic.primary.span = whole;
        }
    }
    report
}

/// As [`compile`], for bytes as they come from a file.
///
/// # Errors
/// As [`compile`]; also if the bytes are not UTF-8.
pub fn compile_bytes(name: &str, bytes: &[u8], library: &Library) -> Result<Compiled, Report> {
    match std::str::from_utf8(bytes) {
        Ok(text) => compile(name, text, library),
        Err(error) => Err(not_text(name, bytes, error)),
    }
}

/// The report about a file that is not UTF-8.
pub(crate) fn not_text(name: &str, bytes: &[u8], error: Utf8Error) -> Report {
    let mut sources = Sources::new();
    let valid = String::from_utf8_lossy(&bytes[..error.valid_up_to()]).into_owned();
    let end = valid.len();
    let source = sources.add(name, valid);
    let span = Span {
        source,
        start: end.saturating_sub(1),
        end,
    };
    let diagnostic = Diagnostic::error(span, "the file is not UTF-8 text")
        .label(format!("byte {} is not valid", error.valid_up_to()))
        .help("save it as UTF-8");
    Report {
        sources,
        diagnostics: vec![diagnostic],
    }
}
