//! Frames of every shape: those that nothing moves, that expressions move, that hold
//! nothing. All functions can be had of them, and derivatives are those of the values.

use dynamics_codegen::derive::{Group, Term};
use dynamics_codegen::emit::{Emission, Quantity};
use dynamics_codegen::{Compiled, Library, compile};
use std::collections::BTreeMap;

/// Central differences are this exact beside the largest entry.
const TOLERANCE: f64 = 1e-6;
const STEP: f64 = 1e-5;

fn compiled(text: &str) -> Compiled {
    let text = format!("model m;\ncoordinate z: m;\nparameter m: kg = 2;\n{text}\n");
    compile("m.model", &text, &Library::builtin()).unwrap_or_else(|report| panic!("{report}"))
}

/// Values of all symbols, no two alike.
fn symbols(emission: &Emission<'_>) -> Vec<f64> {
    let count = emission.graph().symbol_count();
    (0..count)
        .map(|i| 0.4 + 0.37 * (1.7 * i as f64).sin())
        .collect()
}

/// Compares every derivative by positions and velocities with differences of the value.
fn check(text: &str) {
    let compiled = compiled(text);
    let model = &compiled.model;
    let constrained = if model.constraints.is_empty() {
        ""
    } else {
        ",acceleration_residual"
    };
    let functions = format!("full,force_residual{constrained}").parse().unwrap();
    let emission = Emission::new(&compiled, "m.model", &functions)
        .unwrap_or_else(|error| panic!("{text}: {error}"));
    syn::parse_file(&emission.rust()).unwrap();
    assert!(emission.c().iter().all(|file| !file.text.is_empty()));
    let quantities: Vec<&Quantity> = emission.functions().flat_map(|(_, q)| q).collect();
    let values: BTreeMap<Term, &Quantity> = (quantities.iter())
        .filter_map(|q| {
            q.item
                .filter(|item| item.by.is_none())
                .map(|item| (item.term, *q))
        })
        .collect();
    let mut compared = 0;
    for slope in &quantities {
        let Some(item) = slope.item else { continue };
        let variables: Vec<_> = match item.by {
            Some(Group::Position) => model.coordinates.iter().map(|c| c.position).collect(),
            Some(Group::Velocity) => model.coordinates.iter().map(|c| c.velocity).collect(),
            _ => continue,
        };
        let at = symbols(&emission);
        let evaluate =
            |quantity: &Quantity, at: &[f64]| emission.graph().evaluate(&quantity.entries, at);
        let found = evaluate(slope, &at);
        let scale = found.iter().fold(1.0_f64, |l, x| l.max(x.abs()));
        for (column, variable) in variables.iter().enumerate() {
            let moved = |by: f64| {
                let mut at = at.clone();
                at[variable.index()] += by;
                evaluate(values[&item.term], &at)
            };
            let (low, high) = (moved(-STEP), moved(STEP));
            for row in 0..low.len() {
                let expected = (high[row] - low[row]) / (2.0 * STEP);
                let found = found[row * variables.len() + column];
                assert!(
                    (found - expected).abs() <= TOLERANCE * scale,
                    "{text}\n{item}, row {row}, column {column}: {found}, not {expected}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 0, "nothing to compare");
}

const ENERGY: &str = "constant g: m/s^2 = 9.81; kinetic m/2*dot(z)^2; potential m*g*z;";

#[test]
fn frames_that_nothing_moves() {
    for frame in [
        "frame f = world;",
        "frame f = translate(0, 0, 1) * rotate_x(0.3);",
        "frame f = rotate_y(1); frame k = f * translate(1, 2, 3); frame h = k * rotate_z(pi);",
        "frame f = world; output p = position(f);",
        "frame f = translate(1, 0, 2); output v = velocity(f).x + dot(z);",
        "frame f = translate(1, 0, 2); force at(f) = (1, 2, 3);",
        "frame f = rotate_x(1); torque at(f) in f = (1, 2, 3);",
        "frame f = translate(0, 0, 1); constraint c: z == 2*position(f).z;",
        "frame f = rotate_z(0.2); body b { frame: f; mass: 1; }",
    ] {
        check(&format!("{ENERGY} {frame}"));
    }
}

#[test]
fn frames_that_move_and_hold_nothing() {
    for frame in [
        "frame f = translate(0, 0, z); output p = position(f);",
        "frame f = translate(0, 0, z); force at(f) = (0, 0, 3);",
        "frame f = translate(0, z, 0) * rotate_x(0.2); constraint c: position(f).y == 0.3;",
    ] {
        check(&format!("{ENERGY} {frame}"));
    }
}

/// Joints that follow expressions of several coordinates, or of time alone.
#[test]
fn frames_that_expressions_move() {
    let two = "coordinate w: m; kinetic m/2*dot(w)^2; constant l: m = 1; constant s: s = 1;";
    for frame in [
        "frame f = translate(0.3*l*(t/s)^2, 0, 0);",
        "frame f = rotate_z(sin(t/s)); output p = position(f);",
        "body b { frame: rotate_z(t/s) * translate(z, 0, 0); mass: 1; }",
        "body b { frame: rotate_z((z/l)^2) * translate(0.5, 0, 0); mass: 1; center: (0.1, 0, 0.2); }",
        "body b { frame: rotate_z((z + 2*w)/l) * translate(0.5, w, 0); mass: 1; }",
        "body b { frame: rotate_x(z*w/l^2); inertia: diag(0.1, 0.2, 0.2); mass: 1; center: (0, 1, 0); }",
    ] {
        check(&format!("{ENERGY} {two} {frame}"));
    }
}

/// The same where bodies are all the inertia there is: what the joint drifts by counts.
#[test]
fn bodies_that_expressions_move_by_themselves() {
    for body in [
        "body b { frame: rotate_z((z/l)^2) * translate(0.5, 0, 0); mass: 1; center: (0.1, 0, 0.2); }",
        "body b { frame: translate(0, 0, z^3/l^2); mass: 1; }",
    ] {
        check(&format!("constant l: m = 1; {body}"));
    }
}

/// A tree of bodies that some coordinate does not move: without inertia of its own its
/// acceleration cannot be had, and is not zero.
#[test]
fn a_coordinate_that_moves_no_body() {
    let text = "coordinate w: m; body b { frame: translate(z, 0, 0); mass: m; } force w = 3;";
    let compiled = compiled(text);
    let asked = "forward_dynamics".parse().unwrap();
    let error = Emission::new(&compiled, "m.model", &asked).unwrap_err();
    assert!(error.to_string().contains("singular"), "{error}");
}
