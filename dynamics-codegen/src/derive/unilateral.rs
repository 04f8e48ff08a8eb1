//! Unilateral contacts along the motion: gaps, velocities, and how accelerations change these.

use super::constraint;
use super::reading::Readings;
use crate::graph::ExprId;
use crate::model::{ConstraintKind, Model};

pub(super) struct Contacts {
    pub gap: Vec<ExprId>,
    pub velocity: Vec<ExprId>,
    pub jacobian: Vec<Vec<ExprId>>,
    pub bias: Vec<ExprId>,
    pub coefficients: Vec<Vec<ExprId>>,
}

/// Per contact the gap `g` and, along the plane's axes and then its normal, the velocity
/// `w = J v + ∂x/∂t`; its rate is `J a − b`. A contact velocity is a nonholonomic residual.
pub(super) fn contacts(model: &mut Model, readings: &Readings) -> Contacts {
    let gaps: Vec<ExprId> = model.contacts.iter().map(|c| c.gap).collect();
    let velocities: Vec<ExprId> = model.contacts.iter().flat_map(|c| c.velocity).collect();
    let coefficients = model.contacts.iter();
    let coefficients = coefficients.map(|c| vec![c.friction, c.restitution]);
    let mut contacts = Contacts {
        coefficients: coefficients.collect(),
        gap: readings.resolve(model, &gaps),
        velocity: Vec::new(),
        jacobian: Vec::new(),
        bias: Vec::new(),
    };
    for velocity in velocities {
        let row = constraint::row(model, readings, velocity, ConstraintKind::Nonholonomic);
        contacts.velocity.push(row.rate);
        contacts.jacobian.push(row.jacobian);
        contacts.bias.push(row.bias);
    }
    contacts
}
