//! Mass distributions as pseudo-inertias.
//!
//! A body's second moments `S = Σ m r rᵀ`, first moment `h = Σ m r` and mass `m`
//! about a frame's origin form the 4×4 matrix `P = [[S, h], [hᵀ, m]]` (Wensing,
//! Kim, Slotine 2018). With the homogeneous second derivative `Ẍ` of the frame,
//! the inertial wrench is the skew part of `Ẍ P`; with the twist, the momentum.
//! Against the inertia tensor `J = tr(S) 1 − S` it turns and shifts with fewer
//! operations, and what a joint cannot see of it is simply entries of `P`.

use super::Inertia;
use super::turn::{self, Matrix, Stage};
use super::vector::{self, Rotation, Vector};
use crate::graph::{ExprId, Graph};

/// `P = [[S, h], [hᵀ, m]]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct PseudoInertia {
    pub mass: ExprId,
    pub first: Vector,
    pub second: Matrix,
}

/// Adds a symmetric matrix, given by its entries on and above the diagonal.
fn add_symmetric(
    g: &mut Graph,
    sum: &mut [Vector; 3],
    entry: impl Fn(&mut Graph, usize, usize) -> ExprId,
) {
    for i in 0..3 {
        for j in i..3 {
            let change = entry(g, i, j);
            sum[i][j] = g.add(sum[i][j], change);
            sum[j][i] = sum[i][j];
        }
    }
}

impl PseudoInertia {
    /// Whether turning it about z changes nothing.
    pub fn is_symmetric_about_z(&self, g: &Graph) -> bool {
        let s = &self.second;
        let off = [s[0][1], s[0][2], s[1][2], self.first[0], self.first[1]];
        let equal = match (g.as_constant(s[0][0]), g.as_constant(s[1][1])) {
            (Some(x), Some(y)) => (x - y).abs() <= 4.0 * f64::EPSILON * x.abs().max(y.abs()),
            _ => s[0][0] == s[1][1],
        };
        equal && off.iter().all(|&x| g.is_zero(x))
    }

    pub fn zero(g: &mut Graph) -> Self {
        let zero = vector::zero(g);
        Self {
            mass: zero[0],
            first: zero,
            second: [zero; 3],
        }
    }

    /// About the link's origin: `S = ½ tr(J) 1 − J + m c cᵀ`, `h = m c`.
    pub fn of_body(g: &mut Graph, body: &Inertia) -> Self {
        let j = &body.tensor;
        let mut second = [vector::zero(g); 3];
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            let others = g.add(j[b][b], j[c][c]);
            let twice = g.sub(others, j[a][a]);
            second[a][a] = g.scale(0.5, twice);
            second[a][b] = g.neg(j[a.min(b)][a.max(b)]);
            second[b][a] = second[a][b];
        }
        let first = vector::scale(g, body.mass, body.center);
        add_symmetric(g, &mut second, |g, i, j| g.mul(first[i], body.center[j]));
        Self {
            mass: body.mass,
            first,
            second,
        }
    }

    pub fn is_constant(&self, g: &Graph) -> bool {
        let moments = self.second.iter().chain([&self.first]);
        g.as_constant(self.mass).is_some() && moments.flatten().all(|&x| g.as_constant(x).is_some())
    }

    pub fn add(&self, g: &mut Graph, other: &Self) -> Self {
        Self {
            mass: g.add(self.mass, other.mass),
            first: vector::add(g, self.first, other.first),
            second: std::array::from_fn(|i| vector::add(g, self.second[i], other.second[i])),
        }
    }

    pub fn neg(&self, g: &mut Graph) -> Self {
        Self {
            mass: g.neg(self.mass),
            first: vector::neg(g, self.first),
            second: self.second.map(|row| vector::neg(g, row)),
        }
    }

    /// The same masses seen from a frame in which the old origin lies at `p`:
    /// `S + h pᵀ + p hᵀ + m p pᵀ`, `h + m p`.
    pub fn shift(&self, g: &mut Graph, p: Vector) -> Self {
        let moved = vector::scale(g, self.mass, p);
        let first = vector::add(g, self.first, moved);
        let mut second = self.second;
        add_symmetric(g, &mut second, |g, i, j| {
            // hᵢ pⱼ + pᵢ (hⱼ + m pⱼ)
            let left = g.mul(self.first[i], p[j]);
            let right = g.mul(p[i], first[j]);
            g.add(left, right)
        });
        Self {
            mass: self.mass,
            first,
            second,
        }
    }

    /// Seen from the frame before the stages.
    pub fn turn(&self, g: &mut Graph, stages: &[Stage]) -> Self {
        Self {
            mass: self.mass,
            first: turn::up(g, stages, self.first),
            second: turn::up_matrix(g, stages, &self.second),
        }
    }

    /// Seen through a constant rotation.
    pub fn rotate(&self, g: &mut Graph, r: &Rotation) -> Self {
        Self {
            mass: self.mass,
            first: vector::rotate(g, r, self.first),
            second: turn::rotate_symmetric(g, r, &self.second),
        }
    }

    /// `J = tr(S) 1 − S`, one diagonal entry.
    pub fn moment(&self, g: &mut Graph, axis: usize) -> ExprId {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        g.add(self.second[i][i], self.second[j][j])
    }

    /// Sets constant entries to zero that are round-off beside `scale`, the
    /// largest entry of what they were computed from.
    pub fn tidy(&self, g: &mut Graph, scale: f64) -> Self {
        let threshold = 16.0 * f64::EPSILON * scale;
        let mut clean = |x: ExprId| match g.as_constant(x) {
            Some(value) if value.abs() <= threshold => g.zero(),
            _ => x,
        };
        Self {
            mass: clean(self.mass),
            first: self.first.map(&mut clean),
            second: self.second.map(|row| row.map(&mut clean)),
        }
    }

    /// The largest constant entry.
    pub fn magnitude(&self, g: &Graph) -> f64 {
        let moments = self.second.iter().chain([&self.first]).flatten();
        moments
            .chain([&self.mass])
            .filter_map(|&x| g.as_constant(x))
            .fold(0.0, |largest, x| largest.max(x.abs()))
    }
}
