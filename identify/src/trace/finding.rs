//! What was found, in words and numbers.

use super::candidate::Candidate;
use super::dictionary::Dictionary;
use super::one_clock::on_one_clock;
use super::outcome::Basis;
use super::remaining::Remaining;
use super::selection::{Selection, Term};
use super::separate::SeparatingMotion;
use super::settings::MARGIN;
use super::subject::Subject;
use dynamics_codegen::syntax::PortKind;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::collections::BTreeMap;

/// What kind of error the model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Verdict {
    /// A force is missing.
    Effect,
    /// Only a parameter has another value.
    Parameter,
    /// An input or a sensor is not what it seems.
    Channel,
    /// The log agrees with the model.
    None,
    /// Something is missing that no candidate explains.
    Unknown,
}

/// A parameter's estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ParameterEstimate {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation: infinite (`null` in JSON) where the log does not determine it, not
    /// a number where nothing was estimated.
    pub std: f64,
    /// Its unit.
    pub unit: String,
}

/// Times its value by which a shape parameter may be off and still be called known.
const OPEN: f64 = 10.0;

impl ParameterEstimate {
    /// Whether the log says nothing about it: how quickly friction turns over where it never does.
    pub fn is_open(&self) -> bool {
        self.std.is_infinite() || self.std > OPEN * self.value.abs() && self.value != 0.0
    }
}

/// An effect and where it acts; a tilt of gravity acts nowhere in particular.
pub(crate) fn with_places(effect: &str, on: &[String]) -> String {
    match on {
        [] => effect.to_string(),
        on => format!("{effect} ({})", on.join(", ")),
    }
}

/// An explanation that the log cannot tell from the finding.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rival {
    /// The effect, or `parameter`.
    pub effect: String,
    /// What it acts on.
    pub on: Vec<String>,
    /// Nats by which it explains the log better (or, if negative, worse).
    pub evidence_difference: f64,
    /// A motion that would tell the two apart, if a simple change of the logged one would.
    pub separating_motion: Option<SeparatingMotion>,
}

impl Rival {
    /// A subject that explains the log better by some nats, with nothing known that would tell.
    pub(super) fn new(subject: &Subject, better: f64) -> Self {
        Self {
            effect: subject.name().to_string(),
            on: subject.on(),
            evidence_difference: better,
            separating_motion: None,
        }
    }
}

/// One thing the model lacks.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Finding {
    /// The effect, or `parameter`.
    pub effect: String,
    /// The coordinates, inputs or parameters it is about.
    pub on: Vec<String>,
    /// What each of its statements in the model is about: one, but for a delay that several
    /// inputs share.
    #[serde(skip)]
    pub places: Vec<Vec<String>>,
    /// Its parameters.
    pub parameters: BTreeMap<String, ParameterEstimate>,
    /// Nats by which the log is better explained with it, less its price.
    pub evidence: f64,
    /// What explains the log about as well.
    pub confounded_with: Vec<Rival>,
    /// Bodies on which it would be the same law, whatever the log: those that its own is rigidly connected with.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub same_on: Vec<String>,
    /// Whether two measured columns say so, a command and what the drive made of it, whatever
    /// else is missing.
    #[serde(skip)]
    pub is_measured: bool,
}

/// What remains is a finding if the log is this many nats more likely with it,
const REMARKABLE_EVIDENCE: f64 = 10.0;
/// and if it moves the machine by at least this share of its accelerations.
const REMARKABLE_SHARE: f64 = 3e-3;
/// Findings that leave more than this share of the unexplained accelerations name too
/// little.
const MOSTLY_UNEXPLAINED: f64 = 0.1;

/// Whether something remains that the findings do not explain.
pub(super) fn something_remains(remaining: &Remaining) -> bool {
    remaining.evidence > REMARKABLE_EVIDENCE && remaining.share_after > REMARKABLE_SHARE
}

/// Whether findings leave so much that it must be asked what it is.
pub(super) fn much_remains(basis: Basis, selection: &Selection) -> bool {
    let remaining = &selection.remaining;
    remaining.share_after > MOSTLY_UNEXPLAINED * remaining.share_before
        && (basis == Basis::Forces || something_remains(remaining))
}

/// Judges the outcome of a selection. `is_other` says whether what it leaves shows that its findings
/// are not what the machine has.
pub(super) fn verdict(dictionary: &Dictionary, selection: &Selection, is_other: bool) -> Verdict {
    let unexplained = something_remains(&selection.remaining);
    let about = |test: fn(&Candidate) -> bool| {
        selection
            .terms
            .iter()
            .any(|term| test(&dictionary.candidates[term.candidate]))
    };
    let known = selection.estimate.known();
    let nameless = |term: &Term| {
        is_without_its_mark(dictionary, term.candidate, &selection.values, known)
            || says_no_strength(dictionary, term.candidate, &selection.values, known)
    };
    if selection.terms.is_empty() {
        if unexplained {
            Verdict::Unknown
        } else {
            Verdict::None
        }
    } else if is_other || selection.terms.iter().any(nameless) {
        Verdict::Unknown
    } else if about(|c| !c.channel && c.subject.name() != "parameter") {
        Verdict::Effect
    } else if about(|c| c.channel) {
        Verdict::Channel
    } else {
        Verdict::Parameter
    }
}

