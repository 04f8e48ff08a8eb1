//! What a user reads when a model is wrong: the place, what was expected, the mend.
//!
//! Test threads have 2 MiB of stack: whatever passes here does not overflow it.

use dynamics_codegen::{Library, Report, compile, compile_bytes};
use std::fmt::Write;

/// A model that is right, for mistakes to be added to.
const SLIDER: &str = "\
model slider;
coordinate x: m;
input x: N;
parameter m: kg = 1;
kinetic m/2*dot(x)^2;
force x = input(x);
";

fn fault(text: &str) -> Report {
    match compile("slider.model", text, &Library::builtin()) {
        Ok(_) => panic!("this compiles:\n{text}"),
        Err(report) => {
            assert!(report.has_errors(), "refused without an error:\n{text}");
            report
        }
    }
}

/// Each case with what is said about it, one under the other.
fn read_aloud(cases: &[(&str, &str)]) -> String {
    let mut page = String::new();
    for (title, addition) in cases {
        let report = fault(&format!("{SLIDER}{addition}\n"));
        write!(page, "── {title}\n{report}\n\n").unwrap();
    }
    page
}

/// As [`read_aloud`], for whole files.
fn read_files_aloud(cases: &[(&str, &str)]) -> String {
    let mut page = String::new();
    for (title, text) in cases {
        write!(page, "── {title}\n{}\n\n", fault(text)).unwrap();
    }
    page
}

#[test]
fn names() {
    insta::assert_snapshot!(read_aloud(&[
        ("unknown name", "potential mm*9.81*x;"),
        ("unknown name, nothing near", "potential omega*x;"),
        ("unknown function", "let a = sni(x/1);"),
        (
            "functions of other languages",
            "let a = if(x, 1, 2); let b = pow(m, 2); let c = log(2);"
        ),
        ("a case", "let a = if(x > 0, 1, 2);"),
        ("a comparison in parentheses", "let a = (x < 0)*2;"),
        ("a product without its sign", "let a = m(x + 1);"),
        ("too many arguments", "let a = sin(1, 2);"),
        ("force on an unknown coordinate", "force y = 1;"),
        ("force on a parameter", "force m = 1;"),
        ("coordinate defined twice", "coordinate x: m;"),
        ("parameter with a coordinate's name", "parameter x: kg = 1;"),
        ("input defined twice", "input x: N;"),
        (
            "constraint defined twice",
            "constraint c: x == 0; constraint c: x == 1;"
        ),
        ("output defined twice", "output y = x; output y = 2*x;"),
        ("word with a meaning", "let t = 1;"),
        ("circle of one", "let a = 1 + a;"),
        (
            "circle of three",
            "let a = b;\nlet b = 2*c;\nlet c = sin(a);"
        ),
        (
            "unit of a port outside a template",
            "parameter d: torque(x) = 1;"
        ),
    ]));
}

#[test]
fn units() {
    insta::assert_snapshot!(read_aloud(&[
        ("sum", "let a = x + dot(x);"),
        ("difference", "let a = m*dot(x)^2/2 - x;"),
        ("energy", "potential m*x;"),
        ("force", "force x = m*dot(x);"),
        ("argument", "let a = cos(x);"),
        ("exponent", "let a = 2^x;"),
        ("root", "let a = x + sqrt(m);"),
        ("equation", "constraint c: x == m;"),
        ("comparison", "let a = max(x, t);"),
        ("declared unit", "constant h: m = 1; constant a: s = 2*h;"),
        ("unknown unit", "parameter d: mm = 1;"),
        ("factor in a unit", "parameter d: 2*m = 1;"),
        ("exponent of a unit", "parameter d: m^99 = 1;"),
        ("unit cut short", "parameter d: kg/ = 1;"),
    ]));
}

#[test]
fn numbers() {
    insta::assert_snapshot!(read_aloud(&[
        ("no value", "parameter d: m;"),
        ("value that varies", "parameter d: kg = 2*m;"),
        ("value out of bounds", "parameter d = 5 in 0..1;"),
        ("bounds the wrong way round", "parameter d = 1 in 2..1;"),
        ("bounds missing", "parameter d = 1 in ;"),
        ("unknown prior", "parameter d = 1 prior uniform(0, 1);"),
        ("prior of no width", "parameter d = 1 prior normal(1, 0);"),
        ("too large", "let a = 1e400;"),
        ("too large together", "let a = 1e300*1e300;"),
        ("division by zero", "let a = m/(x - x);"),
        ("logarithm of zero", "let a = x*ln(0);"),
        ("root of a negative number", "let a = x*sqrt(-1);"),
        ("digits first", "let a = .5;"),
        ("suffix", "let a = 3kg;"),
        ("neither name nor number", "let a = 0b12;"),
        ("constant that varies", "constant a = 2*x;"),
    ]));
}

