//! Pieces that are known to hurt.

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

/// Numbers at the edges of what a number can be.
const NUMBERS: [&str; 24] = [
    "0",
    "-1",
    "-0",
    "1",
    "2",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "1e999",
    "1e-999",
    "1e2147483648",
    "NaN",
    "nan",
    "inf",
    "-inf",
    "1.7976931348623157e308",
    "0.1",
    "65536",
    "2147483648",
    "9223372036854775808",
    "1e18",
    "1_000",
    "0x1F",
];

/// Names that mean something to somebody, and signs of all our languages.
const WORDS: [&str; 58] = [
    "self",
    "type",
    "fn",
    "r#fn",
    "I",
    "EOF",
    "NULL",
    "t",
    "pi",
    "_",
    "__",
    "x",
    "θ",
    "长",
    "é",
    "²",
    "\u{feff}",
    "\u{202e}",
    "\u{2028}",
    "\0",
    "\r",
    "\u{1b}[31m",
    "ß",
    "*/",
    "/*",
    "//",
    "///",
    "\"",
    "'",
    "\\",
    "\\u0000",
    "\\ud800",
    "<",
    ">",
    "/>",
    "</link>",
    "<!--",
    "]]>",
    "<!DOCTYPE",
    "&lt;",
    "&#0;",
    "${x}",
    "xmlns=\"u\"",
    "fixed",
    "floating",
    "{",
    "}",
    "[[",
    "]",
    "=",
    "==",
    "..",
    ";",
    ",",
    "#",
    "true",
    "null",
    "effect",
];

/// Words and signs that can mostly stand in each other's place.
pub const FAMILIES: [&[&str]; 14] = [
    &["+", "-"],
    &["*", "/"],
    &[
        "sin", "cos", "tan", "exp", "sqrt", "ln", "tanh", "abs", "sign", "step", "asin",
    ],
    &["min", "max", "atan2"],
    &["rotate_x", "rotate_y", "rotate_z"],
    &["kinetic", "potential", "dissipation"],
    &["parameter", "constant"],
    &["coordinate", "input", "coordinates"],
    &["m", "kg", "s", "rad", "N", "1"],
    &[
        "revolute",
        "continuous",
        "prismatic",
        "fixed",
        "floating",
        "planar",
    ],
    &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"],
    &["deg", "turn", "rpm", "mm", "ms", "N"],
    &["q", "v", "u", "z", "t", "parameters"],
    &["true", "false", "null"],
];

/// A number that may be any.
pub fn number(rng: &mut ChaCha8Rng) -> String {
    match rng.random_range(0..10_u32) {
        0..5 => pick(rng, &NUMBERS).to_string(),
        5 => format!("{:e}", f64::from_bits(rng.random::<u64>())),
        6 => format!("{}", rng.random_range(-10_000_i64..10_000)),
        7 => format!("1e{}", rng.random_range(-400_i32..400)),
        8 => format!("{:.3}", rng.random_range(-3.0..3.0_f64)),
        _ => "9".repeat(rng.random_range(1..400)),
    }
}

/// A number near another one, if that is one.
pub fn number_near(rng: &mut ChaCha8Rng, number: &str) -> String {
    let Ok(value) = number.parse::<f64>() else {
        return self::number(rng);
    };
    let near = match rng.random_range(0..7_u32) {
        0 => -value,
        1 => value * 1e6,
        2 => value * 1e-6,
        3 => value + 1.0,
        4 => value.next_up(),
        5 => 1.0 / value,
        _ => value * rng.random_range(0.5..2.0),
    };
    // In digits where that is short, since a count has no exponent.
    if near.abs() < 1e15 && near.abs() > 1e-6 {
        near.to_string()
    } else {
        format!("{near:e}")
    }
}

/// A word or sign.
pub fn word(rng: &mut ChaCha8Rng) -> String {
    match rng.random_range(0..40_u32) {
        0 => "n".repeat(rng.random_range(1..3000)),
        1 => char::from_u32(rng.random_range(1..0x11_0000)).map_or_else(String::new, String::from),
        _ => pick(rng, &WORDS).to_string(),
    }
}

/// One of several.
pub fn pick<'a, T>(rng: &mut ChaCha8Rng, list: &'a [T]) -> &'a T {
    list.choose(rng)
        .expect("a list to choose from is not empty")
}
