//! Weighted least squares with a prior on inertias, and honest standard errors.

use super::columns::Columns;
use super::equations::{Block, Equations};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Estimated corrections, one per column; zero where a column is not in use.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub values: Vec<f64>,
    /// Standard errors from how the blocks disagree and from the curvature, the larger.
    pub std: Vec<f64>,
    /// Standard deviations of the posterior.
    pub posterior: Vec<f64>,
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
}

impl Normal {
    pub fn new<'a>(
        columns: &Columns,
        used: &[usize],
        blocks: impl Iterator<Item = &'a Block>,
        news: f64,
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
        Self { gram, moment }
    }

    /// The solution; columns that say nothing get zero.
    pub fn solve(&self) -> Option<(DVector<f64>, Cholesky<f64, nalgebra::Dyn>)> {
        let mut gram = self.gram.clone();
        let diagonal = gram.diagonal();
        for i in 0..gram.nrows() {
            // Relative to the column's own size: units differ by orders of magnitude.
            gram[(i, i)] += (1e-12 * diagonal[i]).max(f64::MIN_POSITIVE.sqrt());
        }
        let cholesky = gram.cholesky()?;
        Some((cholesky.solve(&self.moment), cholesky))
    }
}

/// The estimate with these groups.
pub(super) fn estimate(
    columns: &Columns,
    equations: &Equations,
    groups: &[usize],
    inertias: bool,
) -> Estimate {
    let used = in_use(columns, groups, inertias);
    let normal = Normal::new(columns, &used, equations.blocks.iter(), equations.news);
    let mut result = Estimate {
        values: vec![0.0; columns.count()],
        std: vec![f64::INFINITY; columns.count()],
        posterior: vec![f64::INFINITY; columns.count()],
        determined: 0,
    };
    let Some((x, cholesky)) = normal.solve() else {
        return result;
    };
    let inverse = cholesky.inverse();
    let spread = spread(equations, &used, &x, &inverse);
    for (i, &column) in used.iter().enumerate() {
        result.values[column] = x[i];
        result.posterior[column] = inverse[(i, i)].sqrt();
        result.std[column] = inverse[(i, i)].max(spread[(i, i)]).sqrt();
    }
    if inertias {
        result.determined = determined(columns, &inverse);
    }
    result
}

/// The sandwich `G⁻¹ (Σ s_b s_bᵀ) G⁻¹` with the score `s_b` of each block: right
/// whatever follows what within a block.
fn spread(
    equations: &Equations,
    used: &[usize],
    x: &DVector<f64>,
    inverse: &DMatrix<f64>,
) -> DMatrix<f64> {
    let size = used.len();
    let mut meat = DMatrix::zeros(size, size);
    for block in &equations.blocks {
        let score = DVector::from_fn(size, |i, _| {
            let predicted: f64 = used
                .iter()
                .enumerate()
                .map(|(j, &b)| block.gram[(used[i], b)] * x[j])
                .sum();
            equations.news * (block.moment[used[i]] - predicted)
        });
        meat += &score * score.transpose();
    }
    inverse * meat * inverse
}

/// Directions in which the posterior's variance is at most half the prior's.
fn determined(columns: &Columns, inverse: &DMatrix<f64>) -> usize {
    let m = columns.inertial;
    if m == 0 {
        return 0;
    }
    let relative = DMatrix::from_fn(m, m, |i, j| {
        inverse[(i, j)] / (columns.prior[i] * columns.prior[j])
    });
    let values = relative.symmetric_eigenvalues();
    values.iter().filter(|&&x| x <= 0.5).count()
}
