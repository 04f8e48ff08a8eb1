//! The functions that natural cubic splines over given points are made of.

use crate::graph::{Binary, ExprId, Graph};

/// `1`, `x - x₀`, and for every point between the ends its hat (the broken line that is one at the
/// point and zero at all others) integrated twice from the left.
pub(super) fn functions(graph: &mut Graph, points: &[f64], x: ExprId) -> Vec<ExprId> {
    let first = graph.constant(points[0]);
    let mut functions = vec![graph.one(), graph.sub(x, first)];
    for place in points.windows(3) {
        functions.push(hat(graph, [place[0], place[1], place[2]], x));
    }
    functions
}

/// The hat over three points, integrated twice.
///
/// Derivatives of `min` and `max` are one-sided where both arguments are equal. At the last
/// point the cubic stops as the straight line begins, since both hold the same `min`; at the others
/// everything that changes sides is zero with its first and second derivative.
fn hat(graph: &mut Graph, [a, b, c]: [f64; 3], x: ExprId) -> ExprId {
    let (left, right) = (b - a, c - b);
    let [a, b, c] = [a, b, c].map(|point| graph.constant(point));
    let zero = graph.zero();
    let until = graph.binary(Binary::Min, x, c);
    let behind = |graph: &mut Graph, point: ExprId| {
        let distance = graph.sub(until, point);
        graph.binary(Binary::Max, distance, zero)
    };
    let (from_a, from_b) = (behind(graph, a), behind(graph, b));
    let (rising, turning) = (graph.powi(from_a, 3), graph.powi(from_b, 3));
    let rising = graph.scale(1.0 / (6.0 * left), rising);
    let turning = graph.scale((1.0 / left + 1.0 / right) / 6.0, turning);
    let cubic = graph.sub(rising, turning);
    // The area of the hat is the slope from there on.
    let beyond = graph.sub(x, until);
    let straight = graph.scale((left + right) / 2.0, beyond);
    graph.add(cubic, straight)
}
