//! Sensors whose errors remember the one before.
//!
//! A filter that takes a sensor's errors for white believes a run of them, and finds a faint force that
//! is not there. What such an error hides of a motion that is slow against it is what white errors of
//! `sd √((1 + ψ)/(1 − ψ))` would hide, where `ψ` is the correlation of an error with the one before.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::linearised::linearised;
use super::search::Fitted;
use super::settings::MARGIN;
use super::settle::{Adapt, settle};
use crate::log::{Warning, median_step};
use crate::machine::SolveError;
use crate::regression::{CORRELATION, ChannelErrors};

/// Correlation of each sensor's error with the one before, by derivative and coordinate; zero where white.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorMemory(pub [Vec<f64>; 3]);

impl SensorMemory {
    /// None, of so many coordinates.
    pub(super) fn none(coordinates: usize) -> Self {
        Self([0; 3].map(|_| vec![0.0; coordinates]))
    }

    /// By how much more white errors hide as much of a slow motion, of the sensors of one derivative.
    pub(super) fn white_equivalent(&self, derivative: usize, sd: &[f64]) -> Vec<f64> {
        let each = sd.iter().enumerate();
        each.map(|(i, sd)| sd * self.more(derivative, i).sqrt())
            .collect()
    }

    /// How many times as large the variance of such white errors is as that of the sensor's own.
    fn more(&self, derivative: usize, coordinate: usize) -> f64 {
        let memory = self.0[derivative][coordinate];
        (1.0 + memory) / (1.0 - memory)
    }
}

impl Observed {
    /// What should be known about sensors whose errors last.
    pub(super) fn said_of_sensors(&self) -> impl Iterator<Item = Warning> {
        let prefixes = ["q_", "dq_", "ddq_"].into_iter().zip(&self.sensor_memory.0);
        prefixes.flat_map(|(prefix, memory)| {
            let each = self.record.coordinates.iter().zip(memory);
            let lasting = each.filter(|(_, memory)| **memory > 0.0);
            lasting.map(move |(name, &memory)| Warning::LastingErrors {
                column: format!("{prefix}{name}"),
                memory,
            })
        })
    }
}

/// How unlikely a log is if sensor noise alone is to blame for what an explanation leaves.
pub(super) struct WithoutForces {
    /// Mean squared innovation of sensors as they are thought to be.
    pub misfit: f64,
    /// Log likelihood, nats, of sensors as they are thought to be.
    pub log_likelihood: f64,
    /// Negative log likelihood, nats, where each sensor errs as it looks.
    pub cost: f64,
    /// How each sensor looks whose errors last for less long than forces do.
    channels: Vec<ChannelErrors>,
}

impl WithoutForces {
    /// Of a hypothesis and its values.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn new(dictionary: &Dictionary, fitted: &Fitted) -> Result<Self, SolveError> {
        let (observed, values) = (&fitted.explanation.observed, &fitted.explanation.values);
        let focus = dictionary.focus(fitted.hypothesis.candidates());
        let dynamics = linearised(&focus, observed, values)?;
        let readings = observed.readings(&focus, values, &dynamics.accelerations());
        let mut noise = fitted.explanation.noise.at_smallest().at_smallest_jitter();
        let settled = settle(&dynamics, &readings, &[], &mut noise, Adapt::Not);
        let rows = settled.gram.readings().max(1) as f64;
        let mut channels = settled.whitener.channel_errors();
        // What lasts as long as forces do is no noise, but a sensor that misreads.
        let longest = (-median_step(&dynamics.t) / CORRELATION).exp();
        channels.retain(|own| own.memory < longest);
        let gained: f64 = channels.iter().map(|own| own.gain.max(0.0)).sum();
        // A sensor whose errors last is taken to be noisier than it is.
        let taken_for_noise = channels.iter().map(|own| {
            let more = observed.sensor_memory.more(own.derivative, own.coordinate);
            own.squares * (more - 1.0)
        });
        let misfit = settled.gram.data_misfit() + taken_for_noise.sum::<f64>();
        Ok(Self {
            misfit: misfit / rows,
            log_likelihood: -settled.cost(),
            cost: settled.cost() - gained,
            channels,
        })
    }

    /// Sensors whose errors clearly last.
    fn lasting(&self) -> impl Iterator<Item = &ChannelErrors> {
        let channels = self.channels.iter();
        channels.filter(|own| own.by_memory > MARGIN && own.memory > 0.0)
    }

    /// The cost after the price of what is new about sensors whose errors last.
    fn priced(&self) -> f64 {
        self.cost + MARGIN * self.lasting().count() as f64
    }

    /// Whether sensors whose errors last explain what a hypothesis leaves better than forces do.
    pub fn explain_more(&self, fitted: &Fitted) -> bool {
        self.lasting().next().is_some() && self.priced() <= fitted.estimate.cost
    }

    /// The score of a hypothesis where each sensor errs as it looks, or beside forces where these explain more of
    /// what it leaves.
    pub fn score(&self, fitted: &Fitted) -> f64 {
        let beside_forces = fitted.estimate.cost;
        fitted.score - beside_forces + self.priced().min(beside_forces)
    }
}

/// The log seen through sensors whose errors last, where these explain what a hypothesis leaves better than
/// forces do, after the price of what is new about each sensor. Nothing where they do not.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub(super) fn with_memory(
    dictionary: &Dictionary,
    fitted: &Fitted,
    observed: &Observed,
) -> Result<Option<Observed>, SolveError> {
    let without = WithoutForces::new(dictionary, fitted)?;
    if !without.explain_more(fitted) {
        return Ok(None);
    }
    let mut seen = observed.clone();
    for own in without.lasting() {
        let (derivative, i) = (own.derivative, own.coordinate);
        let thought = observed.white_equivalent(derivative)[i];
        let memory = own.memory;
        seen.sensor_memory.0[derivative][i] = memory;
        let variance = own.news / (1.0 - memory * memory);
        seen.sensor_sd_mut(derivative)[i] = thought * variance.sqrt();
    }
    Ok(Some(seen))
}
