//! How well a model explains forces on data that nothing was fitted to: errors, what they are
//! shares of, and the curves of the page.

use super::FitError;
use super::correction::Correction;
use super::equations::Equations;
use crate::log::{Record, rms};
use crate::machine::{Machine, States};
use crate::trace::{deviation, force_floor};
use serde::Serialize;
use std::collections::BTreeMap;

/// Root mean squares of forces, per coordinate and over all, in the unit of the force on that
/// coordinate, within the band in which the log shows accelerations at all.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Error {
    /// By coordinate; not a number (`null` in JSON) where the force is not known.
    pub by_coordinate: BTreeMap<String, f64>,
    /// Root mean square over all coordinates.
    pub total: f64,
}

impl Error {
    pub(super) fn new(names: &[String], sizes: &[f64]) -> Self {
        Self::of(names.iter().cloned().zip(sizes.iter().copied()).collect())
    }

    fn of(by_coordinate: BTreeMap<String, f64>) -> Self {
        let known = by_coordinate.values().filter(|size| size.is_finite());
        let (squares, count) = known.fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
        Self {
            total: (squares / f64::from(count)).sqrt(),
            by_coordinate,
        }
    }

    /// Without the coordinates that some equations leave out.
    pub(super) fn without(self, names: &[String], left_out: &[usize]) -> Self {
        let mut by_coordinate = self.by_coordinate;
        for &i in left_out {
            by_coordinate.insert(names[i].clone(), f64::NAN);
        }
        Self::of(by_coordinate)
    }
}

/// Curves along the log that is judged by, of one coordinate.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ForceSeries {
    /// The coordinate.
    pub name: String,
    /// Its velocity.
    pub velocity: Vec<f64>,
    /// The force that its inputs exert; under constraints the part that no multiplier takes up.
    pub measured: Vec<f64>,
    /// What the model as given leaves of it.
    pub before: Vec<f64>,
    /// What the fitted one leaves.
    pub after: Vec<f64>,
}

/// Curves along the log that is judged by, thinned to what a plot can show.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Curves {
    /// When, s.
    pub t: Vec<f64>,
    /// By coordinate, in the model's order.
    pub coordinates: Vec<ForceSeries>,
}

/// Samples of a curve at most.
const SHOWN: usize = 2000;
/// The noise of the floor is drawn once: it is large numbers of samples that it is the size of.
const SEED: u64 = 1;
/// What the inputs exert on a coordinate below this share of the most is round-off: no input
/// drives it.
const DRIVES: f64 = 1e-9;

/// The errors before (`x` nothing) and after, and what the forces vary by; a coordinate that
/// nothing drives has no such size.
pub(super) fn errors(names: &[String], equations: &Equations, x: &[f64]) -> [Error; 3] {
    let nothing = vec![0.0; x.len()];
    let exerted = equations.exerted();
    let mut sizes: Vec<f64> = exerted.iter().map(|force| deviation(force)).collect();
    let largest = sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
    for size in &mut sizes {
        if *size <= DRIVES * largest {
            *size = 0.0;
        }
    }
    let error = |x: &[f64]| Error::new(names, &equations.rms(x));
    let all = [error(&nothing), error(x), Error::new(names, &sizes)];
    all.map(|error| error.without(names, &equations.left_out))
}

/// What noise of the sensors alone would leave of the corrected model; `None` under constraints, where forces that
/// multipliers take up are not known apart from it.
///
/// # Errors
/// If the log cannot be smoothed, or an equation of motion has no solution along it.
pub(super) fn floor(
    names: &[String],
    machine: &Machine,
    parameters: &[f64],
    correction: &Correction,
    (record, narrowing): (&Record, usize),
) -> Result<Option<Error>, FitError> {
    if machine.constraint_count() > 0 {
        return Ok(None);
    }
    let beside =
        |states: &States, a: &[Vec<f64>]| correction.weighed(machine, states, parameters, a);
    let forces = force_floor(record, machine, parameters, &beside, (narrowing, SEED));
    let forces = forces.map_err(|error| FitError::Floor(Box::new(error)))?;
    let sizes: Vec<f64> = forces.iter().map(|force| rms(force)).collect();
    Ok(Some(Error::new(names, &sizes)))
}

/// The curves of a page.
pub(super) fn curves(names: &[String], equations: &Equations, x: &[f64]) -> Curves {
    let stride = equations.t.len().div_ceil(SHOWN).max(1);
    let thin = |values: &[f64]| values.iter().step_by(stride).copied().collect::<Vec<f64>>();
    let measured = equations.exerted();
    let (before, after) = (equations.left(&vec![0.0; x.len()]), equations.left(x));
    let of = |(i, name): (usize, &String)| ForceSeries {
        name: name.clone(),
        velocity: thin(&equations.velocity[i]),
        measured: thin(&measured[i]),
        before: thin(&before[i]),
        after: thin(&after[i]),
    };
    let is_known = |(i, _): &(usize, &String)| !equations.left_out.contains(i);
    Curves {
        t: thin(&equations.t),
        coordinates: names.iter().enumerate().filter(is_known).map(of).collect(),
    }
}
