//! A rate from some trials, and how well it is known.

use std::fmt;

/// Normal quantile of 95 %.
const QUANTILE: f64 = 1.959_963_985;

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rate {
    /// That went well.
    pub well: usize,
    /// Of these.
    pub of: usize,
}

impl Rate {
    /// Of some outcomes.
    pub fn of(outcomes: impl Iterator<Item = bool>) -> Self {
        let count = |rate: Self, well: bool| Self {
            well: rate.well + usize::from(well),
            of: rate.of + 1,
        };
        outcomes.fold(Self { well: 0, of: 0 }, count)
    }

    /// The share; nothing of nothing is none.
    pub fn share(self) -> f64 {
        self.well as f64 / self.of.max(1) as f64
    }

    /// Wilson's interval of 95 % (J. Am. Stat. Assoc. 22, 1927).
    pub fn interval(self) -> [f64; 2] {
        let (n, p) = (self.of.max(1) as f64, self.share());
        let square = QUANTILE * QUANTILE / n;
        let middle = (p + square / 2.0) / (1.0 + square);
        let half = QUANTILE * (p * (1.0 - p) / n + square / (4.0 * n)).sqrt() / (1.0 + square);
        [middle - half, middle + half]
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.interval().map(|share| 100.0 * share);
        let share = 100.0 * self.share();
        let Self { well, of } = self;
        write!(f, "{well} of {of}, {share:.0} % ({low:.0} to {high:.0} %)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe (Stat. Med. 17, 1998), table I, method 3: 81 of 263, 15 of 148, 0 of 20, 1 of 29.
    #[test]
    fn intervals_are_those_of_the_literature() {
        for (well, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let [a, b] = Rate { well, of }.interval();
            assert!((a - low).abs() < 1e-4 && (b - high).abs() < 1e-4, "{a} {b}");
        }
    }
}
