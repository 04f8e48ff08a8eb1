//! Which variables a matrix or a force refers to.

use super::mechanism::Mechanism;
use crate::graph::{ExprId, Graph};

/// A choice of velocity variables `x`: every freedom's rate is `Σ c x[i]`.
#[derive(Debug, Clone)]
pub(super) struct Space {
    pub size: usize,
    /// Per link and freedom: the pairs `(i, c)`.
    maps: Vec<Vec<Vec<(usize, ExprId)>>>,
}

impl Space {
    /// The generalised coordinates' velocities.
    pub fn coordinates(mechanism: &Mechanism) -> Self {
        let maps = (mechanism.links.iter())
            .map(|link| link.freedoms.iter().map(|f| f.map.clone()).collect())
            .collect();
        Self {
            size: mechanism.coordinates,
            maps,
        }
    }

    /// As the coordinates, but the first three of a quaternion's four places
    /// hold the angular velocity and the fourth is unused: nothing in it is
    /// redundant, so the mass matrix is definite without help.
    pub fn quasi(g: &mut Graph, mechanism: &Mechanism) -> Self {
        let mut space = Self::coordinates(mechanism);
        let one = g.one();
        for (link, maps) in mechanism.links.iter().zip(&mut space.maps) {
            if let Some(quaternion) = link.spherical {
                for (map, &place) in maps.iter_mut().zip(&quaternion) {
                    *map = vec![(place, one)];
                }
            }
        }
        space
    }

    /// `J x`, per link and freedom.
    pub fn rates(&self, g: &mut Graph, x: &[ExprId]) -> Vec<Vec<ExprId>> {
        let mut rate = |map: &Vec<(usize, ExprId)>| {
            let mut total = g.zero();
            for &(index, coefficient) in map {
                let term = g.mul(coefficient, x[index]);
                total = g.add(total, term);
            }
            total
        };
        let links = self.maps.iter();
        links
            .map(|maps| maps.iter().map(&mut rate).collect())
            .collect()
    }

    /// `Jᵀ τ`
    pub fn force(&self, g: &mut Graph, forces: &[Vec<ExprId>]) -> Vec<ExprId> {
        let mut total = vec![g.zero(); self.size];
        for (maps, forces) in self.maps.iter().zip(forces) {
            for (map, &force) in maps.iter().zip(forces) {
                for &(index, coefficient) in map {
                    let term = g.mul(coefficient, force);
                    total[index] = g.add(total[index], term);
                }
            }
        }
        total
    }

    /// `Jᵀ X` of a matrix with a row per freedom, numbered link by link, and a column per
    /// variable: square also where nothing moves and there is no row to take the width from.
    pub fn rows(&self, g: &mut Graph, matrix: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
        let mut result = vec![vec![g.zero(); self.size]; self.size];
        for (row, map) in matrix.iter().zip(self.maps.iter().flatten()) {
            for &(index, coefficient) in map {
                for (target, &entry) in result[index].iter_mut().zip(row) {
                    let term = g.mul(coefficient, entry);
                    *target = g.add(*target, term);
                }
            }
        }
        result
    }

    /// `Jᵀ M J` of a symmetric matrix over freedoms, numbered link by link.
    pub fn congruence(&self, g: &mut Graph, matrix: &[Vec<ExprId>]) -> Vec<Vec<ExprId>> {
        let maps: Vec<&Vec<(usize, ExprId)>> = self.maps.iter().flatten().collect();
        let zero = g.zero();
        let mut right = vec![vec![zero; self.size]; maps.len()];
        for (row, target) in matrix.iter().zip(&mut right) {
            for (&entry, map) in row.iter().zip(&maps) {
                for &(index, coefficient) in *map {
                    let term = g.mul(entry, coefficient);
                    target[index] = g.add(target[index], term);
                }
            }
        }
        let mut result = vec![vec![zero; self.size]; self.size];
        for (map, row) in maps.iter().zip(&right) {
            for &(index, coefficient) in *map {
                for column in index..self.size {
                    let term = g.mul(coefficient, row[column]);
                    result[index][column] = g.add(result[index][column], term);
                    result[column][index] = result[index][column];
                }
            }
        }
        result
    }
}
