//! What findings leave unexplained: how much of the machine's accelerations, and by which forces.

use super::dictionary::Dictionary;
use super::linearised::linearised;
use super::microscope::{Unnamed, correlation_time};
use super::refine::Explanation;
use super::settings::NO_EXCESS;
use crate::log::{median_step, rms};
use crate::machine::SolveError;
use serde::Serialize;

/// What the accepted terms leave.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Remaining {
    /// Root mean square of the accelerations that unexplained forces make, as a share of
    /// the machine's own, under the model as given; in the balance of forces these, as a share of
    /// what the inputs exert, not a number (`null` in JSON) where they drive nothing.
    pub share_before: f64,
    /// The same with all terms.
    pub share_after: f64,
    /// Nats by which the log is more likely with unexplained forces beside the terms
    /// than with sensor noise alone.
    pub evidence: f64,
    /// The forces that are left with all terms, coordinate by coordinate; none where sensor noise
    /// explains the rest.
    pub forces: Vec<RemainingForce>,
}

/// A force of unknown form on one coordinate.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RemainingForce {
    /// The coordinate that it acts on.
    pub coordinate: String,
    /// Its root mean square along the training log, in the coordinate's force unit.
    pub size: f64,
    /// The same as a share of the forces that act there: the root mean square of inertial, bias and
    /// actuating forces together; in the balance of forces of what the inputs exert, not a number
    /// (`null` in JSON) where that is nothing.
    pub share: f64,
    /// How long it lasts, s: after this time it resembles itself by no more than `1/e`.
    pub lasts: f64,
    /// The variables that foretell some of it at samples that were not fitted, the most influential
    /// first; empty if none does, or if so little remains that nobody looked.
    pub depends_on: Vec<String>,
}

impl Remaining {
    /// Of a log in which nothing was searched for.
    pub(super) const NOT_SEARCHED: Self = Self {
        share_before: f64::NAN,
        share_after: f64::NAN,
        evidence: f64::NAN,
        forces: Vec::new(),
    };

    /// The same, with the variables that a look at the forces has shown.
    pub(super) fn seen(mut self, unnamed: Option<&Unnamed>) -> Self {
        for force in &mut self.forces {
            let mut seen = unnamed.iter().flat_map(|unnamed| &unnamed.forces);
            let own = seen.find(|seen| seen.coordinate == force.coordinate);
            if let Some(own) = own.filter(|own| own.explained > 0.0) {
                let variables = own.depends_on.iter().map(|on| on.variable.clone());
                force.depends_on = variables.collect();
            }
        }
        self
    }
}

/// The forces of unknown form beside an explanation with some terms, as its noise has them: what
/// lasts, and what changes from sample to sample.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub(super) fn beside(
    dictionary: &Dictionary,
    terms: &[usize],
    explanation: &Explanation,
) -> Result<Vec<RemainingForce>, SolveError> {
    let Explanation {
        observed,
        values,
        noise,
    } = explanation;
    let dynamics = linearised(&dictionary.focus(terms), observed, values)?;
    let step = median_step(&dynamics.t);
    let beyond = |own: f64, least: f64| (own.powi(2) - least.powi(2)).max(0.0);
    let names = names(dictionary).enumerate();
    let forces = names.filter_map(|(i, coordinate)| {
        let (own, least) = (noise.force_sd[i], noise.smallest[i]);
        let white = beyond(noise.jitter[i], noise.smallest_jitter[i]) / step;
        let size = (beyond(own, least) + white).sqrt();
        (size.powi(2) > NO_EXCESS * least.powi(2)).then(|| RemainingForce {
            coordinate,
            size,
            share: size / dynamics.force_scale[i],
            lasts: dynamics.correlation[i],
            depends_on: Vec::new(),
        })
    });
    Ok(forces.collect())
}

/// The forces that a balance leaves at some times, beyond what noise of the sensors alone would, as
/// shares of what is exerted; all per coordinate, a value per sample.
pub(super) fn of_balance(
    dictionary: &Dictionary,
    t: &[f64],
    left: &[Vec<f64>],
    [by_noise, exerted]: [&[Vec<f64>]; 2],
) -> Vec<RemainingForce> {
    let names = names(dictionary).enumerate();
    let forces = names.filter_map(|(i, coordinate)| {
        let beyond = rms(&left[i]).powi(2) - rms(&by_noise[i]).powi(2);
        (beyond > 0.0).then(|| RemainingForce {
            coordinate,
            size: beyond.sqrt(),
            share: match rms(&exerted[i]) {
                0.0 => f64::NAN,
                exerted => beyond.sqrt() / exerted,
            },
            lasts: correlation_time(t, &left[i]),
            depends_on: Vec::new(),
        })
    });
    forces.collect()
}

/// The coordinates' names.
fn names(dictionary: &Dictionary) -> impl Iterator<Item = String> {
    let coordinates = dictionary.machine.compiled.model.coordinates.iter();
    coordinates.map(|coordinate| coordinate.name.clone())
}
