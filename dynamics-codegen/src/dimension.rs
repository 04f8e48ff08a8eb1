//! Physical dimensions, for checking that sums and equations make sense.
//!
//! Angles have dimension one, as in the SI: `rad` may be written for the
//! reader, and `torque = force · lever` needs no conversion.

use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::{Div, Mul};

/// Base dimensions: length, mass, time, current, temperature.
const BASES: [&str; 5] = ["m", "kg", "s", "A", "K"];
/// Exponents are kept in twelfths, so that roots of dimensions are exact.
const PARTS: i32 = 12;

/// A product of powers of base dimensions.
///
/// An angle is a pure number: `rad` makes no difference to what may be added to what. It
/// is remembered beside the exponents for display alone, so that the rate of what was
/// declared in `rad` reads `rad/s`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Dimension {
    exponents: [i32; 5],
    /// The exponent of `rad`; no part of the dimension.
    angle: i32,
}

impl PartialEq for Dimension {
    fn eq(&self, other: &Self) -> bool {
        self.exponents == other.exponents
    }
}

impl Eq for Dimension {}

impl Hash for Dimension {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.exponents.hash(state);
    }
}

impl Dimension {
    /// A pure number.
    pub const ONE: Self = Self::of([0; 5]);
    /// An angle: a pure number that is shown in `rad`.
    pub const ANGLE: Self = Self {
        exponents: [0; 5],
        angle: PARTS,
    };
    /// Length.
    pub const LENGTH: Self = Self::of([PARTS, 0, 0, 0, 0]);
    /// Time.
    pub const TIME: Self = Self::of([0, 0, PARTS, 0, 0]);
    /// Energy, and torque.
    pub const ENERGY: Self = Self::of([2 * PARTS, PARTS, -2 * PARTS, 0, 0]);

    const fn of(exponents: [i32; 5]) -> Self {
        Self {
            exponents,
            angle: 0,
        }
    }

    /// The dimension of a named unit of the SI. `None` for unknown names and
    /// for units with a factor (`deg`, `mm`): numbers are in SI units.
    pub fn of_unit(name: &str) -> Option<Self> {
        let exponents = match name {
            "rad" => return Some(Self::ANGLE),
            "sr" => [0, 0, 0, 0, 0],
            "m" => [1, 0, 0, 0, 0],
            "kg" => [0, 1, 0, 0, 0],
            "s" => [0, 0, 1, 0, 0],
            "A" => [0, 0, 0, 1, 0],
            "K" => [0, 0, 0, 0, 1],
            "Hz" => [0, 0, -1, 0, 0],
            "N" => [1, 1, -2, 0, 0],
            "Nm" | "J" => [2, 1, -2, 0, 0],
            "W" => [2, 1, -3, 0, 0],
            "Pa" => [-1, 1, -2, 0, 0],
            "C" => [0, 0, 1, 1, 0],
            "V" => [2, 1, -3, -1, 0],
            "ohm" => [2, 1, -3, -2, 0],
            "H" => [2, 1, -2, -2, 0],
            "F" => [-2, -1, 4, 2, 0],
            "T" => [0, 1, -2, -1, 0],
            "Wb" => [2, 1, -2, -1, 0],
            _ => return None,
        };
        Some(Self::of(exponents.map(|e| e * PARTS)))
    }

    /// This dimension to the power of an integer.
    pub fn powi(self, n: i32) -> Self {
        Self {
            exponents: self.exponents.map(|e| e.saturating_mul(n)),
            angle: self.angle.saturating_mul(n),
        }
    }

    /// This dimension to any power that keeps exponents in twelfths.
    pub fn powf(self, n: f64) -> Option<Self> {
        let mut result = self;
        for exponent in result.exponents.iter_mut().chain([&mut result.angle]) {
            let scaled = f64::from(*exponent) * n;
            if (scaled - scaled.round()).abs() > 1e-9 || scaled.abs() > 1e6 {
                return None;
            }
            *exponent = scaled.round() as i32;
        }
        Some(result)
    }

    /// The dimension of the time derivative.
    pub fn rate(self) -> Self {
        self / Self::TIME
    }
}

