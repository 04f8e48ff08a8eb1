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

/// `M = ∂²T/∂v²` and `Q_C = ∂(T−V)/∂q − (∂²T/∂v∂q) v − ∂²T/∂v∂t`; along a twist with the
/// terms of Boltzmann and Hamel.
pub(super) fn equations(model: &mut Model, readings: &Readings) -> Lagrange {
    let velocities: Vec<_> = model.coordinates.iter().map(|c| c.velocity).collect();
    let displacements: Vec<_> = (0..velocities.len())
        .map(|index| model.displacement(index))
        .collect();
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
    let mut bias_force: Vec<ExprId> = displacements
        .iter()
        .zip(momentum_rates)
        .map(|(displacement, momentum_rate)| {
            let slopes = graph.directional(&[kinetic, potential], displacement);
            let lagrangian_slope = graph.sub(slopes[0], slopes[1]);
            graph.sub(lagrangian_slope, momentum_rate)
        })
        .collect();
    turn_momenta(model, &momenta, &mut bias_force);
    Lagrange {
        mass_matrix,
        bias_force,
        kinetic,
        potential,
    }
}

/// What momenta `p, L` along a twist `v, ω` owe to its frame's own motion: `−ω × p` and
/// `−(ω × L + v × p)`.
fn turn_momenta(model: &mut Model, momenta: &[ExprId], bias_force: &mut [ExprId]) {
    for pose in &model.poses {
        let at = |k: usize| pose.first + k;
        let graph = &mut model.graph;
        let velocities = [0, 1, 2, 3, 4, 5].map(|k| graph.var(model.coordinates[at(k)].velocity));
        let mut turn = |bias: usize, by: usize, momentum: usize| {
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let more = graph.mul(velocities[by + k], momenta[at(momentum + j)]);
                let less = graph.mul(velocities[by + j], momenta[at(momentum + k)]);
                let change = graph.sub(more, less);
                let entry = &mut bias_force[at(bias + i)];
                *entry = graph.add(*entry, change);
            }
        };
        turn(0, 3, 0);
        turn(3, 3, 3);
        turn(3, 0, 0);
    }
}
