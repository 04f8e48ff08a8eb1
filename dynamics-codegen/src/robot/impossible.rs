//! Inertias that no body can have, wherever they are stated.

use super::format::Format;
use super::spatial::{Matrix3, principal_values};
use crate::diagnostic::{Diagnostic, Severity};
use crate::source::Span;

/// Below this share of the largest moment, a violation is the computer's
/// round-off and not worth a word.
const ROUND_OFF: f64 = 1e-9;

/// What no part of a robot comes near, in kg·m²: smaller excesses are the dust
/// of somebody's change of coordinates.
const DUST: f64 = 1e-15;

/// Up to this share it is the rounding of a published figure: a warning.
const ROUNDED_FIGURES: f64 = 1e-2;

/// How far `I` is from the inertia of any body, as a share of its largest
/// principal moment: `(I₃ − I₁ − I₂)/I₃` with `I₁ ≤ I₂ ≤ I₃`. Principal moments
/// are sums of squared distances to the planes of the other two axes, hence
/// `I₁ + I₂ ≥ I₃`, which implies `I₁ ≥ 0` (Traversaro et al. 2016,
/// *Identification of fully physical consistent inertial parameters*).
fn violation([smallest, middle, largest]: [f64; 3]) -> f64 {
    let excess = largest - middle - smallest;
    let scale = largest.abs().max(smallest.abs());
    if excess <= DUST { 0.0 } else { excess / scale }
}

/// How to mend an inertia that no body has.
pub(crate) const MEND: &str =
    "check the units (kg·m²), the signs, and that the tensor is about the centre of mass";

/// What is wrong with an inertia tensor about the centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Impossible {
    /// What was found, in one line.
    pub what: String,
    /// The rule that it breaks.
    pub why: &'static str,
    share: f64,
}

impl Impossible {
    /// `None` if a body has this tensor, in kg·m², up to round-off.
    pub fn of(tensor: &Matrix3) -> Option<Self> {
        let moments = principal_values(tensor);
        let share = violation(moments);
        if share <= ROUND_OFF {
            return None;
        }
        let zero = ROUND_OFF * moments[2].abs().max(moments[0].abs());
        let cleaned = moments.map(|x| if x.abs() < zero { 0.0 } else { x });
        let [a, b, c] = cleaned.map(digits);
        let (what, why) = if cleaned[0] < 0.0 {
            (
                format!("a principal moment of inertia is negative: {a}"),
                "moments of inertia are sums of squares",
            )
        } else {
            (
                format!("no body has this inertia: {a} + {b} < {c}"),
                "no principal moment may exceed the sum of the other two",
            )
        };
        Some(Self { what, why, share })
    }

    /// What to say if it may be the rounding of a published figure, which is let pass.
    pub fn rounding(&self) -> Option<String> {
        (self.share <= ROUNDED_FIGURES).then(|| {
            let percent = digits(100.0 * self.share);
            format!("{percent} % of the largest is missing, which may be rounding: the figures are used as they stand")
        })
    }

    /// What to say of the body `name` of a description; `welded` if others are fixed to it, and
    /// the whole is possible.
    pub fn finding(&self, at: Span, format: Format, name: &str, welded: bool) -> Diagnostic {
        let kind = format.body();
        let what = format!("{kind} `{name}`: {}", self.what);
        if let Some(rounding) = self.rounding() {
            return Diagnostic::warning(at, what).label(self.why).help(rounding);
        }
        if welded {
            return Diagnostic::warning(at, what).label(self.why).help(format!(
                "fixed joints weld this {kind} to others, and the whole is a possible body: the figures are used as they stand",
            ));
        }
        Diagnostic::error(at, what).label(self.why).help(MEND)
    }
}

/// Four significant digits.
fn digits(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude == 0.0 || (1e-3..1e4).contains(&magnitude) {
        let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
        return format!("{rounded}");
    }
    format!("{x:.3e}")
}

/// Makes warnings of errors about inertias: whoever published them may have no better ones.
pub(crate) fn excuse(findings: &mut [Diagnostic]) {
    for finding in findings
        .iter_mut()
        .filter(|f| f.severity == Severity::Error)
    {
        finding.severity = Severity::Warning;
        finding.help = vec![
            "the figures are used as they stand: energy may become negative, and then no motion \
             can be predicted; `dynamics fit --inertia consistent` finds ones that a body can have"
                .to_string(),
        ];
    }
}
