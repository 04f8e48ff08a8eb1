//! What is said about states, delays, contacts and ports that do not fit.

use dynamics_codegen::{Library, compile};
use std::fmt::Write;

/// A model that is right, for mistakes to be added to.
const BEAD: &str = "\
model bead;
coordinate x: m;
coordinate y: m;
coordinate turn: rad;
input push: N;
parameter m: kg = 1;
constant k: 1/m = 1;
kinetic m/2*(dot(x)^2 + dot(y)^2 + (k^-1*dot(turn))^2);
force x = push;
constraint wire: y == k*x^2;
constraint geared: turn == 2*k*x;
";

/// Each case with what is said about it, one under the other.
fn read_aloud(cases: &[(&str, &str)]) -> String {
    let mut library = Library::builtin();
    library.add(
        "many",
        "many.model",
        "effect many(axes: coordinates, joint); force joint = 0;",
    );
    library.add(
        "shared",
        "shared.model",
        "effect shared(axes: coordinates); let v = dot(axes); force axes = 0*v;",
    );
    library.add(
        "weak",
        "weak.model",
        "effect weak(drive: each input); parameter loss: unit(drive); input drive = drive - loss;",
    );
    library.add(
        "beside",
        "beside.model",
        "effect beside(drive: each input, joint); force joint = drive;",
    );
    let mut page = String::new();
    for (title, addition) in cases {
        let report = compile("bead.model", &format!("{BEAD}{addition}\n"), &library)
            .expect_err("a case is faulty");
        write!(page, "── {title}\n{report}\n\n").unwrap();
    }
    page
}

#[test]
fn states() {
    insta::assert_snapshot!(read_aloud(&[
        ("no rate", "state z: 1;"),
        ("two rates", "state z: 1;\ndot(z) == 0;\ndot(z) == 1;"),
        ("rate of something else", "dot(x) == 0;"),
        ("a rate that is assigned", "state z: 1;\ndot(z) = 1;"),
        ("unit of the rate", "state z: m;\ndot(z) == dot(turn);"),
        ("unit of the initial value", "state z: m = m;\ndot(z) == 0;"),
        (
            "an initial value from a state",
            "state z: 1;\nstate w: 1 = z;\ndot(z) == 0;\ndot(w) == 0;"
        ),
        (
            "in an energy",
            "state z: 1;\ndot(z) == 0;\npotential z*m*k^-2/2;"
        ),
        (
            "in a constraint",
            "state z: m;\ndot(z) == 0;\nconstraint c: x == z;"
        ),
        (
            "its rate in an expression",
            "state z: N;\ndot(z) == 0;\nforce x = m*dot(z);"
        ),
        ("a name twice", "state x: 1;\ndot(x) == 0;"),
    ]));
}

#[test]
fn delays() {
    insta::assert_snapshot!(read_aloud(&[
        ("of a coordinate", "force x = delay(x, 0.1);"),
        ("of a sum", "force x = delay(push + push, 0.1);"),
        (
            "by a length",
            "parameter l: m = 1;\nforce x = delay(push, l);"
        ),
        ("by less than nothing", "force x = delay(push, -0.1);"),
        ("by something that moves", "force x = delay(push, t);"),
        ("in an energy", "potential delay(push, 0.1)*x;"),
        (
            "behind a state",
            "state z: N;\ndot(z) == push/0.1;\ninput push = z;\nforce x = delay(push, 0.1);",
        ),
    ]));
}

#[test]
fn contacts() {
    insta::assert_snapshot!(read_aloud(&[
        ("no such constraint", "force x = multiplier(wier);"),
        ("of an expression", "force x = multiplier(2*x);"),
        ("no contact", "force x = normal_force(geared);"),
        ("a multiplier in an energy", "potential multiplier(wire)*x;"),
        ("a multiplier in an output", "output n = multiplier(wire);"),
        ("a load in a rate", "state z: N;\ndot(z) == load(x)/0.1;"),
        ("unit of a multiplier", "force turn = multiplier(wire);"),
        ("friction at no contact", "effect contact_friction(geared);"),
    ]));
}

#[test]
fn ports() {
    insta::assert_snapshot!(read_aloud(&[
        ("different units", "effect speed_drag(x, turn);"),
        ("one twice", "effect speed_drag(x, x);"),
        ("not the last", "effect many(x, y);"),
        ("each twice", "effect input_lag(push, push);"),
        (
            "each in its unit",
            "input wind: N*m;\neffect weak(push, wind);"
        ),
        ("each beside another", "effect beside(push, x);"),
        ("each of none", "effect input_lag();"),
        ("several in one term", "effect shared(x, y);"),
        ("no set", "force x = norm(x);"),
        ("how many to try", "parameter p = 1 try 2.5;"),
        ("read gravity", "force x = m*gravity.x;"),
    ]));
}
