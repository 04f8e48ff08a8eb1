//! Weighted least squares with a prior on inertias, signs that nature gives, and honest standard
//! errors.

use super::columns::Columns;
use super::equations::{Block, Equations};
use super::signs::{Bounded, bounded};
use nalgebra::{DMatrix, DVector};

/// Whether coefficients that are zero or more by their nature are held to that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Signs {
    /// They are: what is reported, and what predicts.
    Kept,
    /// They are not: what the log would have if it could.
    Free,
}

/// Estimated corrections, one per column; zero where a column is not in use.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub values: Vec<f64>,
    /// Standard errors from how the blocks disagree and from the curvature, the larger; not a
    /// number where a coefficient is held at zero, infinite where a column is not in use.
    pub std: Vec<f64>,
    /// Combinations of inertias whose variance the log has at least halved.
    pub determined: usize,
}

/// The columns in use: those of the groups, behind the inertial ones if these are free.
pub(super) fn in_use(columns: &Columns, groups: &[usize], inertias: bool) -> Vec<usize> {
    let mut used: Vec<usize> = (0..columns.inertial).filter(|_| inertias).collect();
    used.extend(
        groups
            .iter()
            .flat_map(|&g| columns.groups[g].columns.clone()),
    );
    used
}

/// The normal equations of some blocks in some columns, with the prior.
pub(super) struct Normal {
    pub gram: DMatrix<f64>,
    pub moment: DVector<f64>,
    /// Whether each coefficient is held to zero or more.
    signed: Vec<bool>,
}

impl Normal {
    pub fn new<'a>(
        columns: &Columns,
        used: &[usize],
        blocks: impl Iterator<Item = &'a Block>,
        news: f64,
        signs: Signs,
    ) -> Self {
        let size = used.len();
        let (mut gram, mut moment) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for block in blocks {
            for (i, &a) in used.iter().enumerate() {
                moment[i] += news * block.moment[a];
                for (j, &b) in used.iter().enumerate() {
                    gram[(i, j)] += news * block.gram[(a, b)];
                }
            }
        }
        for (i, &column) in used
            .iter()
            .enumerate()
            .filter(|(_, c)| **c < columns.inertial)
        {
            gram[(i, i)] += columns.prior[column].powi(-2);
        }
        let all = columns.signed();
        let signed = used.iter().map(|&c| signs == Signs::Kept && all[c]);
        Self {
            gram,
            moment,
            signed: signed.collect(),
        }
    }

    /// The solution within the signs; columns that say nothing get zero.
    pub fn solve(&self) -> Option<Bounded> {
        let mut gram = self.gram.clone();
        let diagonal = gram.diagonal();
        for i in 0..gram.nrows() {
            // Relative to the column's own size: units differ by orders of magnitude.
            gram[(i, i)] += (1e-12 * diagonal[i]).max(f64::MIN_POSITIVE.sqrt());
        }
        bounded(&gram, &self.moment, &self.signed)
    }
}

/// The estimate with these groups.
pub(super) fn estimate(
    columns: &Columns,
    equations: &Equations,
    groups: &[usize],
    inertias: bool,
    signs: Signs,
) -> Estimate {
    let used = in_use(columns, groups, inertias);
    let blocks = equations.blocks.iter();
    let normal = Normal::new(columns, &used, blocks, equations.news, signs);
    let mut result = Estimate {
        values: vec![0.0; columns.count()],
        std: vec![f64::INFINITY; columns.count()],
        determined: 0,
    };
    let Some(Bounded { x, free, cholesky }) = normal.solve() else {
        return result;
    };
    for (i, &column) in used.iter().enumerate() {
        result.values[column] = x[i];
        result.std[column] = f64::NAN;
    }
    // What is held at zero is known no better or worse than the law that holds it.
    let inverse = cholesky.inverse();
    let spread = spread(equations, &used, &x, &free, &inverse);
    for (i, &k) in free.iter().enumerate() {
        result.std[used[k]] = inverse[(i, i)].max(spread[(i, i)]).sqrt();
    }
    if inertias {
        let counts = [&inverse, &spread].map(|variance| determined(columns, variance));
        result.determined = counts[0].min(counts[1]);
    }
    result
}

/// The sandwich `G⁻¹ (Σ s_b s_bᵀ) G⁻¹` with the score `s_b` of each block in the `free` of the
/// columns in use: right whatever follows what within a block.
fn spread(
    equations: &Equations,
    used: &[usize],
    x: &DVector<f64>,
    free: &[usize],
    inverse: &DMatrix<f64>,
) -> DMatrix<f64> {
    let size = free.len();
    let mut meat = DMatrix::zeros(size, size);
    for block in &equations.blocks {
        let score = DVector::from_fn(size, |i, _| {
            let predicted: f64 = used
                .iter()
                .enumerate()
                .map(|(j, &b)| block.gram[(used[free[i]], b)] * x[j])
                .sum();
            equations.news * (block.moment[used[free[i]]] - predicted)
        });
        meat += &score * score.transpose();
    }
    inverse * meat * inverse
}

/// Directions of the inertias, which come first, in which a variance is at most half the prior's.
fn determined(columns: &Columns, variance: &DMatrix<f64>) -> usize {
    let m = columns.inertial;
    if m == 0 {
        return 0;
    }
    let relative = DMatrix::from_fn(m, m, |i, j| {
        variance[(i, j)] / (columns.prior[i] * columns.prior[j])
    });
    let values = relative.symmetric_eigenvalues();
    values.iter().filter(|&&x| x <= 0.5).count()
}
