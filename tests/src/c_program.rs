//! A program around generated C: it reads arguments and prints what every function computes.

use crate::compiler::{self, Precision};
use dynamics_codegen::derive::Term;
use dynamics_codegen::emit::{self, Emission, Quantity, c_member, module_name};
use dynamics_codegen::{Compiled, Model};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// `[0]` once less than the array has axes: its first element, with `&` in front.
fn first(quantity: &Quantity) -> String {
    "[0]".repeat(quantity.axes.len())
}

/// A program that reads arguments from its input, in the order of
/// `Emission::arguments`, and prints what every function computes.
fn driver(emission: &Emission<'_>, compiled: &Compiled) -> String {
    let (model, name) = (&compiled.model, module_name(compiled));
    let stated = [
        ("a", model.coordinates.len()),
        ("lambda", model.constraints.len()),
    ];
    let stated = stated.map(|(array, length)| (array, length.max(1), length));
    let mut c = format!("#include \"{name}.h\"\n#include <stdio.h>\n\n");
    let _ = write!(
        c,
        "static int get({name}_real *x) {{ double v; \
         if (scanf(\"%lf\", &v) != 1) return 0; *x = ({name}_real)v; return 1; }}\n\
         static void put(const {name}_real *x, int n) {{ int i; \
         for (i = 0; i < n; i++) printf(\"%.17g\\n\", (double)x[i]); }}\n\
         int main(void) {{\n  {name}_parameters p;\n  {name}_point x;\n"
    );
    for (array, length, _) in stated {
        let _ = writeln!(c, "  {name}_real {array}[{length}];");
    }
    for (function, quantities) in emission.functions() {
        match result_type(function, quantities, &name) {
            Some(result) => {
                let _ = writeln!(c, "  static {result} r_{function};");
            }
            None => {
                let shape = quantities[0].shape().into_iter();
                let shape: String = shape.map(|length| format!("[{length}]")).collect();
                let _ = writeln!(c, "  {name}_real r_{function}{shape};");
            }
        }
    }
    let _ = writeln!(c, "  p = {name}_nominal;\n  while (get(&x.t)) {{");
    for place in places(model) {
        let _ = writeln!(c, "    if (!get(&{place})) return 1;");
    }
    for (array, _, length) in stated {
        for index in 0..length {
            let _ = writeln!(c, "    if (!get(&{array}[{index}])) return 1;");
        }
        let _ = writeln!(c, "    (void){array};");
    }
    for (function, quantities) in emission.functions() {
        let takes = |which: fn(Term) -> bool| {
            quantities
                .iter()
                .filter_map(|q| q.item)
                .any(|i| which(i.term))
        };
        let a = if takes(Term::takes_acceleration) {
            ", a"
        } else {
            ""
        };
        let lambda = takes(Term::takes_multipliers) && !model.constraints.is_empty();
        let lambda = if lambda { ", lambda" } else { "" };
        let fused = result_type(function, quantities, &name).is_some();
        let address = if fused { "&" } else { "" };
        let _ = writeln!(
            c,
            "    {name}_{function}(&p, &x{a}{lambda}, {address}r_{function});"
        );
        for q in quantities {
            let field = if fused {
                format!(".{}", q.name)
            } else {
                String::new()
            };
            let first = first(q);
            let _ = writeln!(
                c,
                "    put(&r_{function}{field}{first}, {});",
                q.shape().iter().product::<usize>()
            );
        }
    }
    c.push_str("  }\n  return 0;\n}\n");
    c
}

/// The struct that a function of several quantities fills.
fn result_type(function: &str, quantities: &[Quantity], prefix: &str) -> Option<String> {
    match function {
        "equation_of_motion" => Some(format!("{prefix}_equation")),
        name if quantities.len() == 1 && quantities[0].name == name => None,
        name => Some(format!("{prefix}_{name}_result")),
    }
}

/// Where the arguments behind `t` go.
fn places(model: &Model) -> Vec<String> {
    let (n, z) = (model.coordinates.len(), model.states.len());
    let positions = model.positions().len();
    let k = emit::arguments(model).len() - 1 - positions - n - z - model.parameters.len();
    let mut places: Vec<String> = (0..positions).map(|i| format!("x.q[{i}]")).collect();
    places.extend((0..n).map(|i| format!("x.v[{i}]")));
    places.extend((0..k).map(|i| format!("x.u[{i}]")));
    places.extend((0..z).map(|i| format!("x.z[{i}]")));
    places.extend(
        model
            .parameters
            .iter()
            .map(|p| format!("p.{}", c_member(&p.name))),
    );
    places
}

/// Writes what is emitted for a model, with a program around it, into `folder`, and builds it.
///
/// # Panics
/// If a file cannot be written or does not compile without a warning.
pub fn build(
    emission: &Emission<'_>,
    compiled: &Compiled,
    folder: &Path,
    precision: Precision,
) -> PathBuf {
    for file in emission.c() {
        std::fs::write(folder.join(&file.name), file.text).unwrap();
    }
    std::fs::write(folder.join("main.c"), driver(emission, compiled)).unwrap();
    let source = folder.join(format!("{}.c", module_name(compiled)));
    let program = folder.join("program");
    compiler::build(&[source, folder.join("main.c")], &program, precision);
    program
}

/// Runs a program with the arguments of any number of states one behind the other, each in the
/// order of [`Emission::arguments`]; what it prints.
///
/// # Panics
/// If it fails or prints what is no number.
pub fn run(program: &Path, arguments: &[f64]) -> Vec<f64> {
    let input: String = arguments.iter().map(|x| format!("{x:?}\n")).collect();
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || pipe.write_all(input.as_bytes()).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| line.parse().unwrap()).collect()
}
