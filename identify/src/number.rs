//! Numbers as a person reads them.

/// Significant digits that a standard error is good for.
const DIGITS_OF_ERROR: i32 = 2;
/// Numbers of these sizes are written without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-3..1e5;
/// Decimals at most without an exponent; an estimate with a smaller error gets one.
const MOST_DECIMALS: i32 = 8;

/// Four digits; a dash where there is no number.
pub(crate) fn short(value: f64) -> String {
    if !value.is_finite() {
        return "-".to_string();
    }
    if value == 0.0 || PLAIN.contains(&value.abs()) {
        let digits = if value == 0.0 {
            0
        } else {
            (3 - magnitude(value)).max(0)
        };
        format!("{value:.precision$}", precision = digits as usize)
    } else {
        format!("{value:.2e}")
    }
}

/// Two digits, for a sentence; a dash where there is no number.
pub(crate) fn rounded(value: f64) -> String {
    let rounded = format!("{value:.1e}").parse::<f64>();
    match rounded {
        Ok(rounded) if rounded.is_finite() => rounded.to_string(),
        _ => "-".to_string(),
    }
}

/// `2.854 ± 0.016`: the standard error with two digits, the value to the same place. An error
/// that is no positive number says nothing of the value's digits and is left out.
pub(crate) fn with_error(value: f64, error: f64) -> String {
    if !(error.is_finite() && error > 0.0 && value.is_finite()) {
        return short(value);
    }
    // Rounded first: 0.0996 has its two digits at the second place, not the third.
    let error: f64 = format!("{error:.digits$e}", digits = DIGITS_OF_ERROR as usize - 1)
        .parse()
        .unwrap_or(error);
    let place = magnitude(error) + 1 - DIGITS_OF_ERROR;
    let larger = value.abs().max(error);
    let decimals = (-place).max(0);
    if PLAIN.contains(&larger) && decimals <= MOST_DECIMALS {
        let decimals = decimals as usize;
        return format!(
            "{} ± {error:.decimals$}",
            unsigned_zero(&format!("{value:.decimals$}"))
        );
    }
    // One exponent for both, so that their digits stand below each other.
    let exponent = magnitude(larger);
    let decimals = (exponent - place).max(0) as usize;
    let scale = |x: f64| x / 10_f64.powi(exponent);
    let mantissa = format!("{:.decimals$}", scale(value));
    format!(
        "({} ± {:.decimals$})e{exponent}",
        unsigned_zero(&mantissa),
        scale(error)
    )
}

/// The power of ten of a number's first digit.
fn magnitude(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

/// Without a sign before zero.
pub(crate) fn unsigned_zero(text: &str) -> &str {
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits,
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_has_two_digits() {
        let said = [0.4448, 97.26, 433.1, 4.0, 0.0, f64::NAN].map(rounded);
        assert_eq!(said, ["0.44", "97", "430", "4", "0", "-"]);
    }

    #[test]
    fn an_error_says_which_digits_are_good() {
        let cases = [
            (2.854_123, 0.163_6, "2.85 ± 0.16"),
            (2.854_123, 0.099_6, "2.85 ± 0.10"),
            (0.008_5, 0.002_5, "0.0085 ± 0.0025"),
            (1234.6, 25.0, "1235 ± 25"),
            (-1e-9, 0.5, "0.00 ± 0.50"),
            (3.214_56e-7, 1.2e-9, "(3.215 ± 0.012)e-7"),
            (-2.0e-8, 4.1e-7, "(-0.2 ± 4.1)e-7"),
            (0.5, f64::INFINITY, "0.5000"),
            (0.0, f64::NAN, "0"),
        ];
        for (value, error, expected) in cases {
            assert_eq!(with_error(value, error), expected, "{value} ± {error}");
        }
    }

    #[test]
    fn four_digits() {
        for (value, expected) in [
            (0.366_4, "0.3664"),
            (16.8218, "16.82"),
            (3.2e-7, "3.20e-7"),
            (f64::INFINITY, "-"),
        ] {
            assert_eq!(short(value), expected);
        }
    }
}
