//! What is said about sensors that do not fit.

use dynamics_codegen::{Library, compile};
use std::fmt::Write;

/// A model that is right, for mistakes to be added to.
const ARM: &str = "\
model arm;
coordinate phi: rad;
coordinate lift: m;
input motor: N*m;
parameter m: kg = 1;
state warmth: K;
dot(warmth) == -warmth*slow;
constant slow: 1/s = 0.1;
body rod { frame: translate(0, 0, lift) * rotate_x(phi); mass: m; center: (0, 0.2, 0); }
body post { frame: translate(0, 0, 1); }
force phi = motor;
constraint stop: lift == 0;
";

/// Each case with what is said about it, one under the other.
fn read_aloud(cases: &[(&str, &str)]) -> String {
    let mut library = Library::builtin();
    library.add(
        "seeing",
        "seeing.model",
        "effect seeing(joint); force joint = 0; sensor seen = joint;",
    );
    library.add(
        "pushing",
        "pushing.model",
        "effect pushing(a: sensor); parameter k = 0; force a = k; let b = a;",
    );
    library.add(
        "meddling",
        "meddling.model",
        "effect meddling(joint); force joint = 0; measured gyro_x = gyro_x;",
    );
    let mut page = String::new();
    for (title, addition) in cases {
        let Err(report) = compile("arm.model", &format!("{ARM}{addition}\n"), &library) else {
            panic!("{title}: this compiles");
        };
        write!(page, "── {title}\n{report}\n\n").unwrap();
    }
    page
}

#[test]
fn sensors() {
    insta::assert_snapshot!(read_aloud(&[
        ("no value", "sensor a;"),
        ("no name", "sensor = phi;"),
        ("unit of a scalar", "sensor a: m = phi;"),
        ("unit of a vector", "sensor a: m = gyroscope(rod);"),
        ("unknown entry", "sensor a = phi { noice: 1; }"),
        ("an entry twice", "sensor a = phi { noise: 1; noise: 2; }"),
        ("unit of the noise", "sensor a = lift { noise: m; }"),
        ("noise that varies", "sensor a = m { noise: m; }"),
        ("negative noise", "sensor a = lift { noise: -0.1; }"),
        ("rate of nothing", "sensor a = lift { rate: 0; }"),
        ("two of one name", "sensor a = phi;\nsensor a = lift;"),
        (
            "two of one component",
            "sensor a = gyroscope(rod);\nsensor a_x = lift;"
        ),
        ("a column of the log", "sensor dq_phi = dot(phi);"),
        ("an input's column", "sensor u_motor = motor;"),
        ("time's column", "sensor t = phi;"),
        ("an output's name", "output a = phi;\nsensor a = phi;"),
        ("no such frame", "sensor a = accelerometer(rood);"),
        ("no frame", "sensor a = gyroscope(2*phi);"),
        ("two frames", "sensor a = gyroscope(rod, post);"),
        ("one frame of an encoder", "sensor a = encoder_x(rod);"),
        (
            "a number to an encoder",
            "sensor a = encoder_x(rod, 2*phi);"
        ),
        ("a vector as a number", "sensor a = 2*accelerometer(rod);"),
        ("an acceleration's rate", "sensor a = dot(dot(dot(phi)));"),
        ("a multiplier's rate", "sensor a = dot(multiplier(stop));"),
        ("an input's rate", "sensor a = dot(motor);"),
        (
            "an input's rate beside a velocity",
            "sensor a = dot(motor*dot(phi));"
        ),
        (
            "a state's rate beside a velocity",
            "sensor a = dot(warmth*dot(phi));"
        ),
        ("a load", "sensor a = load(phi);"),
        ("no such constraint", "sensor a = multiplier(stip);"),
    ]));
}

#[test]
fn what_sensors_read_wrongly() {
    insta::assert_snapshot!(read_aloud(&[
        (
            "a vector",
            "sensor gyro = gyroscope(rod);\nmeasured gyro = gyro;"
        ),
        ("no sensor at all", "measured lfit = lift;"),
        (
            "another unit",
            "sensor gyro = gyroscope(rod);\nparameter bias: m = 0;\nmeasured gyro_x = gyro_x + bias;"
        ),
        (
            "another sensor",
            "sensor gyro = gyroscope(rod);\nmeasured gyro_x = gyro_x + gyro_y;"
        ),
        (
            "a time that changes",
            "sensor gyro: rad/s = gyroscope(rod).x;\nmeasured gyro = gyro + t*dot(gyro);"
        ),
        (
            "the rate of a sum",
            "sensor gyro: rad/s = gyroscope(rod).x;\nparameter late: s = 0;\n\
             measured gyro = gyro + late*dot(2*gyro);"
        ),
        (
            "an input",
            "sensor a = phi;\nparameter gain: rad/N/m = 1;\nmeasured a = a + gain*motor;"
        ),
        ("a coordinate's name", "sensor lift = phi;"),
        ("an effect on no column", "effect measurement_offset(gyro);"),
        (
            "an effect on a vector",
            "sensor gyro = gyroscope(rod);\neffect measurement_scale(gyro);"
        ),
        ("no such frame", "mounted board = rod;"),
        ("the world", "mounted world = rod;"),
        ("no transform", "mounted rod = rod * 2;"),
        ("an effect on no frame", "effect mounting_tilt(phi);"),
        (
            "a reading in a force",
            "effect pushing(a);\nsensor a = phi;"
        ),
        (
            "a template and what is no port of it",
            "effect meddling(phi);\nsensor gyro = gyroscope(rod);"
        ),
    ]));
}

#[test]
fn accelerations_elsewhere() {
    insta::assert_snapshot!(read_aloud(&[
        ("in a force", "force phi = -m*acceleration(rod).z;"),
        (
            "an encoder in a constraint",
            "constraint c: encoder_x(rod, post) == 0;"
        ),
        ("a gyroscope in an output", "output a = gyroscope(rod);"),
        (
            "an accelerometer in a term",
            "let a = accelerometer(rod).x;"
        ),
        ("twice the rate in a force", "force phi = dot(dot(phi));"),
        ("in a template", "effect seeing(phi);"),
    ]));
}
