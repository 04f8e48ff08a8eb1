//! A model's terms as machine code: the emitted C in loops over states, compiled by the system's
//! compiler and loaded.
#![allow(unsafe_code)]

use crate::terms::{Entries, Given};
use dynamics_codegen::Compiled;
use dynamics_codegen::derive::Term;
use dynamics_codegen::emit::{Emission, File, Functions};
use libloading::Library;
use std::collections::HashMap;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;
use std::process::Command;
use std::{fs, io};

/// Terms that are compiled, as far as a model has them.
const TERMS: [Term; 10] = [
    Term::MassMatrix,
    Term::BiasForce,
    Term::AppliedForce,
    Term::InputMatrix,
    Term::Force,
    Term::InverseDynamics,
    Term::ConstraintJacobian,
    Term::ConstraintBias,
    Term::ConstraintResidual,
    Term::ConstraintRate,
];
/// `M` and `Q` of a model without constraints, one behind the other: shared parts are computed once.
const EQUATION: &str = "equation_of_motion";
/// What makes the numbers those of the tapes, and a library of the file.
const OPTIONS: [&str; 5] = [
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fPIC",
    "-shared",
    "-o",
];

/// Rows of numbers as C sees them: null for zeros, no stride for a row that holds for all states.
#[repr(C)]
#[derive(Clone, Copy)]
struct Input {
    values: *const f64,
    stride: usize,
}

/// An emitted function in a loop.
struct Looped {
    name: &'static str,
    /// Numbers per state.
    size: usize,
    takes_acceleration: bool,
}

/// `count` states: parameters, `t, q, v, u, a`, and where the results go.
type Loop = unsafe extern "C" fn(usize, *const f64, *const Input, *mut f64);

/// The loops of one model.
pub struct MachineCode {
    /// By the functions' names.
    loops: HashMap<&'static str, Loop>,
    /// Positions, coordinates, inputs and parameters.
    sizes: [usize; 4],
    /// The loops stand in it.
    _library: Library,
}

/// Why there is none.
#[derive(Debug)]
pub enum Failure {
    /// A model that machine code is not made of.
    Model(&'static str),
    /// The compiler says no.
    Compiler(String),
    /// The system does.
    System(io::Error),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::System(error)
    }
}

impl MachineCode {
    /// Emits, compiles and loads; `shape` says how large a term is.
    ///
    /// # Errors
    /// If the model remembers, or a force depends on a multiplier; if the compiler fails.
    pub fn new(
        compiled: &Compiled,
        compiler: &str,
        options: &[String],
        shape: impl Fn(Term) -> usize,
    ) -> Result<Self, Failure> {
        let model = &compiled.model;
        if !model.states.is_empty() || !model.delays.is_empty() {
            return Err(Failure::Model(
                "a model with internal states or delays is not compiled",
            ));
        }
        if model.uses_multipliers() {
            return Err(Failure::Model(
                "a model whose forces depend on a multiplier is not compiled",
            ));
        }
        let wished: Functions = "inverse_dynamics".parse().unwrap_or_default();
        let emission = Emission::new(compiled, &model.name, &wished)
            .map_err(|_| Failure::Model("the model has no inverse dynamics"))?;
        let n = model.coordinates.len();
        let terms = TERMS.into_iter().map(|term| Looped {
            name: term.name(),
            size: shape(term),
            takes_acceleration: term.takes_acceleration(),
        });
        let mut functions: Vec<Looped> = terms.filter(|term| term.size > 0).collect();
        if model.constraints.is_empty() {
            functions.push(Looped {
                name: EQUATION,
                size: n * n + n,
                takes_acceleration: false,
            });
        }
        let sizes = [
            model.positions().len(),
            n,
            model.inputs.len(),
            model.parameters.len(),
        ];
        let files = emission.c();
        let text = loops(&emission.c_prefix(), &files[1].name, sizes, &functions);
        let folder = tempfile::tempdir()?;
        let library = build(folder.path(), &files, &text, compiler, options)?;
        let mut found = HashMap::new();
        for function in &functions {
            // SAFETY: the text that was just compiled defines a function of this name and type.
            let symbol = unsafe { library.get::<Loop>(function.name) };
            let symbol = symbol.map_err(|error| Failure::Compiler(error.to_string()))?;
            found.insert(function.name, *symbol);
        }
        Ok(Self {
            loops: found,
            sizes,
            _library: library,
        })
    }

    /// Fills rows with a term at a range of the states; says whether it can.
    pub fn evaluate(
        &self,
        term: Term,
        given: &Given<'_>,
        range: &Range<usize>,
        rows: &mut [f64],
    ) -> bool {
        self.run(term.name(), given, range, rows)
    }

