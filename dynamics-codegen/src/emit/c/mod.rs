//! C99 source for firmware: one `.h` and one `.c` per model.
//!
//! No dependency but `<math.h>`; `double`, or `float` with `DYNAMICS_FLOAT`; no
//! allocation, no recursion, no array of variable length, no state; no loop, but where many
//! coordinates are solved for ([`solved`](super::solved)), and those of fixed length. Every
//! name that the linker sees begins with the model's, and no name is one that a standard
//! header defines as a macro, in whichever order files include them.

mod header_file;
mod language;
mod long;
mod routine;
mod solved;
mod solver;
mod source_file;

use super::emission::Emission;
use super::header;
use super::naming::c_member;
use super::plan::{Function, Plan};
use super::rust::{File, module_name};
use super::symbols::Symbols;
use super::text::c_comment_lines;
use super::words::is_c_header;
use crate::compile::Compiled;

/// The two files of a model, header first. `source_name` is the model's path as their
/// first lines are to name it.
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
/// let [header, source] = emit::c(&compiled, "slider.model");
/// assert_eq!((header.name.as_str(), source.name.as_str()), ("slider.h", "slider.c"));
/// assert!(header.text.contains("void slider_mass_matrix("));
/// # Ok::<(), dynamics_codegen::Report>(())
/// ```
pub fn c(compiled: &Compiled, source_name: &str) -> [File; 2] {
    Emission::terms(compiled, source_name).c()
}

impl Emission<'_> {
    /// What the names of everything in the C files begin with, before an underscore.
    pub fn c_prefix(&self) -> String {
        Unit::new(self).prefix
    }

    /// The two files of C; see [`c`].
    pub fn c(&self) -> [File; 2] {
        let unit = Unit::new(self);
        let file = |ending: &str, text: String| File {
            name: format!("{}.{ending}", unit.file),
            text,
        };
        [file("h", unit.header_file()), file("c", unit.source_file())]
    }
}

/// What both files refer to.
struct Unit<'a> {
    emission: &'a Emission<'a>,
    plan: &'a Plan,
    symbols: Symbols,
    /// The files' name without its ending.
    file: String,
    /// What global names begin with.
    prefix: String,
}

impl<'a> Unit<'a> {
    fn new(emission: &'a Emission<'a>) -> Self {
        let name = module_name(emission.compiled);
        // `#include <math.h>` must not find a model of that name.
        let file = if is_c_header(&name) {
            format!("{name}__")
        } else {
            name.clone()
        };
        // Names that begin with `_` belong to the compiler.
        let prefix = if name.starts_with('_') {
            format!("dynamics{name}")
        } else {
            name
        };
        let real = format!("{prefix}_real");
        let symbols = emission.plan.symbols(&[&real], c_member);
        Self {
            emission,
            plan: &emission.plan,
            symbols,
            file,
            prefix,
        }
    }

    /// Who made the file, and from what.
    fn title(&self, w: &mut Lines) {
        let lines = header::lines(self.emission, "c");
        comment(w, 0, &lines.join("\n"));
        w.blank();
    }

    /// `void model_quantity(const model_parameters *p, const model_point *x, …)`
    fn signature(&self, w: &mut Lines, function: &Function, ending: &str) {
        let prefix = &self.prefix;
        let out = if function.fused {
            format!("{} *out", self.result_type(function))
        } else {
            let dimensions = header_file::dimensions(&function.quantities[0]);
            format!("{prefix}_real out{dimensions}")
        };
        w.line(&format!("void {prefix}_{}(", function.name));
        w.line(&format!("    const {prefix}_parameters *p,"));
        w.line(&format!("    const {prefix}_point *x,"));
        let model = &self.plan.model;
        if function.takes_acceleration() {
            let n = model.coordinates.len();
            w.line(&format!("    const {prefix}_real a[{n}],"));
        }
        if function.takes_multipliers() && !model.constraints.is_empty() {
            let m = model.constraints.len();
            w.line(&format!("    const {prefix}_real lambda[{m}],"));
        }
        w.line(&format!("    {out}){ending}"));
    }

    /// The struct that a function of several quantities fills.
    fn result_type(&self, function: &Function) -> String {
        match function.name.as_str() {
            "equation_of_motion" => format!("{}_equation", self.prefix),
            name => format!("{}_{name}_result", self.prefix),
        }
    }
}

/// Text, line by line.
#[derive(Default)]
struct Lines {
    text: String,
}

impl Lines {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn blank(&mut self) {
        self.text.push('\n');
    }
}

/// A block comment.
fn comment(w: &mut Lines, depth: usize, text: &str) {
    let indent = "    ".repeat(depth);
    match c_comment_lines(text).as_slice() {
        [] => {}
        [line] => w.line(&format!("{indent}/* {line} */")),
        lines => {
            w.line(&format!("{indent}/*"));
            for line in lines {
                w.line(format!("{indent} * {line}").trim_end());
            }
            w.line(&format!("{indent} */"));
        }
    }
}
