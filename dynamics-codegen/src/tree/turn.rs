//! Planar rotations: the only kind that the recursions know.
//!
//! Every joint transform is a product of turns about coordinate axes, most of
//! them by constant multiples of 90°, which cost nothing. A turn of a vector
//! costs 4 multiplications and 2 additions, of a symmetric matrix 16 operations
//! (10 for the plane, 6 for the mixed terms), of any matrix 23.

use super::vector::{self, Rotation, Vector};
use crate::graph::{ExprId, Graph};

/// Three rows of three expressions.
pub(super) type Matrix = [Vector; 3];

/// The rotation by an angle about coordinate axis `axis`. With
/// `i, j = axis + 1, axis + 2 (mod 3)` it takes `(xᵢ, xⱼ)` to
/// `(c xᵢ − s xⱼ, s xᵢ + c xⱼ)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    pub axis: usize,
    pub cos: ExprId,
    pub sin: ExprId,
}

impl Turn {
    fn plane(self) -> (usize, usize, usize) {
        ((self.axis + 1) % 3, (self.axis + 2) % 3, self.axis)
    }

    /// `c x − s y`
    fn minus(self, g: &mut Graph, x: ExprId, y: ExprId) -> ExprId {
        let (left, right) = (g.mul(self.cos, x), g.mul(self.sin, y));
        g.sub(left, right)
    }

    /// `s x + c y`
    fn plus(self, g: &mut Graph, x: ExprId, y: ExprId) -> ExprId {
        let (left, right) = (g.mul(self.sin, x), g.mul(self.cos, y));
        g.add(left, right)
    }

    /// `R x`: from the turned frame to the one before.
    pub fn up(self, g: &mut Graph, x: Vector) -> Vector {
        let (i, j, k) = self.plane();
        let mut y = x;
        y[i] = self.minus(g, x[i], x[j]);
        y[j] = self.plus(g, x[i], x[j]);
        y[k] = x[k];
        y
    }

    /// `Rᵀ x`: into the turned frame.
    pub fn down(self, g: &mut Graph, x: Vector) -> Vector {
        let (i, j, k) = self.plane();
        let mut y = x;
        y[i] = self.plus(g, x[j], x[i]);
        y[j] = self.minus(g, x[j], x[i]);
        y[k] = x[k];
        y
    }

    /// `R S Rᵀ` of a matrix. In the plane, with `w = c (sᵢᵢ − sⱼⱼ) − s (sᵢⱼ + sⱼᵢ)`:
    /// `sⱼⱼ + c w`, `sᵢᵢ − c w`, `sᵢⱼ + s w`, `sⱼᵢ + s w`. A symmetric matrix
    /// stays symmetric, node by node.
    pub fn up_matrix(self, g: &mut Graph, m: &Matrix) -> Matrix {
        let (i, j, k) = self.plane();
        let difference = g.sub(m[i][i], m[j][j]);
        let turned_difference = g.mul(self.cos, difference);
        let turned_mixed = if m[i][j] == m[j][i] {
            let twice = g.scale(2.0, self.sin);
            g.mul(twice, m[i][j])
        } else {
            let mixed = g.add(m[i][j], m[j][i]);
            g.mul(self.sin, mixed)
        };
        let w = g.sub(turned_difference, turned_mixed);
        let (cw, sw) = (g.mul(self.cos, w), g.mul(self.sin, w));
        let mut r = *m;
        r[i][i] = g.add(m[j][j], cw);
        r[j][j] = g.sub(m[i][i], cw);
        r[i][j] = g.add(m[i][j], sw);
        r[j][i] = g.add(m[j][i], sw);
        r[i][k] = self.minus(g, m[i][k], m[j][k]);
        r[j][k] = self.plus(g, m[i][k], m[j][k]);
        r[k][i] = self.minus(g, m[k][i], m[k][j]);
        r[k][j] = self.plus(g, m[k][i], m[k][j]);
        r
    }

    /// `B R` of a matrix given by its columns.
    pub fn turn_columns(self, g: &mut Graph, columns: &[Vector; 3]) -> [Vector; 3] {
        let (i, j, _) = self.plane();
        let mut turned = *columns;
        for row in 0..3 {
            let (x, y) = (columns[i][row], columns[j][row]);
            turned[i][row] = self.plus(g, y, x);
            turned[j][row] = self.minus(g, y, x);
        }
        turned
    }
}

