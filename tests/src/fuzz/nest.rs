//! Depth: a piece of a text inside many brackets.

use super::scraps::pick;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// What opens and closes in one of our languages.
const BRACKETS: [(&str, &str); 14] = [
    ("(", ")"),
    ("[", "]"),
    ("{", "}"),
    ("sin(", ")"),
    ("max(1, ", ")"),
    ("rotate_z(", ")"),
    ("-", ""),
    ("1^", ""),
    ("/*", "*/"),
    ("<a>", "</a>"),
    ("<link name=\"a\">", "</link>"),
    ("{\"q\": ", "}"),
    ("x = {", "}"),
    ("\"", "\""),
];

/// Depths: what people write, what readers allow (64, 128), and what overflows a stack that
/// does not count.
const DEPTHS: [usize; 8] = [2, 5, 20, 62, 66, 130, 1000, 20_000];

/// The text inside brackets of one sort.
pub fn nested(rng: &mut ChaCha8Rng, text: &str) -> String {
    let (open, close) = pick(rng, &BRACKETS);
    let depth = *pick(rng, &DEPTHS);
    // Half of the time as many close as have opened.
    let closed = if rng.random_bool(0.5) { depth } else { 0 };
    format!("{}{text}{}", open.repeat(depth), close.repeat(closed))
}