/// Whether a shape that gives an effect its name has vanished: LuGre's friction that does
/// not rise towards standstill is some hysteresis (Dahl's, Bouc's and Wen's, …), and the log
/// does not say which.
pub(super) fn is_without_its_mark(
    dictionary: &Dictionary,
    candidate: usize,
    values: &[f64],
    (parameters, covariance): (&[usize], &DMatrix<f64>),
) -> bool {
    let candidate = &dictionary.candidates[candidate];
    let Subject::Effect { .. } = candidate.subject else {
        return false;
    };
    let shapes = candidate.parameters.iter();
    shapes
        .filter(|p| !candidate.strengths.contains(p))
        .any(|&index| {
            let parameter = &dictionary.machine.compiled.model.parameters[index];
            let place = parameters.iter().position(|&p| p == index);
            let variance = place.map_or(0.0, |i| covariance[(i, i)].max(0.0));
            let vanishes = parameter.lower == 0.0 && dictionary.defaults[index] > 0.0;
            // Without the mark the log is half its square over the variance nats less likely.
            vanishes && values[index].powi(2) <= 2.0 * MARGIN * variance
        })
}

/// Whether the strengths of a candidate are together so near to nothing that the log were no more than
/// [`MARGIN`] nats less likely without it; `known` are parameters with their covariance. A wave whose
/// phase is not known well has two strengths that may each be nothing, and is there.
pub(super) fn says_no_strength(
    dictionary: &Dictionary,
    candidate: usize,
    values: &[f64],
    known: (&[usize], &DMatrix<f64>),
) -> bool {
    worth(dictionary, candidate, values, known) <= MARGIN
}

/// Nats that a candidate is worth to second order: `½ xᵀ C⁻¹ x` of its strengths and their covariance;
/// `known` are parameters with that. What has no covariance is not known, and may well be nothing; where
/// the log does not tell strengths apart, at least what the best known one is worth by itself.
pub(super) fn worth(
    dictionary: &Dictionary,
    candidate: usize,
    values: &[f64],
    (parameters, covariance): (&[usize], &DMatrix<f64>),
) -> f64 {
    let strengths = &dictionary.candidates[candidate].strengths;
    let known = parameters.iter().enumerate();
    let own: Vec<(usize, usize)> = known
        .filter(|&(place, p)| strengths.contains(p) && covariance[(place, place)] > 0.0)
        .map(|(place, &p)| (place, p))
        .collect();
    let change = own.iter().map(|&(_, p)| values[p] - dictionary.defaults[p]);
    let x = DVector::from_iterator(own.len(), change);
    let covariance = DMatrix::from_fn(own.len(), own.len(), |a, b| {
        covariance[(own[a].0, own[b].0)]
    });
    let alone = |(x, variance): (&f64, &f64)| 0.5 * x * x / variance;
    match covariance.clone().cholesky() {
        Some(c) => 0.5 * x.dot(&c.solve(&x)),
        None => (x.iter().zip(&covariance.diagonal()))
            .map(alone)
            .fold(0.0, f64::max),
    }
}

/// The accepted terms as findings, strongest first.
pub(super) fn findings(dictionary: &Dictionary, selection: &Selection) -> Vec<Finding> {
    let each = |term| finding(dictionary, selection, term);
    let findings = selection.terms.iter().map(each).collect();
    let effects = &dictionary.machine.compiled.model.effects;
    let is_of_input = |finding: &Finding| {
        let own = effects.iter().find(|e| e.template == finding.effect);
        own.is_some_and(|effect| effect.on.iter().all(|(kind, _)| *kind == PortKind::Input))
    };
    on_one_clock(findings, selection.estimate.rows, is_of_input)
}

