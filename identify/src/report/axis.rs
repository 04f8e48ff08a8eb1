//! An axis: what it spans, in which power of ten, its numbers and its title.

use plotters::coord::ranged1d::{BoldPoints, Ranged};
use plotters::coord::types::RangedCoordf64;

/// Height of the letters of a figure, in its own pixels.
pub(super) const EM: f64 = 30.0;

/// One axis of a chart, in multiples of `10^power` of its unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// What its numbers are to be multiplied with, as a power of ten.
    power: i32,
    /// What it spans.
    pub span: (f64, f64),
    /// How many numbers stand along it at most.
    pub count: usize,
    /// Decimals of its numbers.
    decimals: usize,
}

/// Numbers along an axis at most.
const NUMBERS: usize = 8;

impl Axis {
    /// An axis over a range in its unit.
    pub fn new((low, high): (f64, f64)) -> Self {
        let power = power(low.abs().max(high.abs()), high - low);
        let mut axis = Self {
            power,
            span: (low, high),
            count: NUMBERS,
            decimals: 0,
        };
        axis.span = (axis.scaled(low), axis.scaled(high));
        axis.decimals = axis.fewest_decimals();
        axis
    }

    /// With no more numbers than stand side by side in a width.
    pub fn within(mut self, width: f64) -> Self {
        let beside = width / (self.widest() + 2.0 * EM);
        self.count = (beside as usize).clamp(2, NUMBERS);
        self.decimals = self.fewest_decimals();
        self
    }

    /// A value in the multiples that the axis shows.
    pub fn scaled(&self, value: f64) -> f64 {
        // Two factors: the inverse of the smallest number is none.
        let half = self.power / 2;
        value / 10f64.powi(half) / 10f64.powi(self.power - half)
    }

    /// The number at a tick.
    pub fn label(&self, value: f64) -> String {
        let text = format!("{value:.decimals$}", decimals = self.decimals);
        let is_zero = text.chars().all(|c| "-0.".contains(c));
        if is_zero { "0".into() } else { text }
    }

    /// Width of the widest number.
    pub fn widest(&self) -> f64 {
        let widths = self
            .ticks()
            .into_iter()
            .map(|tick| width(&self.label(tick)));
        widths.fold(0.0, f64::max)
    }

    /// `quantity [unit]` with the power of ten before the unit.
    pub fn title(&self, title: &str) -> String {
        match title.rfind('[') {
            Some(at) if self.power != 0 => {
                let (quantity, unit) = title.split_at(at + 1);
                format!("{quantity}10{}\u{a0}{unit}", superscript(self.power))
            }
            _ => title.into(),
        }
    }

    fn ticks(&self) -> Vec<f64> {
        let (low, high) = self.span;
        RangedCoordf64::from(low..high).key_points(BoldPoints(self.count))
    }

    /// So many that every tick stands where its number says.
    fn fewest_decimals(&self) -> usize {
        let ticks = self.ticks();
        let steps = ticks.windows(2).map(|pair| pair[1] - pair[0]);
        let step = steps.fold(f64::INFINITY, f64::min);
        let exact = |decimals: usize| {
            let unit = 10f64.powi(decimals as i32);
            let miss = |tick: &f64| ((tick * unit).round() / unit - tick).abs();
            ticks.iter().all(|tick| miss(tick) < 0.01 * step)
        };
        (0..MOST_DECIMALS)
            .find(|&d| exact(d))
            .unwrap_or(MOST_DECIMALS)
    }
}

const MOST_DECIMALS: usize = 12;

/// Width of a text of one line.
pub(super) fn width(text: &str) -> f64 {
    text.chars().map(advance).sum()
}

/// Width of a letter in a broad sans-serif, at most.
fn advance(letter: char) -> f64 {
    let share = match letter {
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 1.0,
        ' ' | '_' | '.' | ',' | ':' | '-' | '/' | '(' | ')' | '[' | ']' | '\'' | '|' => 0.5,
        'f' | 'i' | 'j' | 'l' | 'r' | 't' | 'I' => 0.42,
        'A'..='Z' | '&' | '<' | '>' | '=' | '+' | '~' => 0.85,
        _ if letter.is_ascii() => 0.64,
        _ if letter.is_alphanumeric() => 1.0,
        _ => 0.64,
    };
    share * EM
}

