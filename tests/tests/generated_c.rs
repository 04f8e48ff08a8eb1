//! Generated C compiles without a warning, in `float` and `double`, and agrees with the
//! tape.

use dynamics_codegen::derive::{Expansion, Term};
use dynamics_codegen::emit::{
    self, Array, Emission, Entry, Functions, Quantity, Routine, c_member, module_name,
};
use dynamics_codegen::graph::{Binary, Graph, Unary};
use dynamics_codegen::{Compiled, Model, Tape};
use integration_tests::compiler::{self, Precision};
use integration_tests::{models, random};
use rand::RngExt;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const STATES: usize = 50;

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
    let k = emit::arguments(model).len() - 1 - 2 * n - z - model.parameters.len();
    let mut places: Vec<String> = (0..n).map(|i| format!("x.q[{i}]")).collect();
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

/// Builds the model's program in `folder`.
fn build(
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

fn run(program: &Path, input: &str) -> Vec<f64> {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let input = input.to_string();
    let writer = std::thread::spawn(move || pipe.write_all(input.as_bytes()).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| line.parse().unwrap()).collect()
}

/// Largest deviation over all states, relative to the largest entry of the quantity.
fn deviation(compiled: &Compiled, path: &str, precision: Precision) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let emission = Emission::new(compiled, path, &Functions::full()).unwrap();
    let program = build(&emission, compiled, folder.path(), precision);
    let quantities = emission.functions().flat_map(|(_, quantities)| quantities);
    let arguments = emission.arguments();
    // What is solved for in loops, in straight lines.
    let mut straight = Expansion::new(compiled);
    let tapes: Vec<(&str, Tape)> = quantities
        .map(|q| {
            let tape = if q.entries.is_empty() {
                let entries = straight.entries(q.item.expect("none is our own"));
                Tape::new(&straight.model.graph, &entries.unwrap(), &arguments)
            } else {
                Tape::new(emission.graph(), &q.entries, &arguments)
            };
            (q.name.as_str(), tape)
        })
        .collect();

    let model = &compiled.model;
    let mut rng = random::generator(9);
    let samples: Vec<Vec<f64>> = (0..STATES)
        .map(|_| {
            let stated = model.coordinates.len() + model.constraints.len();
            let mut sample = random::arguments(model, &mut rng);
            sample.extend((0..stated).map(|_| rng.random_range(-2.0..2.0)));
            sample
        })
        .collect();
    let mut input = String::new();
    for value in samples.iter().flatten() {
        let _ = writeln!(input, "{value:?}");
    }
    let mut found = run(&program, &input).into_iter();
    let mut worst: f64 = 0.0;
    for sample in &samples {
        for (name, tape) in &tapes {
            let expected = tape.evaluate(sample);
            let scale = expected
                .iter()
                .fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
            for expected in expected {
                let found = found.next().expect("a value per entry");
                let error = (found - expected).abs() / scale;
                assert!(error.is_finite(), "{name}: {found} {expected}");
                worst = worst.max(error);
            }
        }
    }
    assert_eq!(found.next(), None);
    worst
}

fn all() -> Vec<(String, Compiled)> {
    let mut models = models::all();
    for fixture in [models::EVERYTHING, models::SENSED, models::TOUCHING] {
        models.push((fixture.to_string(), models::read(fixture)));
    }
    models
}

/// The same, with one that solves in loops.
fn all_with_loops() -> Vec<(String, Compiled)> {
    let mut models = all();
    models.push((models::MANY.to_string(), models::read(models::MANY)));
    models
}

#[test]
fn double_agrees_with_the_tape() {
    for (path, compiled) in all_with_loops() {
        let worst = deviation(&compiled, &path, Precision::Double);
        println!("{path}: {worst:.1e}");
        assert!(worst <= 1e-12, "{path}: {worst:e}");
    }
}

#[test]
fn float_agrees_to_its_precision() {
    if left_out::too_slow() {
        return;
    }
    for (path, compiled) in all_with_loops() {
        let worst = deviation(&compiled, &path, Precision::Single);
        println!("{path}: {worst:.1e}");
        // Rounding of 6e-8, by mass matrices of random states whose condition is some thousands.
        assert!(worst <= 5e-4, "{path}: {worst:e}");
    }
}

