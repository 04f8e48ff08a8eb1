//! The composite-rigid-body algorithm in link frames.

use super::inertia::PseudoInertia;
use super::mechanism::{Axis, Mechanism};
use super::newton_euler::Wrench;
use super::space::Space;
use super::vector;
use crate::graph::{ExprId, Graph};

impl Mechanism {
    /// The mass matrix `M(q)`, symmetric node by node. For a floating body see
    /// [`Floating`](super::Floating) on what is added along the quaternion.
    pub fn mass_matrix(&self, g: &mut Graph) -> Vec<Vec<ExprId>> {
        if let Some(upright) = &self.upright.beside_mass {
            return upright.mass_matrix(g);
        }
        let over_freedoms = self.freedom_mass_matrix(g);
        let mut matrix = Space::coordinates(self).congruence(g, &over_freedoms);
        self.fill_quaternion_direction(g, &mut matrix);
        matrix
    }

    /// `M` over the freedoms, numbered link by link.
    pub(super) fn freedom_mass_matrix(&self, g: &mut Graph) -> Vec<Vec<ExprId>> {
        let composites = self.composites(g);
        let starts = self.freedom_starts();
        let size = starts[self.links.len()];
        let mut matrix = vec![vec![g.zero(); size]; size];
        for i in 0..self.links.len() {
            for k in 0..self.links[i].freedoms.len() {
                let axis = self.links[i].freedoms[k].axis;
                let mut wrench = momentum_along(g, &composites[i], axis);
                let row = starts[i] + k;
                let mut j = i;
                loop {
                    for (l, freedom) in self.links[j].freedoms.iter().enumerate() {
                        let column = starts[j] + l;
                        if column <= row {
                            matrix[row][column] = wrench.along(g, freedom.axis);
                            matrix[column][row] = matrix[row][column];
                        }
                    }
                    let Some(parent) = self.links[j].parent else {
                        break;
                    };
                    wrench = self.to_parent(g, j, &wrench);
                    j = parent;
                }
            }
        }
        matrix
    }

    /// Number of the first freedom of each link, and how many there are.
    pub(super) fn freedom_starts(&self) -> Vec<usize> {
        let mut starts = vec![0];
        for link in &self.links {
            starts.push(starts[starts.len() - 1] + link.freedoms.len());
        }
        starts
    }

    /// The pseudo-inertia of each link with all that hangs on it, in its frame.
    pub(super) fn composites(&self, g: &mut Graph) -> Vec<PseudoInertia> {
        let mut composites: Vec<PseudoInertia> =
            self.links.iter().map(|link| link.inertia).collect();
        for i in (0..self.links.len()).rev() {
            if let Some(parent) = self.links[i].parent {
                let turned = composites[i].turn(g, &self.links[i].stages);
                let moved = turned.shift(g, self.links[i].shift);
                composites[parent] = composites[parent].add(g, &moved);
            }
        }
        composites
    }

    /// Adds `κ η ηᵀ`, `κ = 4 · ⅓ tr(J)`, for each quaternion.
    fn fill_quaternion_direction(&self, g: &mut Graph, matrix: &mut [Vec<ExprId>]) {
        for link in &self.links {
            let Some((places, quaternion)) = link.spherical.zip(link.quaternion) else {
                continue;
            };
            // tr(J) = 2 tr(S)
            let s = &link.inertia.second;
            let trace = g.sum([s[0][0], s[1][1], s[2][2]]);
            let stiffness = match g.as_constant(trace) {
                Some(value) if value <= 0.0 => g.one(),
                _ => g.scale(8.0 / 3.0, trace),
            };
            for (a, &i) in places.iter().enumerate() {
                for (b, &j) in places.iter().enumerate() {
                    let (x, y) = (quaternion[a.min(b)], quaternion[a.max(b)]);
                    let scaled = g.mul(stiffness, x);
                    let extra = g.mul(scaled, y);
                    if i <= j {
                        matrix[i][j] = g.add(matrix[i][j], extra);
                        matrix[j][i] = matrix[i][j];
                    }
                }
            }
        }
    }
}

/// `I s`: the wrench that a unit acceleration along `axis` takes.
pub(super) fn momentum_along(g: &mut Graph, inertia: &PseudoInertia, axis: Axis) -> Wrench {
    match axis {
        Axis::Angular(k) => {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let mut wrench = Wrench::zero(g);
            wrench.moment[k] = inertia.moment(g, k);
            wrench.moment[i] = g.neg(inertia.second[i][k]);
            wrench.moment[j] = g.neg(inertia.second[j][k]);
            wrench.force[i] = g.neg(inertia.first[j]);
            wrench.force[j] = inertia.first[i];
            wrench
        }
        Axis::Linear(a) => {
            let a = vector::constant(g, a);
            Wrench {
                moment: vector::cross(g, inertia.first, a),
                force: vector::scale(g, inertia.mass, a),
            }
        }
    }
}
