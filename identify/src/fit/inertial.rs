//! What a log says of inertial parameters, and when that is not to be taken at its word.

use super::Value;
use super::columns::Columns;
use super::estimate::Estimate;
use dynamics_codegen::derive::STANDARD;
use serde::Serialize;

/// One inertial parameter of a body.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct InertialParameter {
    /// The body.
    pub body: String,
    /// Which of the ten.
    pub parameter: &'static str,
    /// What the model states.
    pub stated: f64,
    /// What the log says.
    pub estimate: Value,
    /// The share of the prior's variance that the log has taken away, by the standard error of
    /// the estimate: 0 where the log is silent, or where there is a doubt, near 1 where it decides.
    pub determined: f64,
    /// Why the estimate is not to be taken at its word.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubt: Option<Doubt>,
}

/// Why an inertial parameter's estimate is not to be taken at its word, however small its
/// standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Doubt {
    /// It is at the edge of what a rigid body can have: the edge says what it is, not the log.
    AtBound,
    /// It is farther from what the model states than stated inertias are wrong: something else
    /// that the model lacks may have moved it.
    FarFromStated,
}

/// An estimate farther from the stated value than this many times what stated inertias are
/// believed to be wrong by contradicts it. Two standard deviations: one number in twenty.
const CONTRADICTS: f64 = 2.0;
/// A body that is this many times heavier or lighter than stated is another body.
const ANOTHER_BODY: f64 = 3.0;

/// Whether a correction leads away from what is stated, believed to within `prior` (one standard
/// deviation): by more than that may be off, or to a small part or a multiple of what is not
/// about zero.
fn is_far(stated: f64, correction: f64, prior: f64) -> bool {
    let ratio = 1.0 + correction / stated;
    let another = stated.abs() > prior && !(1.0 / ANOTHER_BODY..ANOTHER_BODY).contains(&ratio);
    another || correction.abs() > CONTRADICTS * prior
}

/// The inertial parameters by body; `at_edge` says which are at the edge of what can be.
pub(super) fn inertial(
    columns: &Columns,
    estimate: &Estimate,
    at_edge: &[bool],
) -> Vec<InertialParameter> {
    (0..columns.inertial)
        .map(|column| {
            let stated = columns.stated[column];
            let prior = columns.prior[column];
            let std = estimate.std[column];
            let doubt = if at_edge[column] {
                Some(Doubt::AtBound)
            } else {
                let is_far = is_far(stated, estimate.inertial[column], prior);
                is_far.then_some(Doubt::FarFromStated)
            };
            let taken = (1.0 - (std / prior).powi(2)).clamp(0.0, 1.0);
            InertialParameter {
                body: columns.bodies[column / STANDARD.len()].clone(),
                parameter: STANDARD[column % STANDARD.len()],
                stated,
                estimate: Value {
                    value: stated + estimate.inertial[column],
                    std,
                },
                determined: if doubt.is_some() { 0.0 } else { taken },
                doubt,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_is_beyond_belief_or_another_body() {
        // To a quarter, to four times, to the other side.
        for correction in [-0.75, 3.0, -1.5] {
            assert!(is_far(1.0, correction, 0.5), "{correction}");
        }
        for correction in [-0.5, 0.0, 0.9] {
            assert!(!is_far(1.0, correction, 0.5), "{correction}");
        }
        // About zero there are no multiples, only what is believed.
        assert!(!is_far(0.0, 0.1, 0.1) && !is_far(1e-3, 0.1, 0.1));
        assert!(is_far(0.0, 0.3, 0.1));
    }
}
