//! The microscope: a force that has no name, looked at through Gaussian processes.
//!
//! The smoothed unexplained force `f(t)` of the model as given (the Ornstein–Uhlenbeck
//! state of [`ErrorDynamics`](crate::regression::ErrorDynamics)) is explained, coordinate by
//! coordinate, by processes on different sets of variables; their evidence ranks the sets
//! (length-scales alone would not: TRACE's lesson). The best set tells what the force
//! depends on, and its posterior mean stays as a term of the model,
//! `a = a_model + P f(z)` [5.6], measured on the log that nothing was fitted to.

mod features;
mod law;

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::focus::Focus;
use super::linearised::{first_noise, linearised};
use super::refine::{Explanation, refine_curve};
use super::remembered::remembered_ways;
use super::run::Request;
use super::score::{Errors, NEGLIGIBLE, ScoreError, Scoring};
use super::selection::Selection;
use crate::log::{Record, median_step};
use crate::machine::SolveError;
use crate::regression::Smoothing;
use crate::smooth::savgol_states;
use features::{Feature, Features, Motion, deviation, kinds};
use law::{Law, LawError};
use nalgebra::DVector;
use serde::Serialize;
use std::sync::Arc;

/// A force that no effect of the library explains.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unnamed {
    /// By coordinate, strongest first.
    pub forces: Vec<UnnamedForce>,
    /// One-step acceleration error with the forces as Gaussian-process terms, on the log
    /// that is judged by; as [`Score::acceleration`](super::Score::acceleration).
    pub acceleration_after: Errors,
    /// Share of the excess of the error over the noise floor that the terms remove; not a number
    /// (`null` in JSON) where the error of the model as given is at the floor.
    pub recovered: f64,
}

/// Share of what a force makes a model err by from which its description is a law, of root mean squares.
const LAWFUL: f64 = 0.5;

impl Unnamed {
    /// Whether the variables that a force is said to depend on foretell much of it where nothing was
    /// learnt, be that another log or other runs of the same: then it is a law, of the machine or its inputs, and
    /// not what no model holds.
    pub(super) fn is_a_law(&self) -> bool {
        let strongest = self.forces.first();
        let foretold = strongest.map_or(0.0, |force| 1.0 - (1.0 - force.explained).max(0.0).sqrt());
        self.recovered > LAWFUL || foretold > LAWFUL
    }
}

/// The unnamed force on one coordinate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UnnamedForce {
    /// The coordinate that it acts on.
    pub coordinate: String,
    /// Its root mean square along the training log, in the coordinate's force unit.
    pub size: f64,
    /// How long it lasts, s: after this time it resembles itself by no more than `1/e`.
    pub lasts: f64,
    /// The variables that it depends on, the most influential first.
    pub depends_on: Vec<Dependence>,
    /// Sets of variables that were tried, best first.
    pub tried: Vec<Tried>,
    /// Share of its variance that the variables explain in runs of the log that were not fitted.
    pub explained: f64,
    /// `−⟨f v⟩/√(⟨f²⟩⟨v²⟩)`: one if it is drag, minus one if it drives.
    pub dissipation: f64,
    /// Correlation of `f(z)` with `−f` at the same place at opposite velocity: one if odd in
    /// velocity, as friction is; minus one if even, as a spring.
    pub odd_in_velocity: f64,
    /// Whether it remembers where the coordinate has come from.
    pub remembers: bool,
    /// The Gaussian process with its data, as `gp` saves it.
    #[serde(skip)]
    pub saved: String,
}

/// A variable that a force depends on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dependence {
    /// `q_x`, `dq_x`, `u_x`, or `past_x`: where `x` has lately come from.
    pub variable: String,
    /// Length-scale in units of the variable's standard deviation: the shorter, the more it
    /// matters.
    pub length_scale: f64,
}

/// A set of variables that a force might depend on.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Tried {
    /// The variables.
    pub variables: Vec<String>,
    /// Log evidence less the price of the parameters, nats.
    pub evidence: f64,
}