/// `C = Rz(γ) Rx(α) Rz(ψ)`, as pairs of cosine and sine, with `cos γ ≥ 0`, so
/// that `γ` vanishes whenever it can.
pub(super) fn euler_zxz(c: &Rotation) -> [(f64, f64); 3] {
    let axis = [c[0][2], c[1][2], c[2][2]];
    let tilt = axis[0].hypot(axis[1]);
    let (gamma, sin_alpha) = if tilt == 0.0 {
        ((1.0, 0.0), 0.0)
    } else {
        let (cos, sin) = (-axis[1] / tilt, axis[0] / tilt);
        if cos < 0.0 || (cos == 0.0 && sin < 0.0) {
            ((-cos, -sin), -tilt)
        } else {
            ((cos, sin), tilt)
        }
    };
    let alpha = (axis[2], sin_alpha);
    // Rx(α)ᵀ Rz(γ)ᵀ C = Rz(ψ): its first column.
    let (x, y, z) = (c[0][0], c[1][0], c[2][0]);
    let across = gamma.0 * y - gamma.1 * x;
    let psi = (gamma.0 * x + gamma.1 * y, alpha.0 * across + alpha.1 * z);
    [gamma, alpha, psi].map(tidy_pair)
}

/// Cosine and sine of a sum of angles.
pub(super) fn compose(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// Removes round-off from a cosine–sine pair.
pub(super) fn tidy_pair((cos, sin): (f64, f64)) -> (f64, f64) {
    const ROUND_OFF: f64 = 1e-15;
    if sin.abs() < ROUND_OFF {
        (cos.signum(), 0.0)
    } else if cos.abs() < ROUND_OFF {
        (0.0, sin.signum())
    } else {
        (cos, sin)
    }
}

/// The turn by a constant angle, unless it is none.
pub(super) fn constant_turn(g: &mut Graph, axis: usize, (cos, sin): (f64, f64)) -> Option<Stage> {
    ((cos, sin) != (1.0, 0.0)).then(|| {
        Stage::Planar(Turn {
            axis,
            cos: g.constant(cos),
            sin: g.constant(sin),
        })
    })
}

/// One factor of a link's rotation.
#[derive(Debug, Clone, Copy)]
pub(super) enum Stage {
    /// About a coordinate axis.
    Planar(Turn),
    /// Any rotation, row by row (a quaternion's).
    General(Matrix),
}

/// `M x`
pub(super) fn times(g: &mut Graph, m: &Matrix, x: Vector) -> Vector {
    m.map(|row| vector::dot(g, row, x))
}

/// `Mᵀ`
pub(super) fn transpose(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// `R x` through a chain, `R = R₁ R₂ …`: from the last frame to the first.
pub(super) fn up(g: &mut Graph, stages: &[Stage], x: Vector) -> Vector {
    stages.iter().rev().fold(x, |x, stage| match stage {
        Stage::Planar(turn) => turn.up(g, x),
        Stage::General(m) => times(g, m, x),
    })
}

/// `Rᵀ x` through a chain: from the first frame to the last.
pub(super) fn down(g: &mut Graph, stages: &[Stage], x: Vector) -> Vector {
    stages.iter().fold(x, |x, stage| match stage {
        Stage::Planar(turn) => turn.down(g, x),
        Stage::General(m) => times(g, &transpose(m), x),
    })
}

/// `R M Rᵀ` through a chain.
pub(super) fn up_matrix(g: &mut Graph, stages: &[Stage], m: &Matrix) -> Matrix {
    stages.iter().rev().fold(*m, |m, stage| match stage {
        Stage::Planar(turn) => turn.up_matrix(g, &m),
        Stage::General(r) => {
            let right: Matrix = std::array::from_fn(|i| times(g, r, m[i]));
            let columns = transpose(&right).map(|column| times(g, r, column));
            transpose(&columns)
        }
    })
}

/// `B R` of a matrix given by its columns.
pub(super) fn turn_columns(g: &mut Graph, stages: &[Stage], columns: &[Vector; 3]) -> [Vector; 3] {
    stages.iter().fold(*columns, |columns, stage| match stage {
        Stage::Planar(turn) => turn.turn_columns(g, &columns),
        Stage::General(r) => {
            let rows = transpose(&columns);
            transpose(r).map(|column| times(g, &rows, column))
        }
    })
}

/// `R S Rᵀ` of a symmetric matrix for a constant rotation.
pub(super) fn rotate_symmetric(g: &mut Graph, r: &Rotation, s: &Matrix) -> Matrix {
    let right: Matrix = std::array::from_fn(|i| vector::rotate(g, r, s[i]));
    let columns = transpose(&right).map(|column| vector::rotate(g, r, column));
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j.max(i)][j.min(i)]))
}
