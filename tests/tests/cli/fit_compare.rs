//! `fit --compare`: semi-parametric models on logs of an independent simulator, whose
//! makers state the errors of their nominal models, and on a machine without inputs.

use crate::support::succeed;
use dynamics_codegen::{Compiled, Library, compile_bytes};
use identify::fit::{
    Base, Comparison, Fit, Inertia, Kind, Request, Row, Settings, Source, compare,
};
use identify::log::Log;
use integration_tests::models;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/scenarios");
const SETTINGS: Settings = Settings {
    points: Some(120),
    seed: 3,
    clock: None,
};

/// The model's parameters with a scenario's nominal values.
fn parameters(compiled: &Compiled, scenario: &str) -> Vec<f64> {
    let text = fs::read_to_string(format!("{DATA}/{scenario}/parameters.json")).unwrap();
    let given: serde_json::Value = serde_json::from_str(&text).unwrap();
    let own = compiled.model.parameters.iter();
    own.map(|p| given[&p.name].as_f64().unwrap_or(p.nominal))
        .collect()
}

fn compared(model: &str, scenario: &str, points: usize) -> (Option<Fit>, Comparison) {
    let compiled = models::one(model);
    let folder = integration_tests::files::root().join("models");
    let text = fs::read_to_string(folder.join(model)).unwrap();
    let mut library = Library::builtin();
    library.look_in(folder);
    let read = |name| Log::read(format!("{DATA}/{scenario}/{name}.csv.gz")).unwrap();
    let (train, test) = (read("train"), read("test"));
    let values = parameters(&compiled, scenario);
    let request = Request {
        test: Some(&test),
        inertia: Inertia::Fixed,
        ..Request::new(
            Source {
                name: model,
                text: &text,
                library: &library,
            },
            &compiled,
            &values,
            &train,
        )
    };
    let settings = Settings {
        points: Some(points),
        ..SETTINGS
    };
    compare(&request, &settings).unwrap()
}

fn row(table: &Comparison, model: Kind, base: Base) -> &Row {
    let found = table
        .rows
        .iter()
        .find(|row| row.model == model && row.base == base);
    found.unwrap_or_else(|| panic!("{model:?} on {base:?}"))
}

fn total(table: &Comparison, model: Kind) -> f64 {
    row(table, model, Base::Given).acceleration.total
}

const LEARNT: [Kind; 3] = [
    Kind::OutputResidual,
    Kind::LatentForce,
    Kind::ContactInvariant,
];

/// A constant drive torque that the model lacks. The simulator's makers give 0.0824 for the
/// nominal model on the test log. `A P = 0`: what passes through the dynamics obeys the
/// rolling constraint to round-off; what is added to the acceleration does not.
#[test]
fn forces_obey_the_constraint_and_accelerations_do_not() {
    if left_out::too_slow() {
        return;
    }
    let (_, table) = compared("unicycle2d.model", "o07_unicycle2d", 300);
    let analytic = total(&table, Kind::Analytic);
    assert!((analytic / 0.0824 - 1.0).abs() < 0.02, "{analytic}");
    for model in LEARNT {
        let error = total(&table, model);
        assert!(error < 0.75 * analytic, "{model:?}: {analytic} -> {error}");
        let found = row(&table, model, Base::Given);
        let miss = found.constraint.unwrap();
        match model {
            Kind::OutputResidual => assert!(miss.max > 1e-3, "{miss:?}"),
            _ => assert!(miss.max < 1e-12, "{model:?}: {miss:?}"),
        }
        assert!(found.evidence.unwrap() > 0.0);
    }
    let directions = &row(&table, Kind::ContactInvariant, Base::Given).processes;
    assert_eq!(directions.len(), 2, "three coordinates, one constraint");
    assert_eq!((table.points, table.seed), (300, 3));
    assert!(table.candidates > 3000 && table.judged > 2000);
}

/// Nothing is missing (0.0159 by the makers), and nothing is learnt from noise.
#[test]
fn on_a_control_no_model_is_worse_than_the_equations() {
    let (fit, table) = compared("cartpole.model", "o06_cartpole", 120);
    let analytic = total(&table, Kind::Analytic);
    assert!((analytic / 0.0159 - 1.0).abs() < 0.03, "{analytic}");
    for model in LEARNT {
        let error = total(&table, model);
        assert!(error < 1.03 * analytic, "{model:?}: {analytic} -> {error}");
    }
    assert!(fit.unwrap().terms.is_empty());
}