/// Why nothing could be seen.
#[derive(Debug, thiserror::Error)]
pub(super) enum MicroscopeError {
    #[error(transparent)]
    Score(#[from] ScoreError),
    #[error(transparent)]
    Solve(#[from] SolveError),
    #[error(transparent)]
    Law(#[from] LawError),
}

/// Forces below this share of the strongest one's accelerations are not looked at.
const WORTH_A_LOOK: f64 = 0.05;
/// Coordinates at most.
const MOST_COORDINATES: usize = 3;
/// Samples, in stretches all along a long log, in which is looked for what a force depends on.
const LOOKED_AT: usize = 6000;

/// A model with some terms, beside a log.
pub(super) struct View<'a> {
    pub dictionary: &'a Dictionary,
    /// The log that was learnt from.
    pub selection: &'a Selection,
    /// What the model has beside what it was given with.
    pub terms: &'a [usize],
    /// Values of all the dictionary's parameters.
    pub values: &'a [f64],
    /// Acceleration errors of this model, and of sensor noise alone.
    pub errors: [f64; 2],
    /// The log that is judged by.
    pub test: &'a Record,
    pub request: &'a Request<'a>,
}

impl View<'_> {
    /// Looks at what the model leaves unexplained.
    ///
    /// # Errors
    /// If the log cannot be smoothed, or no process be fitted to the force.
    pub fn look(&self) -> Result<Unnamed, MicroscopeError> {
        let focus = self.dictionary.focus(self.terms);
        let scoring = Scoring {
            machine: &focus.machine,
            values: &focus.values(self.values),
            hold: self.selection.observed.hold,
            horizon: self.request.horizon,
            begun: &Arc::default(),
        };
        let test = corrected(self.test, &focus, scoring.values).map_err(ScoreError::from)?;
        self.look_at(&focus, &scoring, &test)
    }

    fn look_at(
        &self,
        focus: &Focus,
        scoring: &Scoring<'_>,
        test: &Record,
    ) -> Result<Unnamed, MicroscopeError> {
        let (dictionary, selection) = (self.dictionary, self.selection);
        let observed = &selection.observed;
        let observed = (observed.excerpt(LOOKED_AT)).unwrap_or_else(|| observed.clone());
        let mut explanation = Explanation {
            noise: first_noise(focus, &observed, self.values)?,
            observed,
            values: self.values.to_vec(),
        };
        refine_curve(dictionary, self.terms, &mut explanation)?;
        let observed = &explanation.observed;
        let dynamics = linearised(focus, observed, &explanation.values)?;
        let accelerations = dynamics.accelerations();
        let readings = observed.readings(focus, &explanation.values, &accelerations);
        let smoothing = Smoothing::new(&dynamics, &readings, &explanation.noise);
        let smoothed = smoothing.smooth(&DVector::zeros(0));
        let n = dynamics.coordinate_count();
        let force = |i: usize| -> Vec<f64> { smoothed.iter().map(|s| s[2 * n + i]).collect() };
        let mut strengths: Vec<(usize, f64)> = (0..n)
            .filter(|&i| explanation.noise.force_sd[i] > 2.0 * explanation.noise.smallest[i])
            .map(|i| (i, moved(&dynamics, &force(i), i)))
            .collect();
        strengths.sort_by(|a, b| b.1.total_cmp(&a.1));
        let strongest = strengths.first().map_or(0.0, |s| s.1);
        strengths.retain(|s| s.1 > WORTH_A_LOOK * strongest);
        strengths.truncate(MOST_COORDINATES);
        let motion = Motion {
            t: &observed.curve.t,
            q: &observed.curve.q,
            v: &observed.curve.v,
            u: &observed.curve.u,
        };
        let kinds = kinds(&motion, &remembered_ways(dictionary, selection));
        let features = Features::new(&kinds, &motion);
        let states = savgol_states(test).map_err(ScoreError::from)?;
        let there = Features::new(
            &kinds,
            &Motion {
                t: &test.t,
                q: &states.q,
                v: &states.v,
                u: &test.u,
            },
        );
        let mut added = vec![vec![0.0; test.len()]; n];
        let mut forces = Vec::new();
        for (coordinate, _) in strengths {
            let (column, v) = (force(coordinate), &observed.curve.v[coordinate]);
            let t = &observed.curve.t;
            let law = Law::find(coordinate, &features, &column, self.request.seed)?;
            added[coordinate] = law.along(&there)?;
            forces.push(describe(
                dictionary,
                coordinate,
                &law,
                &features,
                (t, &column, v),
            )?);
        }
        let (acceleration_after, _) = scoring.one_step_with(test, &states, &added)?;
        let [before, floor] = self.errors;
        Ok(Unnamed {
            forces,
            recovered: recovered(before, acceleration_after.total, floor),
            acceleration_after,
        })
    }
}

/// An error this near to the noise floor, as a share of it, is the floor: of another draw of the
/// noise it would be as far off, and there is nothing to recover.
const EXCESS: f64 = 1e-2;

/// Share of the excess of an error over the floor that is gone afterwards; not a number where there
/// was none.
fn recovered(before: f64, after: f64, floor: f64) -> f64 {
    if before <= (1.0 + EXCESS) * floor {
        return f64::NAN;
    }
    let beyond = |error: f64| (error.powi(2) - floor.powi(2)).max(0.0);
    1.0 - (beyond(after) / beyond(before)).sqrt()
}

/// Mean square of the accelerations that a force on coordinate `i` makes.
fn moved(dynamics: &crate::regression::ErrorDynamics, force: &[f64], i: usize) -> f64 {
    let n = dynamics.coordinate_count();
    let largest = dynamics.acceleration_scale.max();
    let squares = dynamics.slope.iter().zip(force).map(|(slope, f)| {
        let column = slope.column(2 * n + i);
        let scales = column.iter().zip(&dynamics.acceleration_scale);
        // What moves by round-off alone has no size to take a share of.
        let moving = scales.filter(|(_, a)| **a > NEGLIGIBLE * largest);
        moving.map(|(p, a)| (p * f / a).powi(2)).sum::<f64>()
    });
    squares.sum::<f64>() / force.len() as f64
}

fn describe(
    dictionary: &Dictionary,
    coordinate: usize,
    law: &Law,
    features: &Features,
    (t, force, v): (&[f64], &[f64], &[f64]),
) -> Result<UnnamedForce, MicroscopeError> {
    let model = &dictionary.machine.compiled.model;
    let name = |feature: &Feature| match *feature {
        Feature::Position(i) => format!("q_{}", model.coordinates[i].name),
        Feature::Velocity(i) => format!("dq_{}", model.coordinates[i].name),
        Feature::Past(i, _) => format!("past_{}", model.coordinates[i].name),
        Feature::Input(i) => format!("u_{}", model.inputs[i].name),
    };
    let mean = |f: &dyn Fn(usize) -> f64| (0..force.len()).map(f).sum::<f64>() / force.len() as f64;
    let power = mean(&|k| force[k] * v[k]);
    let (ff, vv) = (mean(&|k| force[k].powi(2)), mean(&|k| v[k].powi(2)));
    let mut depends_on: Vec<Dependence> = law
        .variables
        .iter()
        .zip(&law.length_scales)
        .map(|(&variable, &length_scale)| Dependence {
            variable: name(&features.kinds[variable]),
            length_scale,
        })
        .collect();
    depends_on.sort_by(|a, b| a.length_scale.total_cmp(&b.length_scale));
    let remembered = |&variable: &usize| matches!(features.kinds[variable], Feature::Past(..));
    Ok(UnnamedForce {
        coordinate: model.coordinates[coordinate].name.clone(),
        size: ff.sqrt(),
        lasts: correlation_time(t, force),
        depends_on,
        tried: law
            .tried
            .iter()
            .map(|(variables, evidence)| Tried {
                variables: variables
                    .iter()
                    .map(|&v| name(&features.kinds[v]))
                    .collect(),
                evidence: *evidence,
            })
            .collect(),
        explained: law.explained,
        dissipation: -power / (ff * vv).sqrt().max(f64::MIN_POSITIVE),
        odd_in_velocity: law.oddness(features)?,
        remembers: law.variables.iter().any(remembered),
        saved: law.saved.clone(),
    })
}

/// The time after which the autocorrelation of a force about its mean has fallen to `1/e`: a mean, which
/// lasts for ever, says nothing of how long the rest does.
pub(super) fn correlation_time(t: &[f64], force: &[f64]) -> f64 {
    let mean = force.iter().sum::<f64>() / force.len().max(1) as f64;
    let force: Vec<f64> = force.iter().map(|f| f - mean).collect();
    let product = |lag: usize| -> f64 {
        let pairs = force.iter().zip(&force[lag..]);
        pairs.map(|(a, b)| a * b).sum::<f64>() / (force.len() - lag) as f64
    };
    let whole = product(0);
    let longest = force.len() / 2;
    let lag = (1..longest).find(|&lag| product(lag) < whole / std::f64::consts::E);
    lag.unwrap_or(longest) as f64 * median_step(t)
}

/// Correlation of two columns.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().max(1) as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / count;
    let (of_a, of_b) = (mean(a), mean(b));
    let product: f64 = a.iter().zip(b).map(|(x, y)| (x - of_a) * (y - of_b)).sum();
    product / count / (deviation(a) * deviation(b)).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four waves of ten seconds about a mean, the last not whole where they are shifted: `cos ωτ = 1/e` at `τ = arccos(1/e)/ω = 1.900 s`.
    #[test]
    fn a_mean_does_not_make_a_force_last() {
        let t: Vec<f64> = (0..4000).map(|k| 0.01 * f64::from(k)).collect();
        let omega = 2.0 * std::f64::consts::PI / 10.0;
        let force: Vec<f64> = t.iter().map(|t| 3.0 + (omega * t).sin()).collect();
        let expected = (-1.0_f64).exp().acos() / omega;
        let found = correlation_time(&t, &force);
        assert!((found - expected).abs() < 0.15, "{found} {expected}");
    }

    #[test]
    fn at_the_floor_there_is_nothing_to_recover() {
        assert!((recovered(0.5, 0.3, 0.3) - 1.0).abs() < 1e-12);
        assert!(recovered(0.5, 0.6, 0.3) < 0.0);
        for before in [0.3, 0.29, 0.302] {
            assert!(recovered(before, 0.5, 0.3).is_nan(), "{before}");
        }
    }
}
