//! Rust source: one module per model, generic over the scalar.
//!
//! The module refers to nothing but `::dynamics` and `core`, so that it can be a file of
//! a crate or be included. It holds
//!
//! * sizes, names and places (`COORDINATES`, `COORDINATE_NAMES`, `Q_THETA`, …),
//! * `Parameters<T>`,
//! * a function `(&Parameters<T>, &Point<T, …>) -> [[T; n]; m]` per
//!   [quantity](super::quantities) that the model has,
//! * `equation_of_motion`, which computes what a step of a simulation needs at once,
//! * a type named after the model that implements `::dynamics::System`.

mod derivatives;
mod documentation;
mod function;
mod language;
mod layout;
mod library;
mod parameters;
mod solved;
mod system;

pub use library::{DuplicateModel, File, module_name, rust_crate, rust_crate_of, rust_file};

use super::axes::inputs;
use super::emission::Emission;
use super::header;
use super::indices::indices;
use super::naming::{identifier, type_name};
use super::plan::{Function, Plan};
use super::symbols::Symbols;
use super::text::one_line;
use crate::compile::Compiled;
use crate::model::Delay;
use documentation::{Doc, code};
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
            symbols: plan.symbols(&[], identifier),
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
        self.carries(w);
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

    /// `Point<T, n, k, s>`, and the number of positions behind it if that is another.
    fn point(&self) -> String {
        let model = &self.compiled.model;
        format!(
            "Point<T, {}, {}, {}{}>",
            model.coordinates.len(),
            inputs(model).len(),
            model.states.len(),
            self.and_positions()
        )
    }

    /// `, n + p`, the number of positions, where it is not that of the velocities.
    fn and_positions(&self) -> String {
        let model = &self.compiled.model;
        match model.poses.len() {
            0 => String::new(),
            poses => format!(", {}", model.coordinates.len() + poses),
        }
    }

    /// `COORDINATES`, `COORDINATE_NAMES`, …
    fn sizes(&self, w: &mut Writer) {
        let model = &self.compiled.model;
        let coordinates = model.coordinates.iter().map(|c| c.name.as_str()).collect();
        if model.poses.is_empty() {
            size(w, "COORDINATE", "coordinates", coordinates);
        } else {
            let positions = model.positions();
            let positions = positions.iter().map(|p| p.name.as_str()).collect();
            size(w, "POSITION", "positions", positions);
            self.poses_constant(w);
            size(w, "COORDINATE", "velocities", coordinates);
        }
        let entries = inputs(model);
        size(
            w,
            "INPUT",
            "inputs",
            entries.iter().map(|u| u.name.as_str()).collect(),
        );
        self.delays(w);
        if !model.states.is_empty() {
            let states = model.states.iter().map(|z| z.name.as_str()).collect();
            size(w, "STATE", "internal states", states);
        }
        let constraints = model.constraints.iter().map(|c| c.name.as_str()).collect();
        size(w, "CONSTRAINT", "constraint rows", constraints);
        if !model.contacts.is_empty() {
            let contacts = model.contacts.iter().map(|c| c.name.as_str()).collect();
            size(w, "CONTACT", "contacts", contacts);
        }
        size(
            w,
            "OUTPUT",
            "outputs",
            model.outputs.iter().map(|o| o.name.as_str()).collect(),
        );
        if !model.sensors.is_empty() {
            let sensors = model.sensors.iter().map(|s| s.name.as_str()).collect();
            size(w, "SENSOR", "sensors", sensors);
        }
        size(
            w,
            "PARAMETER",
            "parameters",
            model.parameters.iter().map(|p| p.name.as_str()).collect(),
        );
        self.index_names(w);
    }

    /// Where the poses of floating bodies stand.
    fn poses_constant(&self, w: &mut Writer) {
        let places = self.compiled.model.pose_places();
        w.doc(&Doc::of(
            "Where the poses of floating bodies stand among positions and velocities.",
        ));
        let opening = format!("pub const POSES: [::dynamics::Pose; {}] =", places.len());
        let pose = |[q, v]: [usize; 2]| Array::Other(format!("::dynamics::Pose::at({q}, {v})"));
        w.constant(
            &opening,
            &Array::Row(places.into_iter().map(pose).collect()),
        );
        w.blank();
    }

    /// `Q_THETA`, `U_MOTOR`, …
    fn index_names(&self, w: &mut Writer) {
        for indices in indices(&self.compiled.model) {
            for index in indices.in_capitals() {
                let (what, name) = (indices.what, code(&index.name));
                w.doc(&Doc::of(format!(
                    "Place of the {what} {name} in {}.",
                    indices.arrays
                )));
                w.line(format!(
                    "pub const {}: usize = {};",
                    index.code, index.place
                ));
                w.blank();
            }
        }
    }
}

impl Unit<'_> {
    /// What a caller must know of inputs that arrive late.
    fn delays(&self, w: &mut Writer) {
        let model = &self.compiled.model;
        if model.delays.is_empty() {
            return;
        }
        let mut doc =
            Doc::of("Delayed inputs, and which input each is. The caller keeps the past:");
        doc.line("");
        for delay in &model.delays {
            doc.line(format!(
                "* {} is {} as it was {} seconds ago",
                code(&delay.name),
                code(&model.inputs[delay.input].name),
                code(&self.delay_text(delay)),
            ));
        }
        w.doc(&doc);
        let pairs = model.delays.iter().enumerate().map(|(index, delay)| {
            let place = model.inputs.len() + index;
            Array::Simple(format!("({place}, {})", delay.input))
        });
        let opening = format!(
            "pub const DELAYED_INPUTS: [(usize, usize); {}] =",
            model.delays.len()
        );
        w.constant(&opening, &Array::Row(pairs.collect()));
        w.blank();
    }

    fn delay_text(&self, delay: &Delay) -> String {
        let graph = &self.compiled.model.graph;
        let name = |id| one_line(graph.symbol_name(id));
        graph.display(delay.by, name).to_string()
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
    w.doc(&Doc::of(format!(
        "Names of the {what}, as the model writes them."
    )));
    if names.is_empty() {
        w.line(format!("pub const {word}_NAMES: [&str; {word}S] = [];"));
        w.blank();
        return;
    }
    let strings = names
        .iter()
        .map(|name| Array::Simple(format!("\"{}\"", name.escape_debug())));
    let opening = format!("pub const {word}_NAMES: [&str; {word}S] =");
    w.constant(&opening, &Array::Row(strings.collect()));
    w.blank();
}