impl Mul for Dimension {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut result = self;
        // No unit that means anything comes near the ends of the range.
        let factors = result.exponents.iter_mut().zip(other.exponents);
        factors.for_each(|(a, b)| *a = a.saturating_add(b));
        result.angle = result.angle.saturating_add(other.angle);
        result
    }
}

impl Div for Dimension {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self * other.powi(-1)
    }
}

/// A unit in the model's language as a person reads it: `N·m` for `N*m`. So it stands in
/// summaries, reports and what is generated; messages about a model's text, and whatever may be
/// written into one, keep the language's own form.
pub fn shown_unit(unit: &str) -> String {
    unit.replace('*', "·")
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Forces are read more easily as newtons than as base units.
        let newton = Self::of_unit("N").unwrap_or_default();
        let mechanical = self.exponents[1] == PARTS && self.exponents[2] <= -PARTS;
        if mechanical {
            return (*self / newton).write_factors(f, Some("N"));
        }
        // Beside other units it goes without saying: torque times angle is energy.
        let [length, mass, _, current, temperature] = self.exponents;
        let in_time_alone = [length, mass, current, temperature] == [0; 4];
        let lead = (in_time_alone && self.angle == PARTS).then_some("rad");
        self.write_factors(f, lead)
    }
}

impl Dimension {
    fn write_factors(self, f: &mut fmt::Formatter<'_>, lead: Option<&str>) -> fmt::Result {
        let power = |base: &str, exponent: i32| match (exponent / PARTS, exponent % PARTS) {
            (1, 0) => base.to_string(),
            (n, 0) => format!("{base}^{n}"),
            _ => {
                // Twelve has no other divisors.
                let shared = [6, 4, 3, 2]
                    .into_iter()
                    .find(|d| exponent % d == 0 && PARTS % d == 0);
                let divisor = shared.unwrap_or(1);
                format!("{base}^({}/{})", exponent / divisor, PARTS / divisor)
            }
        };
        // Engineers write the mass first.
        let named = || {
            [1, 0, 2, 3, 4]
                .map(|i| (BASES[i], self.exponents[i]))
                .into_iter()
        };
        let mut above: Vec<String> = lead.map(str::to_string).into_iter().collect();
        above.extend(
            named()
                .filter(|(_, e)| *e > 0)
                .map(|(base, e)| power(base, e)),
        );
        let below: Vec<String> = named()
            .filter(|(_, e)| *e < 0)
            .map(|(base, e)| power(base, e.saturating_neg()))
            .collect();
        if above.is_empty() {
            f.write_str("1")?;
        }
        f.write_str(&above.join("*"))?;
        for factor in below {
            write!(f, "/{factor}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_print_as_engineers_write_them() {
        let unit = |name| Dimension::of_unit(name).unwrap();
        assert_eq!((unit("N") * unit("m")).to_string(), "N*m");
        assert_eq!((unit("N") * unit("s") / unit("m")).to_string(), "N*s/m");
        assert_eq!((unit("m") / unit("s").powi(2)).to_string(), "m/s^2");
        assert_eq!((unit("m") * unit("kg")).to_string(), "kg*m");
        assert_eq!(Dimension::ONE.to_string(), "1");
    }

    #[test]
    fn angles_are_shown_and_make_no_difference() {
        let unit = |name| Dimension::of_unit(name).unwrap();
        let rate = unit("rad").rate();
        assert_eq!(rate.to_string(), "rad/s");
        assert_eq!(rate.rate().to_string(), "rad/s^2");
        assert_eq!(unit("Hz").to_string(), "1/s");
        assert_eq!(rate, unit("Hz"));
        assert_eq!((unit("m") * rate).to_string(), "m/s");
        assert_eq!((Dimension::ENERGY / unit("rad")).to_string(), "N*m");
        assert_eq!((unit("rad") / unit("rad")).to_string(), "1");
    }

    #[test]
    fn roots_are_exact() {
        let area = Dimension::of_unit("m").unwrap().powi(2);
        assert_eq!(area.powf(0.5), Dimension::of_unit("m"));
        let root = Dimension::of_unit("m").and_then(|m| m.powf(1.5));
        assert_eq!(root.unwrap_or_default().to_string(), "m^(3/2)");
    }
}
