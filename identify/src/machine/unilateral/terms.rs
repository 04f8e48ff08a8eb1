//! What the model says of its contacts at one state.

use crate::machine::{Machine, States};
use dynamics_codegen::{Compiled, System, Tape};
use nalgebra::{DMatrix, DVector};

/// The terms of `c` contacts. Rows of three belong to one: along the plane's two axes, then along
/// its normal ([`Plane::axes`](dynamics_codegen::model::Plane::axes)).
#[derive(Debug, Clone)]
pub struct ContactTerms {
    /// Distances from the planes, m, `c`; below zero inside.
    pub gap: DVector<f64>,
    /// `w`, m/s, `3c`.
    pub velocity: DVector<f64>,
    /// `J = ∂w/∂v`, `3c×n`.
    pub jacobian: DMatrix<f64>,
    /// `b` of `ẇ = J a − b`, m/s², `3c`.
    pub bias: DVector<f64>,
    /// Coefficients of friction, `c`.
    pub friction: DVector<f64>,
    /// Coefficients of restitution, `c`.
    pub restitution: DVector<f64>,
}

impl ContactTerms {
    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.gap.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.gap.is_empty()
    }

    /// Velocity along the normal of contact `index`, m/s: the rate of its gap.
    pub fn approach(&self, index: usize) -> f64 {
        self.velocity[3 * index + 2]
    }
}

/// The contacts' tape; `None` if there is no contact.
pub(in crate::machine) fn tape(compiled: &Compiled) -> Option<Tape> {
    let system = &compiled.system;
    let outputs = [
        system.contact_gap.clone(),
        system.contact_velocity.clone(),
        system.contact_jacobian.concat(),
        system.contact_bias.clone(),
        system.contact_coefficients.concat(),
    ]
    .concat();
    let arguments = System::arguments(&compiled.model);
    (!outputs.is_empty()).then(|| Tape::new(&compiled.model.graph, &outputs, &arguments))
}

impl Machine {
    /// Number of contacts `c`.
    pub fn contact_count(&self) -> usize {
        self.compiled.model.contacts.len()
    }

    /// What the model says of its contacts at every state.
    pub fn contact_terms(&self, states: &States, parameters: &[f64]) -> Vec<ContactTerms> {
        let completed = self.completed(states, parameters);
        let states = completed.as_ref().unwrap_or(states);
        let values = match &self.contacts {
            Some(tape) => tape.evaluate_all(&states.columns(parameters), states.len()),
            None => Vec::new(),
        };
        let samples = 0..states.len();
        samples
            .map(|sample| self.contacts_at(&values, sample))
            .collect()
    }

    fn contacts_at(&self, values: &[Vec<f64>], sample: usize) -> ContactTerms {
        let (c, n) = (self.contact_count(), self.coordinate_count());
        let next = &mut values.iter().map(|column| column[sample]);
        let vector = |next: &mut dyn Iterator<Item = f64>, rows: usize| {
            DVector::from_iterator(rows, next.take(rows))
        };
        let gap = vector(next, c);
        let velocity = vector(next, 3 * c);
        let jacobian = DMatrix::from_row_iterator(3 * c, n, next.take(3 * c * n));
        let bias = vector(next, 3 * c);
        let coefficients = DMatrix::from_row_iterator(c, 2, next.take(2 * c));
        ContactTerms {
            gap,
            velocity,
            jacobian,
            bias,
            friction: coefficients.column(0).into_owned(),
            restitution: coefficients.column(1).into_owned(),
        }
    }
}