    /// Fills rows with `M`, row by row, and `Q` behind it, at a range of the states; says whether it can, which
    /// it can of a model without constraints.
    pub fn equation_of_motion(
        &self,
        given: &Given<'_>,
        range: &Range<usize>,
        rows: &mut [f64],
    ) -> bool {
        self.run(EQUATION, given, range, rows)
    }

    fn run(&self, name: &str, given: &Given<'_>, range: &Range<usize>, rows: &mut [f64]) -> bool {
        let Some(run) = self.loops.get(name) else {
            return false;
        };
        let [positions, n, k, p] = self.sizes;
        assert_eq!(given.parameters.len(), p, "one value per parameter");
        let input = |of: Entries<'_>, width: usize| -> Input {
            let (values, stride) = match of {
                Entries::None => {
                    return Input {
                        values: std::ptr::null(),
                        stride: 0,
                    };
                }
                Entries::Same(row) => (&row[..width], 0),
                Entries::Each(rows) => (&rows[range.start * width..range.end * width], width),
            };
            Input {
                values: values.as_ptr(),
                stride,
            }
        };
        let inputs = [
            input(given.t, 1),
            input(given.q, positions),
            input(given.v, n),
            input(given.u, k),
            input(given.a, n),
        ];
        // SAFETY: the loop reads `range.len()` rows (or the one) of each input, whose slices were
        // just cut to that, and `p` parameters; it writes `range.len()` results, whose size the
        // caller took from the same shape as the loop's text.
        unsafe {
            run(
                range.len(),
                given.parameters.as_ptr(),
                inputs.as_ptr(),
                rows.as_mut_ptr(),
            );
        }
        true
    }
}

/// The text of a loop around each emitted function.
fn loops(
    prefix: &str,
    source: &str,
    [positions, n, k, p]: [usize; 4],
    functions: &[Looped],
) -> String {
    let mut text = format!(
        "#include \"{source}\"\n#include <stddef.h>\n#include <string.h>\n\n\
         struct dynamics_input {{ const double *values; size_t stride; }};\n"
    );
    let mut fields = vec![("t", 1), ("q", positions), ("v", n)];
    if k > 0 {
        fields.push(("u", k));
    }
    for &Looped {
        name,
        size,
        takes_acceleration,
    } in functions
    {
        let mut body = String::new();
        for (index, (field, width)) in fields.iter().enumerate() {
            let of = match *field {
                "t" => "&x.t".to_owned(),
                field => format!("x.{field}"),
            };
            // Writing to a string cannot fail.
            let _ = writeln!(
                body,
                "        if (in[{index}].values) \
                 memcpy({of}, in[{index}].values + i * in[{index}].stride, {width} * sizeof(double));"
            );
        }
        let (before, argument) = match takes_acceleration {
            true => (
                format!(
                    "        if (in[4].values) \
                     memcpy(a, in[4].values + i * in[4].stride, {n} * sizeof(double));\n"
                ),
                "a, ",
            ),
            false => (String::new(), ""),
        };
        let parameters = match p {
            0 => String::new(),
            p => format!("    memcpy(&p, parameters, {p} * sizeof(double));\n"),
        };
        let _ = write!(
            text,
            "\nvoid {name}(size_t count, const double *parameters, \
             const struct dynamics_input *in, double *out) {{\n\
             \x20   {prefix}_parameters p;\n    {prefix}_point x;\n    double a[{n}];\n\
             \x20   memset(&p, 0, sizeof p);\n    memset(&x, 0, sizeof x);\n    memset(a, 0, sizeof a);\n\
             {parameters}\
             \x20   for (size_t i = 0; i < count; i++) {{\n{body}{before}\
             \x20       {prefix}_{name}(&p, &x, {argument}(void *)(out + i * {size}));\n    }}\n}}\n"
        );
    }
    text
}

/// Compiles the text beside the emitted files, and loads the library.
fn build(
    folder: &Path,
    files: &[File],
    text: &str,
    compiler: &str,
    options: &[String],
) -> Result<Library, Failure> {
    for file in files {
        fs::write(folder.join(&file.name), &file.text)?;
    }
    // No emitted name has a dash.
    let (source, library) = (folder.join("all-loops.c"), folder.join("all-loops.so"));
    fs::write(&source, text)?;
    let mut command = Command::new(compiler);
    command.args(options).args(OPTIONS).arg(&library);
    let done = command.arg(&source).arg("-lm").output()?;
    if !done.status.success() {
        let said = String::from_utf8_lossy(&done.stderr);
        return Err(Failure::Compiler(format!("`{compiler}` fails:\n{said}")));
    }
    // SAFETY: loading runs no code of the library: the text has no constructor, and its names
    // are those of functions, however the model is called.
    let library = unsafe { Library::new(&library) };
    library.map_err(|error| Failure::Compiler(error.to_string()))
}