/// Viscous friction in one joint: processes make up for most of it, naming it for all.
#[test]
fn a_named_term_is_better_than_a_learnt_one() {
    let (fit, table) = compared("pendulum2.model", "o01_pendulum2", 120);
    assert_eq!(fit.unwrap().terms[0].on, ["j2"]);
    let analytic = total(&table, Kind::Analytic);
    let named = row(&table, Kind::Analytic, Base::Fitted).acceleration.total;
    // The true model's error, by the makers.
    assert!((named / 0.0731 - 1.0).abs() < 0.02, "{named}");
    for model in LEARNT {
        let error = total(&table, model);
        assert!(error < 0.3 * analytic, "{model:?}: {analytic} -> {error}");
        assert!(
            error > 0.98 * named,
            "{model:?}: {error} is below the floor"
        );
        let both = row(&table, model, Base::Fitted).acceleration.total;
        assert!(both < 1.03 * named, "{model:?}: {named} -> {both}");
    }
}

const PASSIVE: &str = "
    model passive; coordinate a: rad;
    body rod { frame: rotate_z(-pi/2) * rotate_z(a); mass: 0.5; center: (0.4, 0, 0);
               inertia: diag(0, 0, 0.01); }
    gravity (0, -9.81, 0);
";

/// A pendulum that swings freely against dry friction, by the semi-implicit Euler method in
/// steps of 10 µs; 12 s at 200 Hz.
fn swing() -> String {
    let (inertia, weight) = (0.5 * 0.16 + 0.01, 0.5 * 9.81 * 0.4);
    let (mut q, mut v, mut csv) = (2.0_f64, 0.0_f64, String::from("t,q_a\n"));
    for k in 0..1_200_000 {
        if k % 500 == 0 {
            writeln!(csv, "{},{q}", 1e-5 * f64::from(k)).unwrap();
        }
        let a = (-weight * q.sin() - 0.05 * (v / 0.1).tanh() - 0.01 * v) / inertia;
        v += 1e-5 * a;
        q += 1e-5 * v;
    }
    csv
}

/// Without inputs there is no force to fit; what the model leaves can be learnt all the same.
#[test]
fn a_machine_without_inputs_is_learnt_too() {
    let library = Library::empty();
    let compiled = compile_bytes("passive.model", PASSIVE.as_bytes(), &library).unwrap();
    let log = Log::from_bytes("swing.csv", swing().as_bytes()).unwrap();
    let request = Request::new(
        Source {
            name: "passive.model",
            text: PASSIVE,
            library: &library,
        },
        &compiled,
        &[],
        &log,
    );
    let (fit, table) = compare(&request, &SETTINGS).unwrap();
    assert!(fit.is_none() && table.notes[0].contains("no input"));
    let analytic = total(&table, Kind::Analytic);
    for model in LEARNT {
        let error = total(&table, model);
        assert!(error < 0.3 * analytic, "{model:?}: {analytic} -> {error}");
        assert!(row(&table, model, Base::Given).constraint.is_none());
    }
    // The last third swings within what the first two thirds have covered.
    assert!(table.split.contains("first two thirds"));
}

/// The same seed gives the same numbers, times aside; the page has every model.
#[test]
fn the_command_prints_one_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    fs::write(path("passive.model"), PASSIVE).unwrap();
    fs::write(path("swing.csv"), swing()).unwrap();
    let name = |path: &Path| path.to_str().unwrap().to_string();
    let (model, log) = (name(&path("passive.model")), name(&path("swing.csv")));
    let common = ["fit", &model, &log, "--compare", "--points", "60"];
    let (page, _) = succeed(&common, "");
    for line in [
        "analytic, as given",
        "+ output residual GP",
        "+ latent force GP (GP²)",
        "+ contact-invariant residual",
        "60 points of",
        "judged by its last third",
        "seed 1",
        "hyper-parameters",
    ] {
        assert!(page.contains(line), "{line} in\n{page}");
    }
    let numbers = || {
        let (text, _) = succeed(&[&common[..], &["--json", "--seed", "5"]].concat(), "");
        let mut found: serde_json::Value = serde_json::from_str(&text).unwrap();
        for row in found["comparison"]["rows"].as_array_mut().unwrap() {
            let seconds = row["training_seconds"].take();
            assert_eq!(seconds.as_f64().is_some(), row["model"] != "analytic");
        }
        found
    };
    let first = numbers();
    assert_eq!(first["comparison"]["rows"].as_array().unwrap().len(), 4);
    assert_eq!(first, numbers());
}