/// The nominal parameters arrive, in order.
#[test]
fn nominal_parameters() {
    for (path, compiled) in all() {
        let name = module_name(&compiled);
        let folder = tempfile::tempdir().unwrap();
        for file in emit::c(&compiled, &path) {
            std::fs::write(folder.path().join(&file.name), file.text).unwrap();
        }
        let mut main = format!("#include \"{name}.h\"\n#include <stdio.h>\nint main(void) {{\n");
        for p in &compiled.model.parameters {
            let field = c_member(&p.name);
            let _ = writeln!(
                main,
                "  printf(\"%.17g\\n\", (double){name}_nominal.{field});"
            );
        }
        main.push_str("  return 0;\n}\n");
        let (source, program) = (folder.path().join("main.c"), folder.path().join("program"));
        std::fs::write(&source, main).unwrap();
        let sources = [source, folder.path().join(format!("{name}.c"))];
        compiler::build(&sources, &program, Precision::Double);
        assert_eq!(run(&program, ""), compiled.model.nominal_parameters());
    }
}

/// Nothing that firmware forbids, where not many coordinates are solved for: no loop, no recursion, no allocation, no global that
/// can be written.
#[test]
fn plain_straight_code() {
    for (path, compiled) in all() {
        let [header, source] = Emission::new(&compiled, &path, &Functions::full())
            .unwrap()
            .c();
        for word in [
            "malloc",
            "for (",
            "while",
            "goto",
            "static int",
            "stdio",
            "stdlib",
        ] {
            assert!(
                !source.text.contains(word) && !header.text.contains(word),
                "{path}: {word}"
            );
        }
        let includes: Vec<&str> = source
            .text
            .lines()
            .filter(|l| l.starts_with("#include"))
            .collect();
        let own = format!("#include \"{}\"", header.name);
        assert_eq!(includes, [own.as_str(), "#include <math.h>"]);
        assert!(!header.text.contains("#include"));
    }
}

fn array<E>(name: &str, entries: [(&str, E); 4]) -> Array<E> {
    let entries = entries.map(|(name, value)| {
        let entry = Entry {
            name: name.into(),
            unit: String::new(),
        };
        (entry, value)
    });
    Array {
        name: name.into(),
        meaning: "Numbers".into(),
        entries: entries.into(),
    }
}

/// A routine of one's own, by the C compiler; where a NaN comes in, one comes out.
#[test]
fn a_nan_goes_on() {
    let mut graph = Graph::new();
    let [sx, sy, sz, unused] = ["x", "y", "int", "unused"].map(|name| graph.symbol(name));
    let [x, y, z] = [sx, sy, sz].map(|symbol| graph.var(symbol));
    let results = [
        ("least", graph.binary(Binary::Min, x, y)),
        ("most", graph.binary(Binary::Max, x, y)),
        ("step", graph.unary(Unary::Step, x)),
        ("passed", z),
    ];
    let routine = Routine {
        name: "limits".into(),
        meaning: "Limits".into(),
        source: "By a test.".into(),
        arguments: vec![array(
            "arguments",
            [("x", sx), ("y", sy), ("int", sz), ("unused", unused)],
        )],
        results: vec![array("results", results)],
        graph,
    };
    let folder = tempfile::tempdir().unwrap();
    for file in routine.c() {
        std::fs::write(folder.path().join(&file.name), file.text).unwrap();
    }
    let main = "#include \"limits.h\"\n#include <stdio.h>\n
int main(void)
{
    limits_real x[4];
    double v[4];
    while (scanf(\"%lf %lf %lf %lf\", &v[0], &v[1], &v[2], &v[3]) == 4) {
        int i;
        for (i = 0; i < 4; i++) {
            x[i] = (limits_real)v[i];
        }
        limits(x, x);
        for (i = 0; i < 4; i++) {
            printf(\"%g\\n\", (double)x[i]);
        }
    }
    return 0;
}
";
    let source = folder.path().join("main.c");
    std::fs::write(&source, main).unwrap();
    let sources = [folder.path().join("limits.c"), source];
    for precision in [Precision::Double, Precision::Single] {
        let program = folder.path().join("program");
        compiler::build(&sources, &program, precision);
        let found = run(&program, "1 2 3 4\n-1 -2 5 0\nnan 1 0 0\n1 nan 0 0\n");
        assert_eq!(found[..8], [1.0, 2.0, 1.0, 3.0, -2.0, -1.0, 0.0, 5.0]);
        assert!(
            found[8..11]
                .iter()
                .chain(&found[12..14])
                .all(|x| x.is_nan())
        );
    }
}

/// These tests can fail: a warning stops the compiler.
#[test]
fn a_warning_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("bad.c");
    std::fs::write(
        &source,
        "float f(double x);\nfloat f(double x) { return x; }\n",
    )
    .unwrap();
    let outcome = std::panic::catch_unwind(|| compiler::check(&source, Precision::Double));
    assert!(outcome.is_err());
}
