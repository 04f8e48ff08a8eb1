//! Curves behind the figures: residuals and predictions along the log that is judged by,
//! thinned to what a plot can show.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::focus::Focus;
use super::linearised::{first_noise, linearised};
use super::score::Look;
use super::selection::Selection;
use super::subject::Subject;
use crate::machine::SolveError;
use crate::regression::Whitener;
use serde::Serialize;

/// Curves and candidates: what a report shows beside the figures.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Details {
    /// The candidates of the first round, best first.
    pub considered: Vec<Weighed>,
    /// Residuals and predictions along the log that is judged by.
    pub series: Series,
}

/// A candidate as it was seen in the first round, alone, by a linear fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Weighed {
    /// The effect, or `parameter`.
    pub effect: String,
    /// What it acts on.
    pub on: Vec<String>,
    /// Nats by which it improves the fit.
    pub gain: f64,
    /// The same less the price of its parameters and of the search.
    pub evidence: f64,
    /// Nats gained on blocks of the log that the fit did not see; nothing where one place
    /// of the log alone shows the candidate.
    pub held_out_gain: Option<f64>,
}

/// Curves along the log that is judged by; `null` in JSON where there is no value.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Series {
    /// Every how many samples the residuals are taken.
    pub stride: usize,
    /// Stamps of the residuals, s.
    pub t: Vec<f64>,
    /// Stamps of the predictions, s.
    pub prediction_t: Vec<f64>,
    /// By coordinate, in the model's order.
    pub coordinates: Vec<CoordinateSeries>,
    /// By input, in the model's order.
    pub inputs: Vec<InputSeries>,
    /// What each finding explains beside the others.
    pub explained: Vec<Explained>,
    /// 95 % of the autocorrelations of white noise are below this.
    pub white_band: f64,
    /// Time between neighbouring autocorrelations, s.
    pub lag_step: f64,
}

/// Curves of one coordinate with unit \[U\].
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CoordinateSeries {
    /// Its name.
    pub name: String,
    /// Position at `t`, U.
    pub position: Vec<f64>,
    /// Velocity at `t`, U/s.
    pub velocity: Vec<f64>,
    /// Acceleration at `t`, U/s².
    pub acceleration: Vec<f64>,
    /// Generalised force that the model as given lacks, J/U.
    pub force_before: Vec<f64>,
    /// The same of the patched model.
    pub force_after: Vec<f64>,
    /// Open-loop predictions.
    pub prediction: Prediction,
    /// Autocorrelation of whitened innovations from lag one on, of the model as given.
    pub autocorrelation_before: Vec<f64>,
    /// The same of the patched model.
    pub autocorrelation_after: Vec<f64>,
}

/// What one finding explains beside the others: partial residuals.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Explained {
    /// The effect, or `parameter`.
    pub effect: String,
    /// What it acts on.
    pub on: Vec<String>,
    /// Generalised force that the patched model lacks without it, by coordinate, at `t`. What
    /// the finding exerts is this less [`CoordinateSeries::force_after`].
    pub without: Vec<Vec<f64>>,
}

/// Predictions of a position at `prediction_t`, U; no number where one ends.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Prediction {
    /// What was measured.
    pub measured: Vec<f64>,
    /// By the model as given.
    pub before: Vec<f64>,
    /// By the patched model.
    pub after: Vec<f64>,
}

/// An input at `t`.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct InputSeries {
    /// Its name.
    pub name: String,
    /// Its values.
    pub values: Vec<f64>,
}

/// Points per curve at most.
const POINTS: usize = 600;
/// Predictions shown, from the first on.
const WINDOWS: usize = 8;
/// Autocorrelations shown.
const LAGS: usize = 40;

impl Explained {
    /// Of a subject, with the force of every sample.
    pub(super) fn new(subject: &Subject, without: Vec<Vec<f64>>) -> Self {
        Self {
            effect: subject.name().to_string(),
            on: subject.on(),
            without,
        }
    }
}

