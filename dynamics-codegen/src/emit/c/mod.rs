//! C99 source for firmware: one `.h` and one `.c` per model.
//!
//! No dependency but `<math.h>`; `double`, or `float` with `DYNAMICS_FLOAT`; no
//! allocation, no recursion, no loop, no array of variable length, no state. Every
//! name that the linker sees begins with the model's.

mod header_file;
mod language;
mod source_file;

use super::plan::{Function, functions, quantities};
use super::rust::{File, module_name};
use super::symbols::Symbols;
use super::text::c_comment_lines;
use super::{header, plan};
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
    let quantities = quantities(compiled);
    let functions = functions(&quantities);
    let unit = Unit::new(compiled, source_name);
    let file = |ending: &str, text: String| File {
        name: format!("{}.{ending}", unit.file),
        text,
    };
    [
        file("h", unit.header_file(&functions)),
        file("c", unit.source_file(&functions)),
    ]
}

/// What both files refer to.
struct Unit<'a> {
    compiled: &'a Compiled,
    source_name: &'a str,
    symbols: Symbols,
    /// The files' name without its ending.
    file: String,
    /// What global names begin with.
    prefix: String,
}

impl<'a> Unit<'a> {
    fn new(compiled: &'a Compiled, source_name: &'a str) -> Self {
        let file = module_name(compiled);
        // Names that begin with `_` belong to the compiler.
        let prefix = if file.starts_with('_') {
            format!("dynamics{file}")
        } else {
            file.clone()
        };
        let symbols = Symbols::new(&compiled.model, &[&format!("{prefix}_real")]);
        Self {
            compiled,
            source_name,
            symbols,
            file,
            prefix,
        }
    }

    /// Who made the file, and from what.
    fn title(&self, w: &mut Lines) {
        let lines = header::lines(self.compiled, self.source_name, "c");
        comment(w, 0, &lines.join("\n"));
        w.blank();
    }

    /// `void model_quantity(const model_parameters *p, const model_point *x, …)`
    fn signature(&self, w: &mut Lines, function: &Function<'_>, ending: &str) {
        let prefix = &self.prefix;
        let out = if function.is_fused() {
            format!("{prefix}_equation *out")
        } else {
            let quantity: &plan::Quantity = function.quantities[0];
            format!("{prefix}_real out{}", header_file::dimensions(quantity))
        };
        w.line(&format!("void {prefix}_{}(", function.name));
        w.line(&format!("    const {prefix}_parameters *p,"));
        w.line(&format!("    const {prefix}_point *x,"));
        w.line(&format!("    {out}){ending}"));
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
