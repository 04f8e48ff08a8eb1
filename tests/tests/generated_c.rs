//! Generated C compiles without a warning, in `float` and `double`, and agrees with the
//! tape.

use dynamics_codegen::emit::{self, Quantity, identifier, module_name, quantities};
use dynamics_codegen::{Compiled, Model, Tape};
use integration_tests::compiler::{self, Precision};
use integration_tests::{models, random};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const STATES: usize = 50;

/// A program that reads arguments from its input, in the order of `emit::arguments`,
/// and prints every quantity, then the fused struct.
fn driver(compiled: &Compiled, quantities: &[Quantity]) -> String {
    let (model, name) = (&compiled.model, module_name(compiled));
    let mut c = format!("#include \"{name}.h\"\n#include <stdio.h>\n\n");
    let _ = write!(
        c,
        "static int get({name}_real *x) {{ double v; \
         if (scanf(\"%lf\", &v) != 1) return 0; *x = ({name}_real)v; return 1; }}\n\
         static void put(const {name}_real *x, int n) {{ int i; \
         for (i = 0; i < n; i++) printf(\"%.17g\\n\", (double)x[i]); }}\n\
         int main(void) {{\n  {name}_parameters p;\n  {name}_point x;\n  {name}_equation e;\n"
    );
    for q in quantities {
        let shape = q
            .columns
            .as_ref()
            .map_or(String::new(), |c| format!("[{}]", c.len()));
        let _ = writeln!(c, "  {name}_real {}[{}]{shape};", q.name, q.rows.len());
    }
    let _ = writeln!(c, "  p = {name}_nominal;\n  while (get(&x.t)) {{");
    for place in places(model) {
        let _ = writeln!(c, "    if (!get(&{place})) return 1;");
    }
    for q in quantities {
        let first = if q.columns.is_some() { "[0][0]" } else { "[0]" };
        let _ = writeln!(c, "    {name}_{0}(&p, &x, {0});", q.name);
        let _ = writeln!(c, "    put(&{}{first}, {});", q.name, q.entries.len());
    }
    let _ = writeln!(c, "    {name}_equation_of_motion(&p, &x, &e);");
    for q in quantities.iter().filter(|q| FUSED.contains(&q.name)) {
        let first = if q.columns.is_some() { "[0][0]" } else { "[0]" };
        let _ = writeln!(c, "    put(&e.{}{first}, {});", q.name, q.entries.len());
    }
    c.push_str("  }\n  return 0;\n}\n");
    c
}

const FUSED: [&str; 6] = [
    "mass_matrix",
    "force",
    "constraint_jacobian",
    "constraint_bias",
    "constraint_residual",
    "constraint_rate",
];

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
            .map(|p| format!("p.{}", identifier(&p.name))),
    );
    places
}

/// Builds the model's program in `folder`.
fn build(compiled: &Compiled, path: &str, folder: &Path, precision: Precision) -> PathBuf {
    for file in emit::c(compiled, path) {
        std::fs::write(folder.join(&file.name), file.text).unwrap();
    }
    std::fs::write(
        folder.join("main.c"),
        driver(compiled, &quantities(compiled)),
    )
    .unwrap();
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
    let program = build(compiled, path, folder.path(), precision);
    let quantities = quantities(compiled);
    let arguments = emit::arguments(&compiled.model);
    let fused = quantities.iter().filter(|q| FUSED.contains(&q.name));
    let order: Vec<&Quantity> = quantities.iter().chain(fused).collect();
    let tapes: Vec<Tape> = order
        .iter()
        .map(|q| Tape::new(&compiled.model.graph, &q.entries, &arguments))
        .collect();

    let mut rng = random::generator(9);
    let samples: Vec<Vec<f64>> = (0..STATES)
        .map(|_| random::arguments(&compiled.model, &mut rng))
        .collect();
    let mut input = String::new();
    for value in samples.iter().flatten() {
        let _ = writeln!(input, "{value:?}");
    }
    let mut found = run(&program, &input).into_iter();
    let mut worst: f64 = 0.0;
    for sample in &samples {
        for (quantity, tape) in order.iter().zip(&tapes) {
            let expected = tape.evaluate(sample);
            let scale = expected
                .iter()
                .fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
            for expected in expected {
                let found = found.next().expect("a value per entry");
                let error = (found - expected).abs() / scale;
                assert!(error.is_finite(), "{}: {found} {expected}", quantity.name);
                worst = worst.max(error);
            }
        }
    }
    assert_eq!(found.next(), None);
    worst
}

fn all() -> Vec<(String, Compiled)> {
    let mut models = models::all();
    models.push((
        models::EVERYTHING.to_string(),
        models::read(models::EVERYTHING),
    ));
    models
}

#[test]
fn double_agrees_with_the_tape() {
    for (path, compiled) in all() {
        let worst = deviation(&compiled, &path, Precision::Double);
        println!("{path}: {worst:.1e}");
        assert!(worst <= 1e-12, "{path}: {worst:e}");
    }
}

#[test]
fn float_agrees_to_its_precision() {
    for (path, compiled) in all() {
        let worst = deviation(&compiled, &path, Precision::Single);
        println!("{path}: {worst:.1e}");
        assert!(worst <= 2e-4, "{path}: {worst:e}");
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
            let field = identifier(&p.name);
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

/// Nothing that firmware forbids: no loop, no recursion, no allocation, no global that
/// can be written.
#[test]
fn plain_straight_code() {
    for (path, compiled) in all() {
        let [header, source] = emit::c(&compiled, &path);
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

/// The test above can fail: a warning stops the compiler.
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
