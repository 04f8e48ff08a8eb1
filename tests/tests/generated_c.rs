//! Generated C compiles without a warning, in `float` and `double`, and agrees with the
//! tape.

use dynamics_codegen::derive::Expansion;
use dynamics_codegen::emit::{
    self, Array, Emission, Entry, Functions, Routine, c_member, module_name,
};
use dynamics_codegen::graph::{Binary, Graph, Unary};
use dynamics_codegen::{Compiled, Tape};
use integration_tests::c_program::{self, run};
use integration_tests::compiler::{self, Precision};
use integration_tests::{models, random};
use rand::RngExt;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

const STATES: usize = 50;

/// Largest deviation over all states, relative to the largest entry of the quantity.
fn deviation(compiled: &Compiled, path: &str, precision: Precision) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let emission = Emission::new(compiled, path, &Functions::full()).unwrap();
    let program = c_program::build(&emission, compiled, folder.path(), precision);
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
    let mut found = run(&program, &samples.concat()).into_iter();
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

/// No model's C deviates by more than a share. Compilers take most of the time, so every core gets one.
fn agrees_with_the_tape(precision: Precision, share: f64) {
    let models = all_with_loops();
    let next = AtomicUsize::new(0);
    let check = || {
        while let Some((path, compiled)) = models.get(next.fetch_add(1, Ordering::Relaxed)) {
            let worst = deviation(compiled, path, precision);
            println!("{path}: {worst:.1e}");
            assert!(worst <= share, "{path}: {worst:e}");
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| (0..cores).for_each(|_| drop(scope.spawn(check))));
}

#[test]
fn double_agrees_with_the_tape() {
    agrees_with_the_tape(Precision::Double, 1e-12);
}

#[test]
fn float_agrees_to_its_precision() {
    if left_out::too_slow() {
        return;
    }
    // Rounding of 6e-8, by mass matrices of random states whose condition is some thousands.
    agrees_with_the_tape(Precision::Single, 5e-4);
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
        assert_eq!(run(&program, &[]), compiled.model.nominal_parameters());
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
        let found = run(
            &program,
            &[
                1.0,
                2.0,
                3.0,
                4.0,
                -1.0,
                -2.0,
                5.0,
                0.0,
                f64::NAN,
                1.0,
                0.0,
                0.0,
                1.0,
                f64::NAN,
                0.0,
                0.0,
            ],
        );
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
