//! Homogeneous second derivatives of frames, and what they do to masses.
//!
//! The points of a frame accelerate by `U r + a`, the upper rows of its `Ẍ`. Of a frame that
//! turns, `U = [ω̇]ₓ + [ω]ₓ[ω]ₓ`; of one against another that turns as well, `U` is a
//! difference of two of these.

use super::inertia::PseudoInertia;
use super::newton_euler::Wrench;
use super::turn::{self, Matrix};
use super::vector::{self, Vector};
use crate::graph::{ExprId, Graph};

/// `U`, with the differences of its diagonal, which may be cheaper than the diagonal.
#[derive(Debug, Clone, Copy)]
pub(super) struct SecondDerivative {
    pub matrix: Matrix,
    /// `U_kk − U_jj`, with `i, j, k` in cyclic order.
    differences: Vector,
}

impl SecondDerivative {
    /// `[ω̇]ₓ + [ω]ₓ[ω]ₓ`
    pub fn new(g: &mut Graph, omega: Vector, omega_dot: Vector) -> Self {
        let squares = omega.map(|x| g.mul(x, x));
        let mut matrix = [vector::zero(g); 3];
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let sum = g.add(squares[j], squares[k]);
            matrix[i][i] = g.neg(sum);
            let product = g.mul(omega[i], omega[j]);
            matrix[i][j] = g.sub(product, omega_dot[k]);
            matrix[j][i] = g.add(product, omega_dot[k]);
        }
        // U_kk − U_jj = ω_k² − ω_j²
        let differences = [0, 1, 2].map(|i| g.sub(squares[(i + 2) % 3], squares[(i + 1) % 3]));
        Self {
            matrix,
            differences,
        }
    }

    /// What a joint's own rate `v` and its change `v̇` about z add to the `U` of what carries
    /// it, which turns by `ω`: `2 v [ω]ₓ[z]ₓ + v² [z]ₓ[z]ₓ + v̇ [z]ₓ`.
    pub fn of_joint(g: &mut Graph, omega: Vector, rate: ExprId, rate_change: ExprId) -> Self {
        let zero = g.zero();
        let own = g.add(omega[2], rate);
        let both = g.add(omega[2], own);
        let inwards = g.mul(rate, both);
        let inwards = g.neg(inwards);
        let doubled = g.scale(2.0, rate);
        let (x, y) = (g.mul(doubled, omega[0]), g.mul(doubled, omega[1]));
        Self {
            matrix: [
                [inwards, g.neg(rate_change), zero],
                [rate_change, inwards, zero],
                [x, y, zero],
            ],
            differences: [g.neg(inwards), inwards, zero],
        }
    }

    /// `U = 0`
    pub fn zero(g: &mut Graph) -> Self {
        let zero = vector::zero(g);
        Self {
            matrix: [zero; 3],
            differences: zero,
        }
    }

    /// `U r`
    pub fn times(&self, g: &mut Graph, r: Vector) -> Vector {
        turn::times(g, &self.matrix, r)
    }

    /// What moves a mass distribution so, whose frame's origin accelerates by `a`:
    /// `f = m a + U h`, and `n` the skew part of `U S + a hᵀ`.
    pub fn wrench(&self, g: &mut Graph, inertia: &PseudoInertia, a: Vector) -> Wrench {
        let (s, h, u) = (&inertia.second, inertia.first, &self.matrix);
        let direct = vector::scale(g, inertia.mass, a);
        let swing = self.times(g, h);
        let moment = std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            // Row k times column j minus row j times column k of U S + a hᵀ.
            let terms = [
                (u[k][j], s[j][j], true),
                (u[j][k], s[k][k], false),
                (self.differences[i], s[j][k], true),
                (u[k][i], s[i][j], true),
                (u[j][i], s[i][k], false),
                (a[k], h[j], true),
                (a[j], h[k], false),
            ];
            let mut total = g.zero();
            for (x, y, plus) in terms {
                let term = g.mul(x, y);
                total = if plus {
                    g.add(total, term)
                } else {
                    g.sub(total, term)
                };
            }
            total
        });
        Wrench {
            moment,
            force: vector::add(g, direct, swing),
        }
    }
}