#[test]
fn statements() {
    insta::assert_snapshot!(read_aloud(&[
        ("misspelt statement", "kinetc m*dot(x)^2;"),
        ("foreign statement", "while x;"),
        ("missing semicolon", "let a = 1\nlet b = 2;"),
        ("missing name", "parameter = 1;"),
        ("missing value", "let a;"),
        ("constraint without a coordinate", "constraint c: m == 1;"),
        ("constraint on time", "constraint c: t == 1;"),
        ("constraint without an equation", "constraint c: x;"),
        ("constraint without a name", "constraint x == 0;"),
        (
            "constraint on an input",
            "constraint c: x == input(x)/(1*m)*t^2;"
        ),
        ("acceleration", "force x = -m*dot(dot(x));"),
        ("rate of an input", "force x = dot(input(x))*t;"),
        ("velocity in a potential", "potential m*dot(x)^2;"),
        ("input in an energy", "potential input(x)*x;"),
        ("inner doc comment", "//! A slider."),
    ]));
}

#[test]
fn characters() {
    insta::assert_snapshot!(read_aloud(&[
        ("stray characters", "let a = x ? 1;\nlet $b = 2;"),
        ("typographic characters", "let a = x² − 3·x;"),
        ("degrees", "let a = 30°;"),
        ("absolute value", "let a = |x|;"),
        ("NUL", "let a\0 = 1;"),
        ("bracket never closed", "let a = (x;"),
        ("bracket never opened", "let a = x);"),
        ("brackets crossed", "let a = (x];"),
        ("comment never closed", "/* the rest"),
        ("text never closed", "let a = \"x;"),
        ("two operators", "let a = x ** 2;"),
        ("comparison instead of equation", "let a = x < 2;"),
    ]));
}

#[test]
fn files() {
    let said = read_files_aloud(&[
        ("empty", ""),
        ("blank", " \n\t\n"),
        ("no heading", "coordinate x: m;\n"),
        ("another language", "fn main() {}\n"),
        ("heading without a name", "model;\n"),
        ("template", "effect lift(joint);\nforce joint = 1;\n"),
        ("nothing moves", "model m;\nparameter k = 1;\n"),
        ("nothing has inertia", "model m;\ncoordinate x: m;\n"),
        (
            "three mistakes",
            "model m;\ncoordinate x: m;\nparameter k: N/mm = 1;\nkinetic dot(y)^2;\npotential k*x^2;\nforce z = 1;\n",
        ),
        (
            "a slip is not reported at every use",
            "model m;\ncoordinate x m;\nparameter k: = 1;\nkinetic k/2*dot(x)^2;\nforce x = -k*x;\n",
        ),
    ]);
    insta::assert_snapshot!(said);
}

#[test]
fn effects() {
    insta::assert_snapshot!(read_aloud(&[
        ("unknown effect", "effect vicsous(x);"),
        ("unknown effect, nothing near", "effect levitation(x);"),
        ("unknown parameter", "effect stribeck(x) { f_x = 1 }"),
        ("unknown place", "effect viscous(y);"),
        ("too many places", "effect viscous(x, x);"),
        ("value out of bounds", "effect viscous(x) { d = -1 }"),
        ("value that varies", "effect viscous(x) { d = m }"),
        (
            "applied twice",
            "effect viscous(x) { d = 1 }\neffect viscous(x) { d = 2 }"
        ),
    ]));
}

#[test]
fn a_faulty_template_is_shown_where_it_is_faulty_and_where_it_is_needed() {
    let mut library = Library::builtin();
    library.add(
        "odd",
        "mine/odd.model",
        "effect odd(joint);\nforce joint = ;\n",
    );
    library.add(
        "odder",
        "mine/odder.model",
        "effect odder(joint);\ncoordinate y: m;\nforce joint = -d*dot(joint);\n",
    );
    let text = format!("{SLIDER}effect odd(x);\neffect odder(x);\n");
    let report = compile("slider.model", &text, &library).unwrap_err();
    insta::assert_snapshot!(report);
}

#[test]
fn bytes_that_are_no_text() {
    let mut bytes = SLIDER.as_bytes().to_vec();
    bytes.extend(b"// caf\xe9\n");
    let report = compile_bytes("slider.model", &bytes, &Library::builtin()).unwrap_err();
    insta::assert_snapshot!(report);
    assert!(compile_bytes("x", &[0xff], &Library::builtin()).is_err());
    assert!(compile_bytes("x", b"\xef\xbb\xbf", &Library::builtin()).is_err());
}

#[test]
fn a_byte_order_mark_is_no_mistake() {
    let text = format!("\u{feff}{SLIDER}");
    compile("slider.model", &text, &Library::builtin()).unwrap();
}

/// The first line, which says what is wrong.
fn title(report: &Report) -> String {
    report
        .render()
        .lines()
        .next()
        .unwrap_or_default()
        .to_string()
}

