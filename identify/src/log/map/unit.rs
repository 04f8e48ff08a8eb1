//! Units of measured columns, and how much of an SI unit each is.

use std::f64::consts::{PI, TAU};

/// Units by the name under which a map states them. What is not here is made of these by
/// `*`, `/` and `^`: `deg/s^2`, `mN*m`.
const UNITS: [(&str, f64); 38] = [
    ("rad", 1.0),
    ("mrad", 1e-3),
    ("deg", PI / 180.0),
    ("turn", TAU),
    ("rev", TAU),
    ("rpm", TAU / 60.0),
    ("Hz", TAU),
    ("m", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("km", 1e3),
    ("inch", 0.0254),
    ("s", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("ns", 1e-9),
    ("min", 60.0),
    ("h", 3600.0),
    ("kg", 1.0),
    ("N", 1.0),
    ("mN", 1e-3),
    ("kN", 1e3),
    ("kgf", 9.806_65),
    ("lbf", 4.448_221_615_260_5),
    ("Nm", 1.0),
    ("mNm", 1e-3),
    ("kNm", 1e3),
    ("A", 1.0),
    ("mA", 1e-3),
    ("V", 1.0),
    ("mV", 1e-3),
    ("W", 1.0),
    ("kW", 1e3),
    ("Pa", 1.0),
    ("bar", 1e5),
    ("g0", 9.806_65),
    ("1", 1.0),
];

/// What a unit is in SI; angles in radians. The error says what could not be read.
pub(super) fn factor(text: &str) -> Result<f64, String> {
    let mut product = 1.0;
    let mut rest = text.trim();
    let mut divide = false;
    loop {
        let end = rest.find(['*', '/', '·']).unwrap_or(rest.len());
        let value = power(rest[..end].trim())?;
        product = if divide {
            product / value
        } else {
            product * value
        };
        let Some(sign) = rest[end..].chars().next() else {
            return Ok(product);
        };
        divide = sign == '/';
        rest = &rest[end + sign.len_utf8()..];
    }
}

/// `s^2`
fn power(text: &str) -> Result<f64, String> {
    let (name, exponent) = text.split_once('^').unwrap_or((text, "1"));
    let exponent: i32 = exponent
        .trim()
        .parse()
        .map_err(|_| format!("`{exponent}` is no whole power"))?;
    let name = name.trim();
    match UNITS.iter().find(|(known, _)| *known == name) {
        Some((_, factor)) => Ok(factor.powi(exponent)),
        None => Err(unknown(name)),
    }
}

fn unknown(name: &str) -> String {
    let names: Vec<&str> = UNITS.iter().map(|(known, _)| *known).collect();
    let other_case = names.iter().find(|known| known.eq_ignore_ascii_case(name));
    let near = other_case.copied().or_else(|| {
        let close = similar::get_close_matches(name, &names, 1, 0.6);
        close.first().copied()
    });
    match near {
        Some(near) => format!("there is no unit `{name}`; did you mean `{near}`?"),
        None => format!(
            "there is no unit `{name}`; the units are: {}, and what `*`, `/` and `^` make of them",
            names.join(", ")
        ),
    }
}

/// The full turn of an angle in this unit, if it is one.
pub(super) fn turn(text: &str) -> Option<f64> {
    let angle = ["rad", "mrad", "deg", "turn", "rev"];
    let factor = angle.contains(&text.trim()).then(|| factor(text).ok())?;
    factor.map(|factor| TAU / factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_made_of_units() {
        let close = |text: &str, expected: f64| {
            let found = factor(text).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-15, "{text}: {found}");
        };
        close("deg", 0.017_453_292_519_943_295);
        close("rpm", 0.104_719_755_119_659_77);
        close(" deg / s^2 ", 0.017_453_292_519_943_295);
        close("mN*m", 1e-3);
        close("rad/ms", 1e3);
        close("1/min", 1.0 / 60.0);
        assert_eq!(turn("deg"), Some(360.0));
        assert_eq!(turn("deg/s"), None);
    }

    #[test]
    fn what_is_no_unit_is_said() {
        insta::assert_snapshot!(factor("degree").unwrap_err(), @"there is no unit `degree`; did you mean `deg`?");
        insta::assert_snapshot!(factor("nm").unwrap_err(), @"there is no unit `nm`; did you mean `Nm`?");
        insta::assert_snapshot!(factor("m^x").unwrap_err(), @"`x` is no whole power");
        assert!(factor("").is_err() && factor("m**s").is_err() && factor("/s").is_err());
    }
}
