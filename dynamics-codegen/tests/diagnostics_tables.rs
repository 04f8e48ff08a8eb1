//! What is said about tables that do not fit.

use dynamics_codegen::{Library, compile};
use std::fmt::Write;

/// A model that is right, for mistakes to be added to.
const SLED: &str = "\
model sled;
coordinate x: m;
parameter m: kg = 1;
kinetic m/2*dot(x)^2;
table drag(speed: m/s): N { 0: 0; 1: 0.5; }
table thrust(speed: m/s, gas: 1): N { gas: 0, 1; 0: 0, 5; 9: 0, 2; }
";

/// Files beside it.
const FILES: [(&str, &str); 6] = [
    ("words.csv", "speed,force\n0,0\n1,much\n"),
    ("back.csv", "0,0\n2,1\n1,2\n"),
    ("ragged.csv", "speed,0,1,2\n0,0,1,2\n1,0,1\n"),
    ("wide.csv", "0,0\n1,2,3\n"),
    ("empty.csv", "# nothing yet\n"),
    ("endless.csv", "0,0\n1,inf\n"),
];

/// Each case with what is said about it, one under the other.
fn read_aloud(cases: &[(&str, &str)]) -> String {
    let mut library = Library::empty();
    library.add(
        "own",
        "own.model",
        "effect own(j); table t(x) { 0: 0; 1: 1; } force j = 0*j;",
    );
    for (path, text) in FILES {
        library.add_file(path, path, text);
    }
    let mut page = String::new();
    for (title, addition) in cases {
        let Err(report) = compile("sled.model", &format!("{SLED}{addition}\n"), &library) else {
            panic!("{title}: this compiles");
        };
        write!(page, "── {title}\n{report}\n\n").unwrap();
    }
    page
}

#[test]
fn tables() {
    let many = (0..300).map(|i| format!("{i}: 0; ")).collect::<String>();
    let many = format!("table a(x) {{ {many} }}");
    insta::assert_snapshot!(read_aloud(&[
        ("no brackets", "table a { 0: 0; }"),
        ("no argument", "table a() { 0: 0; 1: 1; }"),
        ("three arguments", "table a(x, y, z) { 0: 0; 1: 1; }"),
        (
            "an argument twice",
            "table a(x, x) { x: 0, 1; 0: 0, 1; 1: 0, 1; }"
        ),
        ("no numbers", "table a(x);"),
        ("a path without quotes", "table a(x) = a.csv;"),
        ("a row without a value", "table a(x) { 0; 1: 1; }"),
        ("one point", "table a(x) { 0: 1; }"),
        ("no point", "table a(x) { }"),
        ("not increasing", "table a(x) { 0: 1; 2: 1; 2: 3; }"),
        ("too near", "table a(x) { 0: 1; 1e-320: 1; }"),
        ("too large", "table a(x) { 0: -1e308; 1e-3: 1e308; }"),
        ("two values", "table a(x) { 0: 1; 1: 2, 3; }"),
        ("a parameter", "table a(x) { 0: 1; 1: m; }"),
        ("a coordinate", "table a(y) { 0: 1; 1: 2*x; }"),
        (
            "a constant that is none",
            "constant c = 2*m;\ntable a(x) { 0: 1; c: 1; }"
        ),
        (
            "no row of the second argument",
            "table a(x, y) { 0: 0, 1; 1: 2, 3; }"
        ),
        (
            "a row too short",
            "table a(x, y) { y: 0, 1, 2; 0: 0, 1, 2; 1: 2, 3; }"
        ),
        ("a name twice", "table drag(x) { 0: 0; 1: 1; }"),
        ("a function's name", "table sin(x) { 0: 0; 1: 1; }"),
        ("an unknown unit", "table a(x: mm) { 0: 0; 1: 1; }"),
        ("more than code is made of", &many),
        ("in a template", "effect own(x);"),
        (
            "in a part",
            "part p() { table a(x) { 0: 0; 1: 1; } }\nuse u = p();"
        ),
    ]));
}

#[test]
fn files() {
    insta::assert_snapshot!(read_aloud(&[
        ("no such file", "table a(x) = \"none.csv\";"),
        ("a word", "table a(x) = \"words.csv\";"),
        ("not increasing", "table a(x) = \"back.csv\";"),
        ("a row too short", "table a(x, y) = \"ragged.csv\";"),
        ("a row too long", "table a(x) = \"wide.csv\";"),
        ("nothing", "table a(x) = \"empty.csv\";"),
        ("no number", "table a(x) = \"endless.csv\";"),
    ]));
}

#[test]
fn reading() {
    insta::assert_snapshot!(read_aloud(&[
        ("an argument too few", "force x = thrust(dot(x));"),
        ("an argument in another unit", "force x = drag(x);"),
        ("a value in another unit", "potential drag(dot(x));"),
        ("no such table", "force x = drga(dot(x));"),
        ("a table as a number", "force x = 2*drag;"),
        (
            "a wrong table is told once",
            "table a(x) { 0: 1; }\nforce x = a(x) + a(2);"
        ),
    ]));
}
