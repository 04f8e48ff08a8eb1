//! Generated C beside C's own headers, in whichever order they are included, and beside a
//! file of the other precision.

use dynamics_codegen::emit::{self, c_member};
use dynamics_codegen::{Library, compile};
use integration_tests::compiler::{self, Precision};
use integration_tests::files;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The headers of C99.
const C99: [&str; 24] = [
    "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits",
    "locale", "math", "setjmp", "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio",
    "stdlib", "string", "tgmath", "time", "wchar", "wctype",
];

/// And those that came with C11.
const C11: [&str; 5] = ["stdalign", "stdatomic", "stdnoreturn", "threads", "uchar"];

/// A file that includes every header of C99 and, if `later`, those of C11.
fn all_headers(folder: &Path, later: bool) -> PathBuf {
    let later: &[&str] = if later { &C11 } else { &[] };
    let lines = C99.iter().chain(later);
    let text: String = lines.map(|name| format!("#include <{name}.h>\n")).collect();
    let path = folder.join("all_headers.c");
    std::fs::write(&path, text).unwrap();
    path
}

/// Names of macros, with those that take arguments or without them.
fn macros(folder: &Path, with_arguments: bool) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (standard, later) in [
        ("-std=c99", false),
        ("-std=c11", true),
        ("-std=gnu17", true),
    ] {
        let text = compiler::macros(&all_headers(folder, later), standard);
        for line in text.lines() {
            let word = line.split_whitespace().nth(1).expect("`#define name …`");
            let (name, arguments) = match word.split_once('(') {
                Some((name, _)) => (name, true),
                None => (word, false),
            };
            if with_arguments || !arguments {
                names.insert(name.to_string());
            }
        }
    }
    assert!(names.len() > 500, "only {} macros", names.len());
    names
}

/// Whether a name begins as a character by its code point does, `__5f_`.
fn begins_with_a_code_point(name: &str) -> bool {
    let digits = name
        .strip_prefix("__")
        .and_then(|rest| rest.split_once('_'));
    let is_digit = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
    digits.is_some_and(|(digits, _)| !digits.is_empty() && digits.chars().all(is_digit))
}

/// What [`c_member`] promises, against the compiler's own headers: a member with a capital
/// letter ends in `_`, one without is no macro, and none begins with `_` but where that is
/// a code point.
#[test]
fn no_member_is_a_macro() {
    let folder = tempfile::tempdir().unwrap();
    for name in macros(folder.path(), false) {
        if name.starts_with('_') {
            assert!(!begins_with_a_code_point(&name), "`{name}`");
            continue;
        }
        assert!(!name.ends_with('_'), "`{name}` ends as only members do");
        assert_ne!(c_member(&name), name);
    }
}

/// A model all of whose names are macros, after all headers.
#[test]
fn a_model_of_macros_compiles() {
    let folder = tempfile::tempdir().unwrap();
    let names = macros(folder.path(), true);
    let mut text = "model complex; coordinate \"EOF\"; kinetic dot(\"EOF\")^2;\n".to_string();
    for name in names.iter().filter(|name| *name != "EOF") {
        text.push_str(&format!("parameter {name:?} = 1;\n"));
    }
    let compiled = compile("m.model", &text, &Library::empty()).unwrap_or_else(|e| panic!("{e}"));
    let files = emit::c(&compiled, "m.model");
    assert_eq!(files[0].name, "complex__.h", "`<complex.h>` is C's own");
    for file in &files {
        std::fs::write(folder.path().join(&file.name), &file.text).unwrap();
    }
    let headers = all_headers(folder.path(), false);
    let source = folder.path().join(&files[1].name);
    compiler::check_behind(&headers, &source, Precision::Double);
}

#[test]
fn what_is_checked_in_compiles_behind_all_headers() {
    let folder = tempfile::tempdir().unwrap();
    let headers = all_headers(folder.path(), false);
    let sources = files::in_folder(&files::root().join("generated/c"), "c");
    assert!(sources.len() >= 15, "a file per model");
    for source in sources {
        compiler::check_behind(&headers, &source, Precision::Double);
    }
}

/// `DYNAMICS_FLOAT` for one file and not for the other: the linker says so.
#[test]
fn precisions_do_not_mix() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let generated = files::root().join("generated/c");
    let header = generated.join("pendulum.h");
    let main = format!(
        "#include {header:?}\nint main(void) {{ pendulum_point x = {{0}}; \
         pendulum_real out[1][1]; \
         pendulum_mass_matrix(&pendulum_nominal, &x, out); return 0; }}\n"
    );
    std::fs::write(path("main.c"), main).unwrap();
    for (name, precision) in [("single", Precision::Single), ("double", Precision::Double)] {
        compiler::object(&path("main.c"), &path(&format!("main_{name}.o")), precision);
        let source = generated.join("pendulum.c");
        compiler::object(&source, &path(&format!("pendulum_{name}.o")), precision);
    }
    let link = |main: &str, model: &str| {
        let objects = [
            path(&format!("main_{main}.o")),
            path(&format!("pendulum_{model}.o")),
        ];
        compiler::link(&objects, &path("program"))
    };
    assert_eq!(link("single", "single"), Ok(()));
    assert_eq!(link("double", "double"), Ok(()));
    let said = link("single", "double").unwrap_err();
    assert!(said.contains("pendulum_mass_matrix_float"), "{said}");
    assert!(link("double", "single").is_err());
}
