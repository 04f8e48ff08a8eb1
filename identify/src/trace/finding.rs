//! What was found, in words and numbers.

use super::dictionary::Dictionary;
use super::select::{Remaining, Selection, Term};
use serde::Serialize;
use std::collections::BTreeMap;

/// What kind of error the model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
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
pub struct ParameterEstimate {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Its unit.
    pub unit: String,
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
}

/// One thing the model lacks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The effect, or `parameter`.
    pub effect: String,
    /// The coordinates, inputs or parameters it is about.
    pub on: Vec<String>,
    /// Its parameters.
    pub parameters: BTreeMap<String, ParameterEstimate>,
    /// Nats by which the log is better explained with it, less its price.
    pub evidence: f64,
    /// What explains the log about as well.
    pub confounded_with: Vec<Rival>,
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

/// Judges the outcome of a selection.
pub(super) fn verdict(dictionary: &Dictionary, selection: &Selection) -> Verdict {
    let remaining = &selection.remaining;
    let unexplained = something_remains(remaining);
    let about = |test: fn(&super::Candidate) -> bool| {
        selection
            .terms
            .iter()
            .any(|term| test(&dictionary.candidates[term.candidate]))
    };
    if selection.terms.is_empty() {
        if unexplained {
            Verdict::Unknown
        } else {
            Verdict::None
        }
    } else if unexplained && remaining.share_after > MOSTLY_UNEXPLAINED * remaining.share_before {
        Verdict::Unknown
    } else if about(|c| !c.channel && c.subject.name() != "parameter") {
        Verdict::Effect
    } else if about(|c| c.channel) {
        Verdict::Channel
    } else {
        Verdict::Parameter
    }
}

/// The accepted terms as findings, strongest first.
pub(super) fn findings(dictionary: &Dictionary, selection: &Selection) -> Vec<Finding> {
    selection
        .terms
        .iter()
        .map(|term| finding(dictionary, selection, term))
        .collect()
}

fn finding(dictionary: &Dictionary, selection: &Selection, term: &Term) -> Finding {
    let candidate = &dictionary.candidates[term.candidate];
    let model = &dictionary.machine.compiled.model;
    let prefix = match candidate.subject.name() {
        "parameter" => String::new(),
        name => format!("{name}_{}_", candidate.subject.on().join("_")),
    };
    let parameters = candidate.parameters.iter().map(|&index| {
        let parameter = &model.parameters[index];
        let position = selection
            .estimate
            .parameters
            .iter()
            .position(|&p| p == index);
        let std = position.map_or(f64::NAN, |i| selection.estimate.covariance[(i, i)].sqrt());
        let name = parameter
            .name
            .strip_prefix(&prefix)
            .unwrap_or(&parameter.name);
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
    let rival = |(subject, evidence): &(super::Subject, f64)| Rival {
        effect: subject.name().to_string(),
        on: subject.on(),
        evidence_difference: *evidence,
    };
    Finding {
        effect: candidate.subject.name().to_string(),
        on: candidate.subject.on(),
        parameters: parameters.collect(),
        evidence: term.evidence,
        confounded_with: term.rivals.iter().map(rival).collect(),
    }
}
