//! Rust source: one module per model, generic over the scalar.
//!
//! The module refers to nothing but `::dynamics` and `core`, so that it can be a file of
//! a crate or be included. It holds
//!
//! * sizes and names (`COORDINATES`, `COORDINATE_NAMES`, …),
//! * `Parameters<T>`,
//! * a function `(&Parameters<T>, &Point<T, …>) -> [[T; n]; m]` per
//!   [quantity](super::quantities) that the model has,
//! * `equation_of_motion`, which computes what a step of a simulation needs at once,
//! * a type named after the model that implements `::dynamics::System`.

mod documentation;
mod function;
mod language;
mod derivatives;
mod layout;
mod library;
mod parameters;
mod system;

pub use library::{DuplicateModel, File, module_name, rust_crate, rust_crate_of, rust_file};

use super::emission::Emission;
use super::header;
use super::naming::type_name;
use super::plan::{Function, Plan};
use super::symbols::Symbols;
use crate::compile::Compiled;
use documentation::Doc;
use layout::{Array, Writer};

/// Types that the module defines or imports.
const TAKEN: [&str; 11] = [
    "Parameters",
    "EquationOfMotion",
    "Constraint",
    "Equation",
    "Point",
    "Scalar",
    "System",
    "SMatrix",
    "SVector",
    "T",
    "Self",
];

/// The module of a model as text, laid out as rustfmt does (names of more than about
/// 40 characters aside). `source_name` is the model's path as the header is to name it.
///
/// The same model gives the same text on every machine. Nothing in the model can
/// become anything but an identifier, a number, a string or a comment of one line.
///
/// ```
/// use dynamics_codegen::{Library, compile, emit};
///
/// let text = "
///     model slider;
///     coordinate x: m;
///     parameter m: kg = 2;
///     kinetic m/2*dot(x)^2;
/// ";
/// let compiled = compile("slider.model", text, &Library::empty())?;
/// let module = emit::rust(&compiled, "slider.model");
/// assert!(module.contains("pub fn mass_matrix<T: Scalar>"));
/// # Ok::<(), dynamics_codegen::Report>(())
/// ```
pub fn rust(compiled: &Compiled, source_name: &str) -> String {
    Emission::terms(compiled, source_name).rust()
}

impl Emission<'_> {
    /// The Rust module; see [`rust`].
    pub fn rust(&self) -> String {
        let mut writer = Writer::default();
        for line in header::lines(self, "rust") {
            writer.line(format!("// {line}").trim_end());
        }
        writer.blank();
        Unit::new(self).module(&mut writer);
        writer.into_text()
    }
}

/// What all parts of a module refer to.
struct Unit<'a> {
    compiled: &'a Compiled,
    plan: &'a Plan,
    symbols: Symbols,
    type_name: String,
}

impl<'a> Unit<'a> {
    fn new(emission: &'a Emission<'_>) -> Self {
        let (compiled, plan) = (emission.compiled, &emission.plan);
        let results: Vec<String> = plan.functions.iter().map(result_name).collect();
        let results = results.iter().map(String::as_str);
        let taken: Vec<&str> = TAKEN.into_iter().chain(results).collect();
        Self {
            compiled,
            plan,
            symbols: plan.symbols(&[]),
            type_name: type_name(&compiled.model.name, &taken),
        }
    }

    fn module(&self, w: &mut Writer) {
        w.line("use ::dynamics::linalg::from_rows;");
        w.line("use ::dynamics::nalgebra::{SMatrix, SVector};");
        w.line("use ::dynamics::{Constraint, Equation, Point, Scalar, System};");
        w.blank();
        self.sizes(w);
        self.parameters(w);
        w.blank();
        self.model(w);
        w.blank();
        for function in &self.plan.functions {
            if function.fused {
                self.fused(w, function);
            } else {
                self.single(w, function);
            }
            w.blank();
        }
        self.system(w);
        self.derivative_traits(w);
    }

    /// Whether a function is emitted.
    fn has(&self, name: &str) -> bool {
        self.plan.functions.iter().any(|f| f.name == name)
    }

    /// `Point<T, n, k, 0>`
    fn point(&self) -> String {
        let model = &self.compiled.model;
        format!(
            "Point<T, {}, {}, 0>",
            model.coordinates.len(),
            model.inputs.len()
        )
    }

    /// `COORDINATES`, `COORDINATE_NAMES`, …
    fn sizes(&self, w: &mut Writer) {
        let model = &self.compiled.model;
        let coordinates = model.coordinates.iter().map(|c| c.name.as_str()).collect();
        size(w, "COORDINATE", "coordinates", coordinates);
        size(
            w,
            "INPUT",
            "inputs",
            model.inputs.iter().map(|u| u.name.as_str()).collect(),
        );
        let constraints = model.constraints.iter().map(|c| c.name.as_str()).collect();
        size(w, "CONSTRAINT", "constraint rows", constraints);
        size(
            w,
            "OUTPUT",
            "outputs",
            model.outputs.iter().map(|o| o.name.as_str()).collect(),
        );
        size(
            w,
            "PARAMETER",
            "parameters",
            model.parameters.iter().map(|p| p.name.as_str()).collect(),
        );
    }
}

/// The type that a function of several quantities returns.
fn result_name(function: &Function) -> String {
    type_name(&function.name, &[])
}

/// How many there are, and what they are called.
fn size(w: &mut Writer, word: &str, what: &str, names: Vec<&str>) {
    w.doc(&Doc::of(format!("Number of {what}.")));
    w.line(format!("pub const {word}S: usize = {};", names.len()));
    w.blank();
    if names.is_empty() {
        return;
    }
    w.doc(&Doc::of(format!(
        "Names of the {what}, as the model writes them."
    )));
    let strings = names
        .iter()
        .map(|name| Array::Simple(format!("\"{}\"", name.escape_debug())));
    let opening = format!("pub const {word}_NAMES: [&str; {word}S] =");
    w.constant(&opening, &Array::Row(strings.collect()));
    w.blank();
}
