//! Physical dimensions, for checking that sums and equations make sense.
//!
//! Angles have dimension one, as in the SI: `rad` may be written for the
//! reader, and `torque = force · lever` needs no conversion.

use std::fmt;
use std::ops::{Div, Mul};

/// Base dimensions: length, mass, time, current, temperature.
const BASES: [&str; 5] = ["m", "kg", "s", "A", "K"];
/// Exponents are kept in twelfths, so that roots of dimensions are exact.
const PARTS: i32 = 12;

/// A product of powers of base dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Dimension([i32; 5]);

impl Dimension {
    /// A pure number.
    pub const ONE: Self = Self([0; 5]);
    /// Length.
    pub const LENGTH: Self = Self([PARTS, 0, 0, 0, 0]);
    /// Time.
    pub const TIME: Self = Self([0, 0, PARTS, 0, 0]);
    /// Energy, and torque.
    pub const ENERGY: Self = Self([2 * PARTS, PARTS, -2 * PARTS, 0, 0]);

    /// The dimension of a named unit of the SI. `None` for unknown names and
    /// for units with a factor (`deg`, `mm`): numbers are in SI units.
    pub fn of_unit(name: &str) -> Option<Self> {
        let exponents = match name {
            "rad" | "sr" => [0, 0, 0, 0, 0],
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
        Some(Self(exponents.map(|e| e * PARTS)))
    }

    /// This dimension to the power of an integer.
    pub fn powi(self, n: i32) -> Self {
        Self(self.0.map(|e| e.saturating_mul(n)))
    }

    /// This dimension to any power that keeps exponents in twelfths.
    pub fn powf(self, n: f64) -> Option<Self> {
        let mut result = self;
        for exponent in &mut result.0 {
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
        let factors = result.0.iter_mut().zip(other.0);
        factors.for_each(|(a, b)| *a = a.saturating_add(b));
        result
    }
}

impl Div for Dimension {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self * other.powi(-1)
    }
}

/// A unit in the model's language as a person reads it: `N·m` for `N*m`.
pub fn shown_unit(unit: &str) -> String {
    unit.replace('*', "·")
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Forces are read more easily as newtons than as base units.
        let newton = Self::of_unit("N").unwrap_or_default();
        let mechanical = self.0[1] == PARTS && self.0[2] <= -PARTS;
        if mechanical {
            let rest = *self / newton;
            return match rest {
                Self::ONE => f.write_str("N"),
                rest => rest.write_factors(f, Some("N")),
            };
        }
        self.write_factors(f, None)
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
        let named = || [1, 0, 2, 3, 4].map(|i| (BASES[i], self.0[i])).into_iter();
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
    fn roots_are_exact() {
        let area = Dimension::of_unit("m").unwrap().powi(2);
        assert_eq!(area.powf(0.5), Dimension::of_unit("m"));
        let root = Dimension::of_unit("m").and_then(|m| m.powf(1.5));
        assert_eq!(root.unwrap_or_default().to_string(), "m^(3/2)");
    }
}
