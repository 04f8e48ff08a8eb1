//! Three-vectors of expressions, and three-by-three matrices of numbers.

use crate::graph::{ExprId, Graph};

/// Three expressions.
pub(super) type Vector = [ExprId; 3];
/// A constant rotation, row by row.
pub(super) type Rotation = [[f64; 3]; 3];

pub(super) const IDENTITY: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub(super) fn zero(g: &mut Graph) -> Vector {
    [g.zero(); 3]
}

pub(super) fn constant(g: &mut Graph, v: [f64; 3]) -> Vector {
    v.map(|x| g.constant(x))
}

/// The numbers, if all three are constant.
pub(super) fn as_numbers(g: &Graph, v: Vector) -> Option<[f64; 3]> {
    Some([
        g.as_constant(v[0])?,
        g.as_constant(v[1])?,
        g.as_constant(v[2])?,
    ])
}

pub(super) fn add(g: &mut Graph, x: Vector, y: Vector) -> Vector {
    std::array::from_fn(|i| g.add(x[i], y[i]))
}

pub(super) fn sub(g: &mut Graph, x: Vector, y: Vector) -> Vector {
    std::array::from_fn(|i| g.sub(x[i], y[i]))
}

pub(super) fn neg(g: &mut Graph, x: Vector) -> Vector {
    x.map(|x| g.neg(x))
}

/// `k x`
pub(super) fn scale(g: &mut Graph, k: ExprId, x: Vector) -> Vector {
    x.map(|x| g.mul(k, x))
}

/// `x · y`
pub(super) fn dot(g: &mut Graph, x: Vector, y: Vector) -> ExprId {
    g.inner_product(&x, &y)
}

/// `x × y`
pub(super) fn cross(g: &mut Graph, x: Vector, y: Vector) -> Vector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (left, right) = (g.mul(x[j], y[k]), g.mul(x[k], y[j]));
        g.sub(left, right)
    })
}

/// `R x` for a constant `R`.
pub(super) fn rotate(g: &mut Graph, r: &Rotation, x: Vector) -> Vector {
    std::array::from_fn(|i| {
        let mut total = g.zero();
        for j in 0..3 {
            let term = g.scale(r[i][j], x[j]);
            total = g.add(total, term);
        }
        total
    })
}

/// `A B`
pub(super) fn product(a: &Rotation, b: &Rotation) -> Rotation {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `Aᵀ`
pub(super) fn transpose(a: &Rotation) -> Rotation {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// `A x`
pub(super) fn apply(a: &Rotation, x: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| inner(a[i], x))
}

/// `x · y` of numbers.
pub(super) fn inner(x: [f64; 3], y: [f64; 3]) -> f64 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// `a × b` of numbers.
pub(super) fn crossed(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
