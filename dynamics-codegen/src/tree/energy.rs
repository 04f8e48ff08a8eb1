//! Energies: what the recursions are checked against.

use super::mechanism::Mechanism;
use super::vector;
use crate::graph::{ExprId, Graph};

impl Mechanism {
    /// Kinetic energy. Inertia that was regrouped away to the world moves no
    /// more than the world does: the energy is the tree's.
    pub fn kinetic_energy(&self, g: &mut Graph) -> ExprId {
        let rest = vec![g.zero(); self.coordinates];
        let states = self.states(g, &rest, false);
        let mut doubled = g.zero();
        for (link, state) in self.links.iter().zip(&states) {
            let (w, v, body) = (state.omega, state.velocity, &link.inertia);
            // m v² + 2 v · (ω × h) + ωᵀ J ω
            let square = vector::dot(g, v, v);
            let translation = g.mul(body.mass, square);
            let spin = vector::cross(g, w, body.first);
            let mixed = vector::dot(g, v, spin);
            let mixed = g.scale(2.0, mixed);
            let mut rotation = g.zero();
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let moment = body.moment(g, i);
                let own = g.mul(moment, w[i]);
                let first = g.mul(body.second[i][j], w[j]);
                let second = g.mul(body.second[i][k], w[k]);
                let others = g.add(first, second);
                let momentum = g.sub(own, others);
                let term = g.mul(w[i], momentum);
                rotation = g.add(rotation, term);
            }
            doubled = g.sum([doubled, translation, mixed, rotation]);
        }
        g.scale(0.5, doubled)
    }

    /// Potential energy under gravity. Regrouping changes it by a constant.
    pub fn potential_energy(&self, g: &mut Graph) -> ExprId {
        let places = self.places(g);
        let mut total = g.zero();
        for (link, place) in self.links.iter().zip(&places) {
            let mut fall = vector::dot(g, place.origin, self.gravity);
            fall = g.mul(link.inertia.mass, fall);
            for (column, &moment) in place.columns.iter().zip(&link.inertia.first) {
                let along = vector::dot(g, *column, self.gravity);
                let term = g.mul(moment, along);
                fall = g.add(fall, term);
            }
            total = g.sub(total, fall);
        }
        total
    }
}
