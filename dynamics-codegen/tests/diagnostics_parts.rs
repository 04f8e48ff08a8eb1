//! What is said about parts and uses that do not fit.

use dynamics_codegen::{Library, compile};
use std::fmt::Write;

/// A model that is right, for mistakes to be added to.
const CARTS: &str = "\
model carts;
coordinate x: m;
input pull: N;
parameter m: kg = 1;
kinetic m/2*dot(x)^2;
force x = pull;
part cart(before, gap) {
    coordinate q: m;
    parameter m: kg = 2 in 0.1..10;
    parameter k: N/m = 5 in 0..;
    kinetic m/2*dot(q)^2;
    potential k/2*(q - before - gap)^2;
    effect viscous(q) { d = 0.1 }
}
use first = cart(x, 0.1);
";

/// Each case with what is said about it, one under the other.
fn read_aloud(cases: &[(&str, &str)]) -> String {
    let mut library = Library::builtin();
    let template = "effect nested(joint); force joint = 0; part p() {} use a = p();";
    library.add("nested", "nested.model", template);
    let mut page = String::new();
    for (title, addition) in cases {
        let Err(report) = compile("carts.model", &format!("{CARTS}{addition}\n"), &library) else {
            panic!("{title}: this compiles");
        };
        write!(page, "── {title}\n{report}\n\n").unwrap();
    }
    page
}

#[test]
fn uses() {
    insta::assert_snapshot!(read_aloud(&[
        ("no such part", "use a = cars(x, 1);"),
        ("no value", "use a;"),
        ("no brackets", "use a = cart;"),
        ("one argument too few", "use a = cart(x);"),
        ("a name twice", "use first = cart(x, 1);"),
        ("a name with a meaning", "use t = cart(x, 1);"),
        ("no such parameter", "use a = cart(x, 1) { mm = 1 }"),
        (
            "no parameter like it",
            "use a = cart(x, 1) { stiffness = 1 }"
        ),
        (
            "a shared parameter",
            "part p(k) { potential m*k/2; }\nuse a = p(x) { m = 1 }"
        ),
        ("a value out of bounds", "use a = cart(x, 1) { m = 20 }"),
        ("a value twice", "use a = cart(x, 1) { m = 2, m = 3 }"),
        (
            "a parameter that its effect lacks",
            "use a = cart(x, 1) { viscous_q_e = 2 }"
        ),
        ("an argument in another unit", "use a = cart(x, m);"),
        ("an argument that is nothing", "use a = cart(y, 1 + z);"),
        (
            "a coordinate that is none",
            "part p(j) { force j = 0; }\nuse a = p(2*x);"
        ),
        ("no such name inside", "output far = first.k + first.p;"),
        ("a use as a number", "output far = first;"),
        ("no such use", "output far = second.q;"),
        ("no use like it", "output far = frist.q;"),
        ("a place in no use like it", "force fisrt.q = 1;"),
        (
            "a frame of no use like it",
            "output far = position(frst.tip).x;"
        ),
        (
            "a frame on no use like it",
            "frame end = frst.tip * move(1, 0, 0);"
        ),
        ("no name for the use", "use cart(x, 0.1);"),
        ("a name that is taken", "parameter first_m: kg = 1;"),
    ]));
}

#[test]
fn parts() {
    insta::assert_snapshot!(read_aloud(&[
        ("no name", "part (a) {}"),
        ("no brackets", "part p { let a = 1; }"),
        ("no braces", "part p(a);"),
        ("two of one name", "part cart(a) { let b = a; }"),
        (
            "a port twice",
            "part p(a, a) { let b = a; }\nuse u = p(1, 1);"
        ),
        ("a port defined", "part p(a) { let a = 1; }\nuse u = p(1);"),
        (
            "a port with a meaning",
            "part p(t) { let b = t; }\nuse u = p(1);"
        ),
        (
            "a name with a meaning",
            "part p() { let pi = 3; }\nuse u = p();"
        ),
        (
            "in a part",
            "part p() { part r() { let a = 1; } }\nuse u = p();"
        ),
        ("in an effect", "effect nested(x);"),
        (
            "uses itself",
            "part p() { use a = r(); }\npart r() { use b = p(); }\nuse u = p();"
        ),
        ("gravity", "part p() { gravity (0, 0, 1); }\nuse u = p();"),
        ("a robot", "part p() { urdf \"a.urdf\"; }\nuse u = p();"),
        (
            "a fault is told once for all uses",
            "part p(at) { force x = at*kk; let y = 1 +; }\nuse u = p(1);\nuse v = p(2);"
        ),
        (
            "a fault of one use",
            "part p(j) { force j = m*j; }\nuse u = p(x);\nuse v = p(first.q);"
        ),
        (
            "a fault in a part of a part",
            "part inner(j) { force j = m; }\npart outer() { use i = inner(x); }\nuse u = outer();"
        ),
    ]));
}

/// It compiles, and says that nothing is looked at.
#[test]
fn a_part_that_nothing_uses() {
    let text = format!("{CARTS}part spare(a) {{ force a = nothing; }}\n");
    let compiled = compile("carts.model", &text, &Library::builtin()).unwrap();
    insta::assert_snapshot!(compiled.warnings.render());
}
