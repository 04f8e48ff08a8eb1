//! Inertia and bias: bodies by recursion over their tree, energies by Lagrange.

use super::lagrange::{self, Lagrange};
use super::reading::Readings;
use crate::graph::ExprId;
use crate::model::Model;

pub(super) struct Inertial {
    pub mass_matrix: Vec<Vec<ExprId>>,
    pub bias_force: Vec<ExprId>,
    /// The same by the operations that are fewest beside the mass matrix.
    pub bias_force_beside_mass: Vec<ExprId>,
    pub kinetic_energy: ExprId,
    pub potential_energy: ExprId,
}

/// `M` and `Q_C`: both parts add up.
pub(super) fn terms(model: &mut Model, readings: &Readings) -> Inertial {
    let Lagrange {
        mut mass_matrix,
        mut bias_force,
        kinetic,
        potential,
    } = lagrange::equations(model, readings);
    let (mut kinetic_energy, mut potential_energy) = (kinetic, potential);
    let mut bias_force_beside_mass = bias_force.clone();
    if let Some(mechanism) = model.mechanism.clone() {
        let graph = &mut model.graph;
        let of_bodies = mechanism.mass_matrix(graph);
        for (row, part) in mass_matrix.iter_mut().zip(of_bodies) {
            for (entry, part) in row.iter_mut().zip(part) {
                *entry = graph.add(*entry, part);
            }
        }
        for (entry, part) in bias_force.iter_mut().zip(mechanism.bias_force(graph)) {
            *entry = graph.add(*entry, part);
        }
        let of_bodies = mechanism.bias_force_beside_mass(graph);
        for (entry, part) in bias_force_beside_mass.iter_mut().zip(of_bodies) {
            *entry = graph.add(*entry, part);
        }
        let of_bodies = mechanism.kinetic_energy(graph);
        kinetic_energy = graph.add(kinetic_energy, of_bodies);
        let of_bodies = mechanism.potential_energy(graph);
        potential_energy = graph.add(potential_energy, of_bodies);
    }
    Inertial {
        mass_matrix,
        bias_force,
        bias_force_beside_mass,
        kinetic_energy,
        potential_energy,
    }
}

/// `M a − Q_C`: what it takes to accelerate by `a`, bodies by Newton–Euler.
pub(super) fn inverse(model: &mut Model, readings: &Readings, a: &[ExprId]) -> Vec<ExprId> {
    let mut needed = inverse_of_energies(model, readings, a);
    if let Some(mechanism) = model.mechanism.clone() {
        let of_bodies = mechanism.inverse_dynamics(&mut model.graph, a);
        for (entry, part) in needed.iter_mut().zip(of_bodies) {
            *entry = model.graph.add(*entry, part);
        }
    }
    needed
}

/// The part of [`inverse`] that the stated energies make, without the bodies.
pub(super) fn inverse_of_energies(
    model: &mut Model,
    readings: &Readings,
    a: &[ExprId],
) -> Vec<ExprId> {
    let energies = lagrange::equations(model, readings);
    let graph = &mut model.graph;
    (energies.mass_matrix.iter().zip(&energies.bias_force))
        .map(|(row, &bias)| {
            let inertial = graph.inner_product(row, a);
            graph.sub(inertial, bias)
        })
        .collect()
}