fn finding(dictionary: &Dictionary, selection: &Selection, term: &Term) -> Finding {
    let candidate = &dictionary.candidates[term.candidate];
    let model = &dictionary.machine.compiled.model;
    let names = dictionary.short_names(term.candidate);
    let parameters = candidate
        .parameters
        .iter()
        .zip(names)
        .map(|(&index, name)| {
            let parameter = &model.parameters[index];
            let position = selection
                .estimate
                .parameters
                .iter()
                .position(|&p| p == index);
            let covariance = &selection.estimate.covariance;
            let std = position.map_or(f64::NAN, |i| deviation(covariance[(i, i)]));
            let value = selection.values[index];
            (
                name.to_string(),
                ParameterEstimate {
                    value,
                    std,
                    unit: parameter.unit.clone(),
                },
            )
        });
    Finding {
        effect: candidate.subject.name().to_string(),
        on: candidate.subject.on(),
        places: vec![candidate.subject.on()],
        parameters: parameters.collect(),
        evidence: term.evidence,
        confounded_with: term.rivals.clone(),
        same_on: candidate.same_on.clone(),
        is_measured: false,
    }
}

/// The root of a variance. A fit says null of what changes nothing in the log: how quickly friction
/// turns over where nothing ever turns back.
fn deviation(variance: f64) -> f64 {
    if variance > 0.0 {
        variance.sqrt()
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, begun, named, rectangular, traced, turned};
    use super::*;
    use std::fmt::Write;

    /// A wheel that never turns back tells how large its friction is, not how it begins.
    #[test]
    fn what_changes_nothing_is_not_determined() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(6);
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let q = 6.0 * t + 0.6 * (3.0 * t).sin() + 0.2 * (7.0 * t).sin();
            let a = -5.4 * (3.0 * t).sin() - 9.8 * (7.0 * t).sin();
            writeln!(text, "{t},{},{}", q + 2e-4 * noise(), 0.02 * a + 0.05).unwrap();
        }
        let found = traced(WHEEL, &text).findings;
        let [friction] = &found[..] else {
            panic!("{found:#?}");
        };
        assert_eq!(friction.effect, "coulomb");
        let force = &friction.parameters["f_c"];
        assert!((force.value - 0.05).abs() < 3.0 * force.std, "{force:?}");
        assert!(friction.parameters["v_s"].std.is_infinite(), "{found:#?}");
    }

    /// A ripple of which the log says how large it is, and not where it begins.
    #[test]
    fn strengths_that_are_known_together_are_strengths() {
        let log = turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[_, _, a]| 0.02 * a);
        let (dictionary, start) = begun(WHEEL, &log, ["angle", "motor"]);
        let ripple = named(&dictionary, "cogging(angle)");
        let strengths = dictionary.candidates[ripple].strengths.clone();
        let mut values = start.values;
        strengths.iter().for_each(|&p| values[p] = 0.1);
        let known_to = |correlation: f64| {
            let each = |i, j| if i == j { 0.01 } else { 0.01 * correlation };
            DMatrix::from_fn(2, 2, each)
        };
        let says_nothing = |covariance: &DMatrix<f64>| {
            says_no_strength(&dictionary, ripple, &values, (&strengths, covariance))
        };
        // One standard error each; their sum is known ten times as well, or hardly.
        assert!(!says_nothing(&known_to(-0.98)));
        assert!(says_nothing(&known_to(0.98)));
        // Not told apart at all, each is worth half a nat by itself.
        let together = worth(&dictionary, ripple, &values, (&strengths, &known_to(1.0)));
        assert!((together - 0.5).abs() < 1e-9, "{together}");
    }

    /// Bristles that bend, with more friction before they slide, while a force without a name pushes:
    /// what that leaves is no law, and does not say that it is another hysteresis.
    #[test]
    fn a_friction_that_remembers_keeps_its_name_beside_a_force_without_one() {
        if left_out::too_slow() {
            return;
        }
        let (mut noise, mut push) = (rectangular(6), rectangular(7));
        let (mut bent, mut force) = (0.0, 0.0);
        let mut text = String::from("t,q_angle,u_motor\n");
        let h = 0.005;
        for k in 0..4000 {
            let t = h * f64::from(k);
            let waves = [(0.35, 2.3), (0.2, 5.9), (0.1, 0.7)];
            let [q, v, a] = waves.iter().fold([0.0; 3], |[q, v, a], &(size, w)| {
                let (sin, cos) = (w * t).sin_cos();
                [q + size * sin, v + size * w * cos, a - size * w * w * sin]
            });
            let friction = 0.08 * bent;
            let turned = 0.02 * a + friction + force;
            writeln!(text, "{t},{},{turned}", q + 1e-4 * noise()).unwrap();
            let sliding = 1.0 + 1.5 * (-(v / 0.4_f64).powi(2)).exp();
            bent += h * (v - v.abs() * bent / sliding) / 0.05;
            force += (-h / 0.1) * force + 0.006 * push();
        }
        let outcome = traced(WHEEL, &text);
        let [friction] = &outcome.findings[..] else {
            panic!("{:?}: {:#?}", outcome.verdict, outcome.findings);
        };
        assert_eq!(friction.effect, "lugre");
        assert!(
            something_remains(&outcome.remaining),
            "{:?}",
            outcome.remaining
        );
    }
}
