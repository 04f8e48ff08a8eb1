//! A page that needs nothing else: bodies in space beside signals over time. Its scripts are our own.
//!
//! A page puts `drawn` (the camera's `distance`, `motion` with its `interval` and `states`, `charts`) and the scripts
//! [`SPACE`], [`DRAWING`], one that has `drawMotion`, [`CURVES`] and [`PLAYER`] together, in this order.

mod page;
mod scene;
mod signals;

pub use page::page;
pub use scene::Scene;
pub use signals::{Frames, charts};

use serde_json::{Value, json};

/// Vectors, and the camera.
pub const SPACE: &str = include_str!("space.js");
/// What is drawn with it.
pub const DRAWING: &str = include_str!("drawing.js");
/// Curves over time.
pub const CURVES: &str = include_str!("curves.js");
/// One time for all.
pub const PLAYER: &str = include_str!("player.js");
/// How a page looks.
pub const STYLE: &str = include_str!("style.css");

/// Decimals of numbers that are drawn,
const DECIMALS: f64 = 1e5;
/// but for small ones, of which this many digits are kept: the interval of a short log.
const DIGITS: usize = 6;
const SMALL: f64 = 1e-2;
/// What is nothing.
const NOTHING: f64 = 1e-9;

/// What is drawn, as JSON that cannot end the script element that holds it, with as many decimals as are seen.
pub fn inside_script(drawn: Value) -> String {
    rounded(drawn).to_string().replace('<', "\\u003c")
}

fn short(x: f64) -> f64 {
    let digits = format!("{x:.0$e}", DIGITS - 1);
    match x.abs() {
        size if size < NOTHING => 0.0,
        size if size < SMALL => digits.parse().unwrap_or(x),
        _ => (x * DECIMALS).round() / DECIMALS,
    }
}

fn rounded(value: Value) -> Value {
    match value {
        Value::Number(number) => match number.as_f64() {
            Some(x) if !number.is_i64() => json!(short(x)),
            _ => Value::Number(number),
        },
        Value::Array(values) => values.into_iter().map(rounded).collect(),
        Value::Object(fields) => fields.into_iter().map(|(k, v)| (k, rounded(v))).collect(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_end_no_script() {
        let drawn = json!([0.123_456_7, 2e-4 / 3.0, 1e-17, 7, "</script>"]);
        let text = inside_script(drawn);
        assert_eq!(text, r#"[0.12346,0.0000666667,0.0,7,"\u003c/script>"]"#);
    }
}
