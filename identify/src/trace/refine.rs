//! Gauss–Newton on the accepted terms: parameters and curve together.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use crate::machine::{SensitivityTape, SolveError};
use crate::regression::{Columns, ErrorDynamics, ProcessNoise, Whitener};
use nalgebra::{DMatrix, DVector};

/// Estimates of some parameters.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Which parameters of the extended model.
    pub parameters: Vec<usize>,
    /// Their covariance for sensors as noisy as thought.
    pub covariance: DMatrix<f64>,
    /// Sum of squared whitened innovations.
    pub misfit: f64,
    /// Number of readings.
    pub rows: usize,
}

/// Steps at most.
const STEPS: usize = 12;
/// Nats; a smaller improvement ends the iteration.
const SMALL_IMPROVEMENT: f64 = 0.05;

/// Fits `parameters` (indices, with their derivatives on `tape`), starting at and
/// writing to `values`, and moves the curve to where the model and the sensors
/// agree best.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn refine(
    dictionary: &Dictionary,
    tape: &SensitivityTape,
    parameters: &[usize],
    observed: &mut Observed,
    values: &mut [f64],
    noise: &ProcessNoise,
) -> Result<Estimate, SolveError> {
    let all: Vec<usize> = (0..parameters.len()).collect();
    let mut best: Option<Best> = None;
    for step in 1.. {
        let columns = [Columns {
            tape,
            parameters: &*values,
        }];
        let dynamics = ErrorDynamics::new(
            &dictionary.machine,
            &dictionary.slopes,
            &columns,
            &observed.curve,
            observed.hold,
            values,
        )?;
        let readings = observed.readings();
        let whitener = Whitener::new(&dynamics, &readings, noise);
        let gram = whitener.gram();
        let fit = gram.fit(&all);
        if fit.coefficients.iter().any(|x| !x.is_finite()) {
            return Err(SolveError::NotFinite { sample: 0 });
        }
        let cost = 0.5 * gram.data_misfit() + whitener.log_sd();
        let improved = best.as_ref().is_none_or(|best| cost < best.cost);
        let improvement = best.as_ref().map_or(f64::INFINITY, |best| best.cost - cost);
        let (moved, taken) = limited(dictionary, parameters, values, &fit.coefficients);
        let departure = whitener.smooth(&taken);
        if improved {
            best = Some(Best {
                cost,
                values: values.to_vec(),
                curve: observed.curve.clone(),
                estimate: Estimate {
                    parameters: parameters.to_vec(),
                    covariance: fit.covariance,
                    misfit: gram.data_misfit(),
                    rows: gram.rows(),
                },
            });
        }
        if step == STEPS || (step > 2 && improvement < SMALL_IMPROVEMENT) {
            break;
        }
        observed.move_by(&departure);
        for (i, &index) in parameters.iter().enumerate() {
            values[index] = moved[i];
        }
    }
    // The best state seen, not the last one: a linearisation may mislead.
    match best {
        Some(best) => {
            values.copy_from_slice(&best.values);
            observed.curve = best.curve;
            Ok(best.estimate)
        }
        None => Err(SolveError::NotFinite { sample: 0 }),
    }
}

/// The best state seen so far.
struct Best {
    cost: f64,
    values: Vec<f64>,
    curve: crate::machine::States,
    estimate: Estimate,
}

/// The new values, inside their bounds and not too far from the old ones, and the
/// steps that were really taken.
fn limited(
    dictionary: &Dictionary,
    parameters: &[usize],
    values: &[f64],
    step: &DVector<f64>,
) -> (Vec<f64>, DVector<f64>) {
    let model = &dictionary.machine.compiled.model;
    let moved: Vec<f64> = parameters
        .iter()
        .enumerate()
        .map(|(i, &index)| {
            let (old, parameter) = (values[index], &model.parameters[index]);
            let mut new = old + step[i];
            // Quantities that are positive by nature change by a factor at most.
            if parameter.lower > 0.0 {
                new = new.clamp(old / 2.0, old * 2.0);
            }
            new.clamp(parameter.lower, parameter.upper)
        })
        .collect();
    let taken = DVector::from_fn(parameters.len(), |i, _| moved[i] - values[parameters[i]]);
    (moved, taken)
}
