//! Lagrange's equations from energies [3.19–3.26].

use super::reading::Readings;
use crate::graph::ExprId;
use crate::model::Model;

pub(super) struct Lagrange {
    pub mass_matrix: Vec<Vec<ExprId>>,
    pub bias_force: Vec<ExprId>,
    pub kinetic: ExprId,
    pub potential: ExprId,
}

/// `M = ∂²T/∂v²` and `Q_C = ∂(T−V)/∂q − (∂²T/∂v∂q) v − ∂²T/∂v∂t`.
pub(super) fn equations(model: &mut Model, readings: &Readings) -> Lagrange {
    let velocities: Vec<_> = model.coordinates.iter().map(|c| c.velocity).collect();
    let positions: Vec<_> = model.coordinates.iter().map(|c| c.position).collect();
    let time_seeds = model.time_seeds();
    let energies = readings.resolve(model, &[model.kinetic, model.potential]);
    let (kinetic, potential) = (energies[0], energies[1]);
    let graph = &mut model.graph;
    let momenta: Vec<ExprId> = velocities
        .iter()
        .map(|&v| graph.derivatives(&[kinetic], v)[0])
        .collect();
    let mut mass_matrix = graph.jacobian(&momenta, &velocities);
    for row in 0..mass_matrix.len() {
        for column in 0..row {
            // Equal by the symmetry of second derivatives; one expression serves both.
            mass_matrix[row][column] = mass_matrix[column][row];
        }
    }
    let momentum_rates = graph.directional(&momenta, &time_seeds);
    let bias_force = positions
        .iter()
        .zip(momentum_rates)
        .map(|(&q, momentum_rate)| {
            let slopes = graph.derivatives(&[kinetic, potential], q);
            let lagrangian_slope = graph.sub(slopes[0], slopes[1]);
            graph.sub(lagrangian_slope, momentum_rate)
        })
        .collect();
    Lagrange {
        mass_matrix,
        bias_force,
        kinetic,
        potential,
    }
}