impl Series {
    /// The curves behind two scores on one log; `observed` is that log as the patched
    /// model sees it, `models` are the given and the patched one with the dictionary's
    /// values; `explained` has the forces of every sample.
    pub(super) fn new(
        models: [(&Focus, &[f64]); 2],
        observed: &Observed,
        [before, after]: [&Look; 2],
        mut explained: Vec<Explained>,
    ) -> Result<Self, SolveError> {
        let record = &observed.record;
        let stride = before.inner.len().div_ceil(POINTS).max(1);
        let samples: Vec<usize> = before.inner.iter().step_by(stride).copied().collect();
        let pick = |column: &[f64]| samples.iter().map(|&k| column[k]).collect::<Vec<f64>>();
        for finding in &mut explained {
            let each = finding.without.iter_mut();
            each.for_each(|force| *force = pick(force));
        }
        let shown = windows(before);
        let along = |column: &[f64]| -> Vec<f64> {
            let value = |k: &Option<usize>| k.map_or(f64::NAN, |k| column[k]);
            shown.iter().map(value).collect()
        };
        // Of a model that cannot move there are none.
        let none = || vec![Vec::new(); record.q.len()];
        let correlations = models.map(|(focus, values)| {
            autocorrelations(focus, observed, values).unwrap_or_else(|_| none())
        });
        let [correlation_before, correlation_after] = correlations;
        let coordinate = |(i, name): (usize, &String)| CoordinateSeries {
            name: name.clone(),
            position: pick(&before.states.q[i]),
            velocity: pick(&before.states.v[i]),
            acceleration: pick(&before.states.a[i]),
            force_before: pick(&before.missing[i]),
            force_after: pick(&after.missing[i]),
            prediction: Prediction {
                measured: along(&record.q[i]),
                before: along(&before.predicted.q[i]),
                after: along(&after.predicted.q[i]),
            },
            autocorrelation_before: correlation_before[i].clone(),
            autocorrelation_after: correlation_after[i].clone(),
        };
        let inputs = record.inputs.iter().zip(&record.u);
        Ok(Self {
            stride,
            t: pick(&record.t),
            prediction_t: along(&record.t),
            coordinates: record
                .coordinates
                .iter()
                .enumerate()
                .map(coordinate)
                .collect(),
            inputs: inputs
                .map(|(name, u)| InputSeries {
                    name: name.clone(),
                    values: pick(u),
                })
                .collect(),
            explained,
            white_band: 1.96 / (record.len() as f64).sqrt(),
            lag_step: record.step(),
        })
    }
}

/// Samples of the first predictions, with a break after each.
fn windows(look: &Look) -> Vec<Option<usize>> {
    let predicted = &look.predicted;
    let count = predicted.starts.len().min(WINDOWS);
    let stride = (count * predicted.length).div_ceil(POINTS).max(1);
    let window = |&start: &usize| {
        let samples = (start + 1..=start + predicted.length).step_by(stride);
        samples.map(Some).chain([None])
    };
    predicted.starts[..count].iter().flat_map(window).collect()
}

/// Autocorrelation `Σ e(k) e(k+l) / Σ e(k)²` of each coordinate's whitened innovations,
/// l from one on, where sensor noise alone is to blame for what remains.
fn autocorrelations(
    focus: &Focus,
    observed: &Observed,
    values: &[f64],
) -> Result<Vec<Vec<f64>>, SolveError> {
    let dynamics = linearised(focus, observed, values)?;
    let readings = observed.readings(focus, values, &dynamics.accelerations());
    let noise = first_noise(focus, observed, values)?.at_smallest();
    let whitener = Whitener::new(&dynamics, &readings, &noise);
    let mut sequences = vec![Vec::new(); observed.record.q.len()];
    for innovation in whitener.position_innovations() {
        sequences[innovation.coordinate].push(innovation.value);
    }
    Ok(sequences.iter().map(|e| autocorrelation(e)).collect())
}

fn autocorrelation(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let e: Vec<f64> = values.iter().map(|x| x - mean).collect();
    let power: f64 = e.iter().map(|x| x * x).sum();
    let at = |lag: usize| {
        let products = e.iter().zip(&e[lag..]).map(|(a, b)| a * b);
        products.sum::<f64>() / power
    };
    (1..=LAGS.min(e.len().saturating_sub(1))).map(at).collect()
}

/// The first round's candidates by name, best first.
pub(super) fn weighed(dictionary: &Dictionary, selection: &Selection) -> Vec<Weighed> {
    let name = |considered: &super::screen::Considered| {
        let subject = &dictionary.candidates[considered.candidate].subject;
        Weighed {
            effect: subject.name().to_string(),
            on: subject.on(),
            gain: considered.gain,
            evidence: considered.score,
            held_out_gain: considered.held_out_gain,
        }
    };
    selection.considered.iter().map(name).collect()
}
