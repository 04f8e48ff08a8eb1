//! Parameters folded in: the same equations with numbers, and fewer operations.

use dynamics_codegen::build::{Error, ModelFile};
use dynamics_codegen::emit::{operation_counts, quantities, rust};
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::{Compiled, Library, System, Variables, compile, compile_keeping};
use std::path::Path;

/// All entries of all quantities at one point, with these parameters.
fn values(compiled: &Compiled, parameters: &[f64]) -> Vec<f64> {
    let model = &compiled.model;
    let arguments = System::arguments(model);
    let states = arguments.len() - model.parameters.len();
    let mut symbols = vec![0.0; model.graph.symbol_count()];
    for (index, argument) in arguments.iter().enumerate() {
        symbols[argument.index()] = match index.checked_sub(states) {
            Some(parameter) => parameters[parameter],
            None => 0.3 + 0.17 * index as f64,
        };
    }
    let entries: Vec<ExprId> = quantities(compiled)
        .iter()
        .flat_map(|quantity| quantity.entries.clone())
        .collect();
    model.graph.evaluate(&entries, &symbols)
}

fn models() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let mut found: Vec<(String, String)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "model"))
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            (path.display().to_string(), text)
        })
        .collect();
    found.sort();
    assert!(found.len() >= 8);
    found.push(("bodies.model".into(), BODIES.into()));
    found
}

#[test]
fn folding_changes_no_value_and_saves_operations() {
    let mut library = Library::builtin();
    library.look_in(Path::new(env!("CARGO_MANIFEST_DIR")).join("../models"));
    for (name, text) in models() {
        let whole = compile(&name, &text, &library).unwrap();
        let nominal = whole.model.nominal_parameters();
        let first = whole.model.parameters.first().map(|p| p.name.clone());
        let expected = values(&whole, &nominal);
        for keep in [Vec::new(), first.into_iter().collect()] {
            let variables = Variables::only(keep.clone());
            let folded = compile_keeping(&name, &text, &library, &variables).unwrap();
            let kept: Vec<&String> = folded.model.parameters.iter().map(|p| &p.name).collect();
            assert_eq!(kept, keep.iter().collect::<Vec<_>>(), "{name}");
            assert_eq!(
                folded.model.fixed.len() + keep.len(),
                nominal.len(),
                "{name}"
            );
            let found = values(&folded, &folded.model.nominal_parameters());
            assert_eq!(found.len(), expected.len());
            for (a, b) in found.iter().zip(&expected) {
                let scale = 1.0 + b.abs();
                assert!((a - b).abs() < 1e-12 * scale, "{name}: {a} for {b}");
            }
            let total = |compiled: &Compiled| -> usize {
                let counts = operation_counts(compiled);
                counts.iter().map(|(_, count)| count.total()).sum()
            };
            assert!(total(&folded) <= total(&whole), "{name}");
            assert!(rust(&folded, &name).contains("// Folded in:  "), "{name}");
        }
    }
}

const BODIES: &str = "
    model swing;
    coordinate yaw: rad;
    coordinate pitch: rad;
    input pitch: N*m;
    parameter m: kg = 2;
    parameter h: m = 0.3;
    parameter i_t: kg*m^2 = 0.04;
    parameter g: m/s^2 = 9.81;
    frame hub = rotate_z(yaw) * translate(0, 0, h);
    body bob { frame: hub * rotate_y(pitch) * translate(0, 0, -h); mass: m; inertia: diag(i_t, i_t, i_t/2); }
    gravity (0, 0, -g);
    force pitch = input(pitch);
    output height = position(bob).z;
";

const SPRING: &str = "
    model spring;
    coordinate x: m;
    parameter m: kg = 1;
    parameter k: N/m = 0;
    parameter l: m^2 = -1;
    kinetic m/2*dot(x)^2;
    force x = -k*x;
";

#[test]
fn what_vanishes_is_not_computed() {
    let variables = Variables::only(["m"]);
    let folded = compile_keeping("s", SPRING, &Library::empty(), &variables).unwrap();
    assert!(folded.model.graph.is_zero(folded.system.force[0]));
}

#[test]
fn effects_keep_their_own_parameters() {
    let text = SPRING.replace("force x", "effect viscous(x) { d = 2 }\nforce x");
    let variables = Variables::only(["viscous_x_d"]);
    let folded = compile_keeping("s", &text, &Library::builtin(), &variables).unwrap();
    assert_eq!(folded.model.parameters.len(), 1);
    assert_eq!(folded.model.effects[0].parameters, [0]);
    let none = compile_keeping("s", &text, &Library::builtin(), &Variables::only(["m"])).unwrap();
    assert!(none.model.effects[0].parameters.is_empty());
}

#[test]
fn values_that_mean_nothing_are_refused() {
    let root = SPRING.replace("-k*x", "-m*sqrt(l)/t^2");
    let error = compile_keeping(
        "spring.model",
        &root,
        &Library::empty(),
        &Variables::only(["m"]),
    )
    .unwrap_err();
    assert_eq!(
        error.render(),
        "error: this is not a finite number\n --> spring.model:8:18\n  |\n\
         8 |     force x = -m*sqrt(l)/t^2;\n  |                  ^^^^^^^ its value is NaN\n  |\n\
         help: parameters that are not kept variable count with the values stated: \
         change the value, or keep the parameter"
    );
    // With everything variable it is the user's choice of values that counts.
    assert!(compile("spring.model", &root, &Library::empty()).is_ok());
}

#[test]
fn unknown_names_find_their_nearest() {
    let folded = compile_keeping("s", SPRING, &Library::empty(), &Variables::only(["m"])).unwrap();
    let unknown = Variables::only(["m", "kk", "stiffness"]).unknown(&folded.model);
    assert_eq!(unknown[0], ("kk".into(), "did you mean `k`?".into()));
    assert_eq!(unknown[1].1, "the model's parameters are: m, k, l");
}

#[test]
fn files_are_named_as_given() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = ModelFile::new("models/pendulum.model")
        .root(&root)
        .effects("models/effects")
        .keep(["l"])
        .read()
        .unwrap();
    assert_eq!(read.files[0], root.join("models/pendulum.model"));
    assert!(read.files.len() > 5);
    assert_eq!(read.compiled.model.parameters[0].name, "l");

    let missing = ModelFile::new("models/no.model")
        .root(&root)
        .read()
        .unwrap_err();
    assert!(matches!(missing, Error::Unreadable { .. }));
    let shown = format!("{missing:?}");
    assert!(
        shown.starts_with("cannot read `models/no.model`: "),
        "{shown}"
    );
    // Outside of a build script.
    let error = ModelFile::new(root.join("models/pendulum.model"))
        .write()
        .unwrap_err();
    assert!(matches!(error, Error::NoOutDir));
}
