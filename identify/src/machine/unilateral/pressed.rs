//! The motion at a state, contact forces included: what a log shows beside positions.

use super::solve::Problem;
use super::view::View;
use crate::machine::{Machine, Motion, SolveError, States};
use nalgebra::{DMatrix, DVector};

/// A gap below this is closed, m.
const CLOSED: f64 = 1e-6;
/// A contact that moves faster along its normal leaves, or hits, m/s.
const STAYS: f64 = 1e-3;
/// Over how long friction may stop a contact that slides: slower than one acceleration over
/// this time sticks, s.
const INSTANT: f64 = 1e-4;

/// A motion under contact forces.
#[derive(Debug, Clone)]
pub struct Pressed {
    /// Terms, accelerations and multipliers.
    pub motion: Motion,
    /// Contact forces, N, `3c`: of each along its plane's axes, then its normal.
    pub force: DVector<f64>,
}

impl Machine {
    /// The motion at every state, where planes push: `M a = Q + Aᵀλ + Jᵀf`, `A a = b`, with
    /// `ẇₙ ≥ 0 ⟂ fₙ ≥ 0` and friction at every contact that is closed. Without contacts it is
    /// [`Machine::motion`].
    ///
    /// # Errors
    /// If the equation has no unique solution at one of the states.
    pub fn pressed(&self, states: &States, parameters: &[f64]) -> Result<Vec<Pressed>, SolveError> {
        let motions = self.motion(states, parameters)?;
        if self.contact_count() == 0 {
            let force = DVector::zeros(0);
            let free = motions.into_iter().map(|motion| Pressed {
                motion,
                force: force.clone(),
            });
            return Ok(free.collect());
        }
        let contacts = self.contact_terms(states, parameters);
        let samples = motions.into_iter().zip(contacts).enumerate();
        let pressed = samples.map(|(sample, (motion, contacts))| {
            let at = states.slice(sample..sample + 1);
            let view = View::new(at, motion, contacts).map_err(|error| error.offset(sample))?;
            view.pressed().ok_or(SolveError::Pinched { sample })
        });
        pressed.collect()
    }
}

impl View {
    /// `None` if no forces fulfil the contacts' laws.
    fn pressed(self) -> Option<Pressed> {
        let closed = self.closed();
        let rows: Vec<usize> = closed.iter().flat_map(|&i| 3 * i..3 * i + 3).collect();
        let mut velocity = self.contact_acceleration().select_rows(&rows) * INSTANT;
        let slip = self.contacts.velocity.select_rows(&rows);
        for row in (0..rows.len()).filter(|row| row % 3 < 2) {
            velocity[row] += slip[row];
        }
        let problem = Problem {
            mobility: &self.mobility.select_rows(&rows).select_columns(&rows),
            velocity: &velocity,
            friction: &self.contacts.friction.select_rows(&closed),
        };
        let impulse = problem.solve(DVector::zeros(rows.len()))?.impulse;
        let mut force = DVector::zeros(self.contacts.velocity.len());
        for (&row, p) in rows.iter().zip(impulse.iter()) {
            force[row] = p / INSTANT;
        }
        Some(self.under(force))
    }

    /// Contacts that are there to stay: no force says what others do.
    fn closed(&self) -> Vec<usize> {
        let contacts = &self.contacts;
        let stays = |&i: &usize| contacts.gap[i] < CLOSED && contacts.approach(i).abs() < STAYS;
        (0..contacts.len()).filter(stays).collect()
    }

    /// The motion under contact forces.
    fn under(self, force: DVector<f64>) -> Pressed {
        let Self { mut motion, .. } = self;
        let push = &motion.terms.force + self.contacts.jacobian.transpose() * &force;
        let column =
            |values: &DVector<f64>| DMatrix::from_column_slice(values.len(), 1, values.as_slice());
        let bias = column(&motion.terms.constraint_bias);
        let (acceleration, multiplier) = motion.factorisation.solve(column(&push), &bias);
        motion.acceleration = acceleration.column(0).into_owned();
        motion.multiplier = multiplier.column(0).into_owned();
        Pressed { motion, force }
    }
}
