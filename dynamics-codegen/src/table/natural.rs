//! The natural cubic spline through points on a line.

/// Weights of the functions of [`basis`](super::basis): the value at the first point, the slope in
/// front of it, and the second derivative at every point between the ends.
pub(super) fn weights(points: &[f64], values: &[f64]) -> Vec<f64> {
    let curvature = curvature(points, values);
    let (h, rise) = (points[1] - points[0], values[1] - values[0]);
    // The first cubic's slope at the first point, where its curvature is zero.
    let slope = rise / h - h * curvature.first().unwrap_or(&0.0) / 6.0;
    [&[values[0], slope], &curvature[..]].concat()
}

/// Second derivatives at the points between the ends, by elimination from a tridiagonal system
/// that is diagonally dominant: slopes agree at every point.
fn curvature(points: &[f64], values: &[f64]) -> Vec<f64> {
    let steps: Vec<f64> = points.windows(2).map(|p| p[1] - p[0]).collect();
    let rises = values.windows(2).zip(&steps);
    let slopes: Vec<f64> = rises.map(|(v, h)| (v[1] - v[0]) / h).collect();
    let inner = steps.len() - 1;
    let (mut diagonal, mut right) = (Vec::with_capacity(inner), Vec::with_capacity(inner));
    for i in 0..inner {
        let mut own = 2.0 * (steps[i] + steps[i + 1]);
        let mut due = 6.0 * (slopes[i + 1] - slopes[i]);
        if i > 0 {
            let factor = steps[i] / diagonal[i - 1];
            own -= factor * steps[i];
            due -= factor * right[i - 1];
        }
        diagonal.push(own);
        right.push(due);
    }
    let mut curvature = vec![0.0; inner];
    for i in (0..inner).rev() {
        let behind = curvature.get(i + 1).map_or(0.0, |next| steps[i + 1] * next);
        curvature[i] = (right[i] - behind) / diagonal[i];
    }
    curvature
}
