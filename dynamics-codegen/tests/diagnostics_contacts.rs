//! What is said about contacts that do not fit.

use dynamics_codegen::{Library, compile};
use std::fmt::Write;

/// A model that is right, for mistakes to be added to.
const CART: &str = "\
model cart;
coordinate x: m;
coordinate z: m;
coordinate turn: rad;
input push: N;
parameter r: m = 0.1;
parameter m: kg = 1;
body cart { frame: translate(x, 0, z) * rotate_y(turn); mass: m; inertia: diag(0, 0.01, 0); }
force x = push;
contact wheel: disc_y(cart, r) on plane_z(world) { friction: 0.5; }
";

/// Each case with what is said about it, one under the other.
fn read_aloud(cases: &[(&str, &str)]) -> String {
    let mut library = Library::builtin();
    library.add(
        "touching",
        "touching.model",
        "effect touching(joint); force joint = 0; contact c: point(world) on plane_z(world);",
    );
    let mut page = String::new();
    for (title, addition) in cases {
        let Err(report) = compile("cart.model", &format!("{CART}{addition}\n"), &library) else {
            panic!("{title}: this compiles");
        };
        write!(page, "── {title}\n{report}\n\n").unwrap();
    }
    page
}

#[test]
fn contacts() {
    insta::assert_snapshot!(read_aloud(&[
        ("nothing touched", "contact a: point(cart);"),
        ("no shape", "contact a: cart on plane_z(world);"),
        (
            "a shape that is none",
            "contact a: disk_y(cart, r) on plane_z(world);"
        ),
        (
            "a plane that is none",
            "contact a: point(cart) on floor(world);"
        ),
        ("no radius", "contact a: sphere(cart) on plane_z(world);"),
        ("no extent", "contact a: sphere(cart, 0) on plane_z(world);"),
        (
            "unit of the radius",
            "contact a: sphere(cart, m) on plane_z(world);"
        ),
        (
            "a radius that grows",
            "contact a: sphere(cart, x) on plane_z(world);"
        ),
        ("no such frame", "contact a: point(kart) on plane_z(world);"),
        (
            "two frames",
            "contact a: point(cart) on plane_z(world, cart);"
        ),
        (
            "unknown entry",
            "contact a: point(cart) on plane_z(world) { frition: 1; }"
        ),
        (
            "an entry twice",
            "contact a: point(cart) on plane_z(world) { friction: 1; friction: 1; }"
        ),
        (
            "unit of friction",
            "contact a: point(cart) on plane_z(world) { friction: m; }"
        ),
        (
            "friction below zero",
            "contact a: point(cart) on plane_z(world) { friction: -1; }"
        ),
        (
            "too elastic",
            "contact a: point(cart) on plane_z(world) { restitution: 1.1; }"
        ),
        (
            "two of one name",
            "contact wheel: point(cart) on plane_z(world);"
        ),
        ("the gap of nothing", "output a = gap(weel);"),
        ("slip across the plane", "output a = slip_z(wheel);"),
        ("gap of no name", "output a = gap(x + 1);"),
        ("in an effect", "effect touching(x);"),
    ]));
}