#[test]
fn deep_nesting_is_refused() {
    let deep = 10_000;
    let (open, close) = ("(".repeat(deep), ")".repeat(deep));
    for (value, expected) in [
        (
            format!("{open}x{close}"),
            "error: brackets nest more than 64 deep",
        ),
        (
            format!("{}x{close}", "sin(".repeat(deep)),
            "error: brackets nest more than 64 deep",
        ),
        (
            format!("{}x", "-".repeat(deep)),
            "error: this expression nests more than 64 deep",
        ),
        (
            format!("x{}", "^x".repeat(deep)),
            "error: this expression nests more than 64 deep",
        ),
        (
            format!("x{}", "^-x".repeat(deep)),
            "error: this expression nests more than 64 deep",
        ),
        (
            format!("x{}", ".x".repeat(deep)),
            "error: this expression nests more than 64 deep",
        ),
        (open.clone(), "error: brackets nest more than 64 deep"),
        ("/*".repeat(deep), "error: this comment is never closed"),
    ] {
        assert_eq!(
            title(&fault(&format!("{SLIDER}let a = {value};\n"))),
            expected
        );
    }
}

/// As deep as may be, in every way at once.
#[test]
fn permitted_nesting_fits_the_stack() {
    let angle = "(t*dot(x)/x)";
    let nested = format!("{}{angle}{}", "sin(1 + 2*(".repeat(31), "))".repeat(31));
    let signs = format!("{}{angle}", "-".repeat(60));
    let powers = format!("{angle}{}", "^1".repeat(60));
    let text = format!("{SLIDER}let a = {nested};\nlet b = {signs};\nlet c = {powers};\n");
    compile("slider.model", &text, &Library::builtin()).unwrap_or_else(|report| panic!("{report}"));
}

#[test]
fn a_chain_of_definitions_may_be_long_and_deep() {
    let (open, close) = ("sin(1 + 2*(".repeat(30), "))".repeat(30));
    let mut text = format!("{SLIDER}let a0 = t*dot(x)/x;\n");
    // Backwards, so that each is met before it is known.
    for i in (1..=300).rev() {
        writeln!(text, "let a{i} = {open}a{}{close};", i - 1).unwrap();
    }
    compile("slider.model", &text, &Library::builtin()).unwrap_or_else(|report| panic!("{report}"));
}

#[test]
fn long_sums_are_no_problem() {
    let terms: String = (1..100_000).fold(String::new(), |mut terms, i| {
        write!(terms, " + sin({i}*t*dot(x)/x)").unwrap();
        terms
    });
    let text = format!("{SLIDER}let a = 1{terms};\n");
    compile("slider.model", &text, &Library::builtin()).unwrap_or_else(|report| panic!("{report}"));
}

#[test]
fn a_hundred_thousand_mistakes_are_not_all_shown() {
    let text = format!("{SLIDER}let a = 1{};\n", " + q".repeat(100_000));
    let shown = fault(&text).render();
    assert!(
        shown.ends_with("… and 99968 more"),
        "{}",
        &shown[shown.len() - 100..]
    );
}

#[test]
fn what_is_too_large_is_refused() {
    let long = format!("{SLIDER}// {}\n", "x".repeat(5 << 20));
    assert_eq!(
        title(&fault(&long)),
        "error: the file is larger than a model may be (4194304 bytes)"
    );
    for (statement, said) in [
        (
            format!("let {} = 1;", "x".repeat(513)),
            "a name or a number",
        ),
        (
            format!("let a = {};", "2".repeat(513)),
            "a name or a number",
        ),
        (format!("let \"{}\" = 1;", "x ".repeat(257)), "a name"),
    ] {
        assert_eq!(
            title(&fault(&format!("{SLIDER}{statement}\n"))),
            format!("error: {said} has at most 512 bytes")
        );
    }
    let wide: String = (0..3000).fold("model m;\n".to_string(), |mut text, i| {
        writeln!(text, "coordinate q{i}: m;").unwrap();
        text
    });
    assert_eq!(
        title(&fault(&wide)),
        "error: the model has 3000 coordinates; it may have 256"
    );
    let dimension = format!(
        "{SLIDER}let a = x^80000;\nlet b = a{};\n",
        "*a".repeat(3000)
    );
    // Whatever it says: the unit's exponents do not overflow.
    let _ = compile("slider.model", &dimension, &Library::builtin());
}

/// What would take time with the square or the cube of the file's length.
#[test]
fn what_repeats_is_bounded() {
    let repeated = |statement: &dyn Fn(usize) -> String| {
        let start = format!("{SLIDER}constant tau: s = 1;\nconstant l: m = 1;\n");
        (1..=2000).fold(start, |text, i| text + &statement(i) + "\n")
    };
    for (text, expected) in [
        (
            repeated(&|_| "measured x = 1.01*x;".to_string()),
            "error: the model says more than 256 times what is measured",
        ),
        (
            repeated(&|i| format!("input x = delay(x, {i}*tau);")),
            "error: the model delays its inputs in more than 256 ways",
        ),
        (
            repeated(&|i| format!("frame f{i} = rotate_z({i}*x/l);")),
            "error: the bodies do not form a machine: the tree has 2000 joints and frames that move; at most 1000 are supported",
        ),
    ] {
        assert_eq!(title(&fault(&text)), expected);
    }
    let report = fault(&repeated(&|i| format!("let b{i} = a{i};")));
    let suggests = |d: &&dynamics_codegen::Diagnostic| d.help[0].starts_with("did you mean");
    assert_eq!(report.diagnostics.len(), 2000);
    assert_eq!(report.diagnostics.iter().filter(suggests).count(), 100);
}