/// Lines of a title that fit a width, broken after blanks and underscores if possible.
pub(super) fn wrapped(title: &str, width: f64) -> Vec<String> {
    let mut rest: Vec<char> = title.chars().collect();
    let mut lines = Vec::new();
    loop {
        let fitting = fitting(&rest, width);
        if fitting == rest.len() {
            break;
        }
        let after = rest[..fitting].iter().rposition(|c| " _".contains(*c));
        let tail = rest.split_off(after.map_or(fitting, |at| at + 1));
        lines.push(std::mem::replace(&mut rest, tail));
    }
    lines.push(rest);
    let text = |line: &Vec<char>| line.iter().collect::<String>().trim_end().to_string();
    lines.iter().map(text).collect()
}

/// How many of the letters fit a width; one at least, if there is one.
fn fitting(letters: &[char], width: f64) -> usize {
    let ends = letters.iter().scan(0.0, |end, &letter| {
        *end += advance(letter);
        Some(*end)
    });
    let count = ends.take_while(|&end| end <= width).count();
    count.max(letters.len().min(1))
}

/// Zero for sizes that are read easily and for what hardly differs, as seconds since
/// 1970 do, else a multiple of three.
fn power(size: f64, span: f64) -> i32 {
    let is_easy = (1e-2..1e5).contains(&size);
    let is_far_off = (1e5..1e12).contains(&size) && span < 1e-3 * size;
    if size == 0.0 || !size.is_finite() || is_easy || is_far_off {
        return 0;
    }
    3 * (size.log10() / 3.0).floor() as i32
}

fn superscript(power: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    };
    power.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        let axis = Axis::new((low, high));
        axis.ticks().iter().map(|&tick| axis.label(tick)).collect()
    }

    #[test]
    fn numbers_tell_neighbours_apart() {
        assert_eq!(
            labels(-0.25, 0.45),
            ["-0.2", "-0.1", "0", "0.1", "0.2", "0.3", "0.4"]
        );
        assert_eq!(labels(1e6, 3e6), labels(1.0, 3.0));
        assert_eq!(labels(-2e-9, 1e-9), labels(-2.0, 1.0));
        assert_eq!(labels(1.7e9, 1.7e9 + 20.0)[1], "1700000005");
        for range in [
            (1.7e9, 1.7e9 + 20.0),
            (0.999, 1.0),
            (1e-310, 2e-310),
            (-1e300, 1e300),
        ] {
            let labels = labels(range.0, range.1);
            let mut once = labels.clone();
            once.dedup();
            assert!(labels.len() > 1 && once == labels, "{range:?}: {labels:?}");
        }
    }

    #[test]
    fn powers_stand_before_the_unit() {
        let title = |size: f64| Axis::new((0.0, size)).title("force, a[1] [N·m]");
        assert_eq!(title(1.0), "force, a[1] [N·m]");
        assert_eq!(title(2e-9), "force, a[1] [10⁻⁹\u{a0}N·m]");
        assert_eq!(title(3e6), "force, a[1] [10⁶\u{a0}N·m]");
    }

    #[test]
    fn long_numbers_are_few() {
        let short = Axis::new((0.0, 9.0)).within(900.0);
        let long = Axis::new((1_700_000_000.0, 1_700_000_000.5)).within(900.0);
        assert!(long.count < short.count, "{long:?}");
        assert!(long.widest() * long.count as f64 <= 900.0);
    }

    #[test]
    fn titles_break_where_names_do() {
        let line = width("force, left_a");
        assert_eq!(wrapped("lag [s]", line), ["lag [s]"]);
        assert_eq!(
            wrapped("force, left_arm [N]", line),
            ["force, left_", "arm [N]"]
        );
        assert_eq!(wrapped(&"é".repeat(18), 6.0 * EM).len(), 3);
        assert_eq!(wrapped("ab", 0.0), ["a", "b"]);
        assert_eq!(wrapped("", 0.0), [""]);
    }
}
