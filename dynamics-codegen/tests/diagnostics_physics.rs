//! What a user reads when a model is well formed and no machine.

use dynamics_codegen::{Library, compile};
use std::fmt::Write;

const HEAD: &str = "model m;\ncoordinate x: m;\ncoordinate y: m;\n";

/// What is said about each model, whether it compiles or not.
fn read_aloud(cases: &[(&str, &str)]) -> String {
    let mut page = String::new();
    for (title, addition) in cases {
        let text = format!("{HEAD}{addition}\n");
        let (verdict, report) = match compile("m.model", &text, &Library::builtin()) {
            Ok(compiled) => ("compiles", compiled.warnings),
            Err(report) => ("is refused", report),
        };
        assert!(!report.diagnostics.is_empty(), "nothing is said:\n{text}");
        write!(page, "── {title}: {verdict}\n{report}\n\n").unwrap();
    }
    page
}

fn is_silent(additions: &[&str]) {
    for addition in additions {
        let text = format!("{HEAD}{addition}\n");
        let compiled = compile("m.model", &text, &Library::builtin());
        let compiled = compiled.unwrap_or_else(|report| panic!("{text}\n{report}"));
        assert!(
            compiled.warnings.diagnostics.is_empty(),
            "{text}\n{}",
            compiled.warnings
        );
    }
}

#[test]
fn kinetic_energy_that_is_not_positive() {
    insta::assert_snapshot!(read_aloud(&[
        (
            "a negative mass",
            "parameter m: kg = -1;\nkinetic m/2*(dot(x)^2 + dot(y)^2);"
        ),
        (
            "no mass",
            "parameter m: kg = 0;\nparameter n: kg = 1;\nkinetic m/2*dot(x)^2 + n/2*dot(y)^2;"
        ),
        (
            "a wrong sign",
            "parameter m: kg = 1;\nkinetic m/2*dot(x)^2 - m*dot(y)^2;"
        ),
        (
            "a product that is too large",
            "parameter m: kg = 1;\nkinetic m/2*(dot(x)^2 + dot(y)^2) + 2*m*dot(x)*dot(y);"
        ),
        (
            "a motion without energy",
            "parameter m: kg = 1;\nkinetic m/2*(dot(x) - dot(y))^2;"
        ),
        (
            "negative in places",
            "parameter m: kg = 1;\nparameter r: m = 0.5;\n\
             kinetic m/2*(1 - x^2/r^2)*dot(x)^2 + m/2*dot(y)^2;"
        ),
        (
            "a body of negative mass",
            "parameter m: kg = -2;\nbody b { frame: translate(x, y, 0); mass: m; }"
        ),
    ]));
}

#[test]
fn kinetic_energy_that_is_positive_where_it_must_be() {
    is_silent(&[
        // The constraint determines what has no inertia of its own.
        "parameter m: kg = 1; kinetic m/2*(dot(x) - dot(y))^2; constraint c: y == 2*x;",
        // Polar coordinates, which are singular at the origin.
        "coordinate phi: rad; parameter m: kg = 1;
         kinetic m/2*(dot(x)^2 + x^2*dot(phi)^2) + m/2*dot(y)^2;",
        // A tonne beside a milligram.
        "parameter m: kg = 1; kinetic 1e3*m*dot(x)^2 + 1e-6*m*dot(y)^2;",
        // What is not negative by nature may be negative all the same.
        "parameter I: kg*m^2 = -0.1; coordinate a: rad;
         parameter m: kg = 1; kinetic m/2*(dot(x)^2 + dot(y)^2) + (I + 0.3)/2*dot(a)^2;",
    ]);
}

#[test]
fn constraints_that_contradict_each_other() {
    let kinetic = "parameter m: kg = 1;\nkinetic m/2*(dot(x)^2 + dot(y)^2);\n";
    let cases = [
        (
            "two heights",
            "constraint low: y == 0;\nconstraint high: y == 1;",
        ),
        (
            "three of them",
            "constraint a: x == 0;\nconstraint b: 2*y == 3;\nconstraint c: x + y == 1;",
        ),
        (
            "two speeds",
            "constraint slow: dot(x) == 1;\nconstraint fast: 3*dot(x) == 2;",
        ),
        (
            "a place and a speed",
            "constant l: m = 2;\nconstant v: m/s = 1;\nconstraint still: sin(x/l) == 0.5;\nconstraint fast: dot(x)*cos(x/l) == v;",
        ),
        (
            "in the course of time",
            "constant v: m/s = 2;\nconstraint still: y == 0;\nconstraint up: y == v*t;",
        ),
        (
            "by a parameter's value",
            "parameter h: m = 0.5;\nconstraint low: y == 0;\nconstraint high: y == h;",
        ),
    ];
    let cases = cases.map(|(title, text)| (title, format!("{kinetic}{text}")));
    let cases: Vec<(&str, &str)> = cases.iter().map(|(a, b)| (*a, b.as_str())).collect();
    insta::assert_snapshot!(read_aloud(&cases));
}

#[test]
fn constraints_that_agree() {
    is_silent(&[
        "parameter m: kg = 1; kinetic m/2*(dot(x)^2 + dot(y)^2); constraint a: y == 1; constraint b: 2*y == 2;",
        "parameter m: kg = 1; kinetic m/2*(dot(x)^2 + dot(y)^2); constraint a: x == 0; constraint b: dot(x) == 0;",
        // Both hold where the machine rests at the origin.
        "parameter m: kg = 1; kinetic m/2*(dot(x)^2 + dot(y)^2); constraint a: dot(x) == 0; constant s: s = 1; constraint b: dot(x) == x/s;",
        // Parallel somewhere, not everywhere.
        "parameter m: kg = 1; kinetic m/2*(dot(x)^2 + dot(y)^2); constraint a: y == 0; constant l: m = 1; constraint b: y == x^2/l - 4;",
        // They take turns.
        "parameter m: kg = 1; kinetic m/2*(dot(x)^2 + dot(y)^2);
         constraint a when x: y == 0; constraint b when -x: y == 1;",
    ]);
}

#[test]
fn inertias_that_no_body_has() {
    let body = |inertia: &str| {
        format!(
            "parameter i = 0.1;\nbody b {{ frame: translate(x, y, 0); mass: 1; inertia: {inertia}; }}"
        )
    };
    let cases = [
        ("the triangle inequality", body("diag(1, 1, 3)")),
        ("by a parameter's value", body("diag(i, i, 3*i)")),
        (
            "a negative principal moment",
            body("full(1, 1, 1, 2, 0, 0)"),
        ),
        ("a rounded figure", body("diag(1, 1, 2.01)")),
    ];
    let cases: Vec<(&str, &str)> = cases.iter().map(|(a, b)| (*a, b.as_str())).collect();
    insta::assert_snapshot!(read_aloud(&cases));
    let possible = [
        "diag(1, 1, 2)",
        "diag(0, 0, 3)",
        "diag(0, i, i)",
        "full(1, 1, 1, 0.4, 0, 0)",
    ];
    for inertia in possible {
        is_silent(&[&body(inertia)]);
    }
}
