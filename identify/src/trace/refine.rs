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
/// A step smaller than this share of a standard deviation ends the iteration.
const SMALL_STEP: f64 = 0.05;

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
    let mut step = 0;
    loop {
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
        let all: Vec<usize> = (0..parameters.len()).collect();
        let fit = gram.fit(&all);
        let (moved, taken) = limited(dictionary, parameters, values, &fit.coefficients);
        observed.move_by(&whitener.smooth(&taken));
        let length = (0..parameters.len())
            .map(|i| {
                (moved[i] - values[parameters[i]]).abs()
                    / fit.covariance[(i, i)].sqrt().max(f64::MIN_POSITIVE)
            })
            .fold(0.0, f64::max);
        for (i, &index) in parameters.iter().enumerate() {
            values[index] = moved[i];
        }
        step += 1;
        if step == STEPS || (length < SMALL_STEP && step > 1) {
            return Ok(Estimate {
                parameters: parameters.to_vec(),
                covariance: fit.covariance,
                misfit: fit.misfit,
                rows: gram.rows(),
            });
        }
    }
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
