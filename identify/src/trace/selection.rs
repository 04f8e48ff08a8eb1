//! What a search found.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::finding::Rival;
use super::refine::Estimate;
use super::remaining::{Remaining, RemainingForce};
use super::screen::Considered;
use crate::regression::said_of_band;
use nalgebra::DMatrix;

/// A term that was accepted.
#[derive(Debug, Clone)]
pub struct Term {
    /// Which candidate.
    pub candidate: usize,
    /// Evidence in nats: how much worse the log would be explained without it,
    /// less what its parameters cost.
    pub evidence: f64,
    /// What explains about as well what it explains.
    pub rivals: Vec<Rival>,
    /// Whether it is part of a sample that only this channel is late by, as the log tells: no step of a controller,
    /// which all inputs share.
    pub is_its_own: bool,
}

/// The outcome.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Accepted terms, strongest first.
    pub terms: Vec<Term>,
    /// Values of all parameters of the extended model.
    pub values: Vec<f64>,
    /// These under the other assumption about inputs between samples, where the log is about as likely
    /// so and a time hangs on it.
    pub held_otherwise: Option<Vec<f64>>,
    /// What is known of the accepted terms' parameters.
    pub estimate: Estimate,
    /// Mean squared whitened innovation with the accepted terms; one if sensor noise
    /// explains what remains.
    pub reduced_misfit: f64,
    /// The same with no term at all.
    pub nominal_misfit: f64,
    /// Log likelihood of the log without and with the accepted terms, nats, if noise alone is to blame for what
    /// they leave; up to what depends on the log alone.
    pub log_likelihood: [f64; 2],
    /// How much that is.
    pub remaining: Remaining,
    /// The forces of unknown form beside the model as given.
    pub given_forces: Vec<RemainingForce>,
    /// The first round's candidates, best first.
    pub considered: Vec<Considered>,
    /// Whether something was left out that explained more, and had lost what gives it its name.
    pub left_out_nameless: bool,
    /// How many times narrower the band is, in which it was found in the balance of forces, than that in
    /// which the log shows accelerations.
    pub narrowing: usize,
    /// How long a force is averaged over there, s.
    pub averaged_over: f64,
    /// The log with the curve through it.
    pub observed: Observed,
}

impl Selection {
    /// What must be known of the band in which forces were balanced, where that is narrower than the one in which
    /// the log shows accelerations.
    pub fn said_of_band(&self) -> Option<String> {
        (self.narrowing > 1).then(|| said_of_band(self.averaged_over))
    }

    /// Leaves no stated loss below none: that is what the log is nearest to that a joint can have.
    pub(super) fn keep_losses_possible(&mut self, dictionary: &Dictionary) {
        let losses = dictionary.candidates.iter().filter(|own| own.is_loss);
        for &parameter in losses.flat_map(|own| &own.parameters) {
            self.values[parameter] = self.values[parameter].max(0.0);
        }
    }

    /// Whether forces remain that nothing explains.
    pub fn forces_remain(&self) -> bool {
        self.estimate.leaves_forces()
    }

    /// Whether noise of the sensors explains the log as well as forces beside the terms would, or better.
    pub(super) fn leaves_nothing(&self) -> bool {
        !self.forces_remain() || self.remaining.forces.is_empty()
    }

    /// Whether this leaves no forces, and has fewer terms.
    pub(super) fn explains_with_less(&self, than: &Self) -> bool {
        !self.forces_remain() && self.terms.len() < than.terms.len()
    }

    /// Whether the forces that this leaves are no more than half as large.
    pub(super) fn leaves_much_less(&self, than: &Self) -> bool {
        4.0 * self.estimate.unexplained < than.estimate.unexplained
    }

    /// The model as given in place of what was found.
    #[must_use]
    pub(super) fn of_nothing(&self, dictionary: &Dictionary) -> Self {
        let before = self.remaining.share_before;
        Self {
            terms: Vec::new(),
            values: dictionary.defaults.clone(),
            held_otherwise: None,
            estimate: Estimate {
                parameters: Vec::new(),
                covariance: DMatrix::zeros(0, 0),
                unexplained: before.powi(2),
                ..self.estimate.clone()
            },
            reduced_misfit: self.nominal_misfit,
            log_likelihood: [self.log_likelihood[0]; 2],
            remaining: Remaining {
                share_after: before,
                forces: self.given_forces.clone(),
                ..self.remaining.clone()
            },
            ..self.clone()
        }
    }

    /// Which candidates were accepted.
    pub fn accepted(&self) -> Vec<usize> {
        self.terms.iter().map(|term| term.candidate).collect()
    }
}
