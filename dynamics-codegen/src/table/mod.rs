//! Look-up tables as smooth functions.
//!
//! Through the points goes a natural cubic spline: of all curves through them the one that bends
//! least (`∫ f″²`). Its curvature is zero at the ends, so that it goes on straight beyond them and is
//! twice continuously differentiable everywhere: forces that a potential gives are smooth, and
//! their derivatives are continuous. Over a grid it is the product of two of them.
//!
//! `f″` of such a spline is a broken line, a sum of hats. So the spline is a straight line plus
//! hats that were integrated twice, each a cubic between three neighbouring points, zero in
//! front of them and straight behind. With `min` and `max` these are expressions like any
//! others: without a search or a branch, so that all back ends have them, dual numbers and lanes
//! among them. They cost about 14 operations a point.

mod basis;
mod natural;

use crate::graph::{ExprId, Graph};
use natural::weights;

/// A function of one or two arguments through given points.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    /// Per argument where it is known, in increasing order.
    axes: Vec<Vec<f64>>,
    /// By the functions of the first axis, then by those of the second.
    weights: Vec<f64>,
}

impl Spline {
    /// The spline through the values at all points of a grid, the last axis fastest. Every
    /// axis has two points or more, in increasing order.
    ///
    /// # Panics
    /// If there is not one value per point.
    pub fn through(axes: Vec<Vec<f64>>, values: &[f64]) -> Self {
        let points: usize = axes.iter().map(Vec::len).product();
        assert_eq!(points, values.len(), "one value per point");
        let mut weights_so_far = values.to_vec();
        let mut stride = 1;
        for axis in axes.iter().rev() {
            weights_so_far = along(axis, stride, &weights_so_far);
            stride *= axis.len();
        }
        Self {
            axes,
            weights: weights_so_far,
        }
    }

    /// Whether all that it is made of is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.weights.iter().all(|weight| weight.is_finite())
    }

    /// Whether it has no bend: then it is a line, or a product of two, like many others.
    pub(crate) fn is_straight(&self) -> bool {
        let inner = self.axes.last().map_or(1, Vec::len);
        let mut weights = self.weights.iter().enumerate();
        weights.all(|(index, &weight)| {
            let (row, column) = (index / inner, index % inner);
            let straight = column < 2 && (self.axes.len() < 2 || row < 2);
            straight || weight == 0.0
        })
    }

    /// The spline as an expression of its arguments, one per axis.
    pub fn express(&self, graph: &mut Graph, arguments: &[ExprId]) -> ExprId {
        let mut values: Vec<ExprId> = self.weights.iter().map(|w| graph.constant(*w)).collect();
        for (axis, &argument) in self.axes.iter().zip(arguments).rev() {
            let basis = basis::functions(graph, axis, argument);
            values = values
                .chunks(basis.len())
                .map(|weights| {
                    let terms = weights.iter().zip(&basis);
                    let terms: Vec<ExprId> = terms.map(|(&w, &f)| graph.mul(w, f)).collect();
                    graph.sum(terms)
                })
                .collect();
        }
        values[0]
    }
}

/// Values along one axis replaced by weights of its functions. Neighbours are `stride` apart.
fn along(axis: &[f64], stride: usize, values: &[f64]) -> Vec<f64> {
    let count = axis.len();
    let mut out = vec![0.0; values.len()];
    for block in 0..values.len() / (count * stride) {
        for offset in 0..stride {
            let at = |i: usize| (block * count + i) * stride + offset;
            let line: Vec<f64> = (0..count).map(|i| values[at(i)]).collect();
            for (i, weight) in weights(axis, &line).into_iter().enumerate() {
                out[at(i)] = weight;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests;
