//! What inputs do between samples, which no log has.
//!
//! A controller faster than the log moves its inputs on between the rows that it was logged at: as an input bends
//! from row to row, so it may leave what is drawn between them. Where a controller is switched on far from its
//! goal it rings, and what acted in these intervals is not known; everywhere else it is.

use crate::log::longest_step;
use crate::machine::States;
use nalgebra::{DMatrix, DVector};

/// How much each input bends at an interval, one column per interval: the root mean square of the changes of its
/// step at both ends, in its unit.
pub(super) fn bends(curve: &States) -> DMatrix<f64> {
    let longest = longest_step(&curve.t);
    let is_step = |k: usize| curve.t[k + 1] - curve.t[k] <= longest;
    let intervals = curve.len() - 1;
    DMatrix::from_fn(curve.u.len(), intervals, |input, k| {
        let u = &curve.u[input];
        let bend = |at: usize| {
            let is_inside = at > 0 && at < intervals && is_step(at - 1) && is_step(at);
            is_inside.then(|| u[at + 1] - 2.0 * u[at] + u[at - 1])
        };
        let each = [bend(k), bend(k + 1)].into_iter().flatten();
        let (count, squares) = each.fold((0.0, 0.0), |(n, sum), d| (n + 1.0, sum + d * d));
        match count > 0.0 {
            true => f64::sqrt(squares / count),
            false => 0.0,
        }
    })
}

/// What inputs that bend by so much, `b`, exert on each coordinate, as a standard deviation in its force unit:
/// `√Σⱼ (Bᵢⱼ bⱼ)²`. An input that drives several coordinates is taken for one of each.
pub(super) fn forces(input_matrix: &DMatrix<f64>, bends: &[f64]) -> DVector<f64> {
    DVector::from_fn(input_matrix.nrows(), |i, _| {
        let each = bends.iter().enumerate();
        let squares = each.map(|(j, bend)| (input_matrix[(i, j)] * bend).powi(2));
        squares.sum::<f64>().sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_straight_bends_nowhere_and_a_corner_in_its_intervals_only() {
        let curve = States {
            t: (0..8).map(f64::from).collect(),
            u: vec![vec![0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0]],
            ..States::default()
        };
        let found = bends(&curve);
        let root = f64::sqrt(0.5);
        assert_eq!(found.as_slice(), [0.0, 0.0, root, root, 0.0, 0.0, 0.0]);
        let both = DMatrix::from_column_slice(2, 1, &[2.0, 0.0]);
        assert_eq!(forces(&both, &[0.5]).as_slice(), [1.0, 0.0]);
    }
}
