//! Least squares from products of whitened columns, with hold-out by blocks.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// The log is cut into this many runs for hold-out.
pub const BLOCKS: usize = 10;
/// Share of a column's squares that must lie outside a block and its neighbours for the
/// rest to say anything about the block.
const SHOWN_ELSEWHERE: f64 = 0.2;

/// `EᵀE` of the whitened rows `E = [data | columns]`, per block of the log.
#[derive(Debug, Clone)]
pub struct Gram {
    total: DMatrix<f64>,
    blocks: Vec<DMatrix<f64>>,
    readings: usize,
}

/// A least-squares fit of some columns to the data.
#[derive(Debug, Clone)]
pub struct Fit {
    /// One coefficient per column asked for.
    pub coefficients: DVector<f64>,
    /// Sum of squares that remains.
    pub misfit: f64,
    /// Inverse of the normal matrix: the coefficients' covariance for unit noise.
    pub covariance: DMatrix<f64>,
}

/// Sum of squares below which a column is round-off: constraints hide it.
pub const INVISIBLE: f64 = 1e-16;

/// Columns this collinear (in `1 − R²`) are fitted with a trace of damping.
const RIDGE: f64 = 1e-10;

impl Gram {
    /// From whitened rows and the blocks' row ranges; `readings` of them are a sensor's.
    pub fn new(rows: &DMatrix<f64>, blocks: &[Range<usize>], readings: usize) -> Self {
        let product = |range: &Range<usize>| product(rows, range.clone());
        let blocks: Vec<DMatrix<f64>> = blocks.par_iter().map(product).collect();
        let width = rows.ncols();
        let total = blocks
            .iter()
            .fold(DMatrix::zeros(width, width), |sum, block| sum + block);
        Self {
            total,
            blocks,
            readings,
        }
    }

    /// With further columns: `known` are the rows this was made of, `own` those of the
    /// new columns.
    #[must_use]
    pub fn extended(
        &self,
        known: &DMatrix<f64>,
        own: &DMatrix<f64>,
        blocks: &[Range<usize>],
    ) -> Self {
        let (old, more) = (known.ncols(), own.ncols());
        let blocks: Vec<DMatrix<f64>> = blocks
            .iter()
            .zip(&self.blocks)
            .map(|(range, block)| {
                let part = own.rows(range.start, range.len());
                let cross = known.rows(range.start, range.len()).tr_mul(&part);
                let mut wider = block.clone().resize(old + more, old + more, 0.0);
                wider.view_mut((0, old), (old, more)).copy_from(&cross);
                wider
                    .view_mut((old, 0), (more, old))
                    .copy_from(&cross.transpose());
                wider
                    .view_mut((old, old), (more, more))
                    .copy_from(&part.tr_mul(&part));
                wider
            })
            .collect();
        let width = old + more;
        Self {
            total: blocks
                .iter()
                .fold(DMatrix::zeros(width, width), |sum, block| sum + block),
            blocks,
            readings: self.readings,
        }
    }

    /// The same with some columns only, in this order.
    #[must_use]
    pub fn part(&self, columns: &[usize]) -> Self {
        let order: Vec<usize> = std::iter::once(0)
            .chain(columns.iter().map(|j| j + 1))
            .collect();
        let size = order.len();
        let cut =
            |gram: &DMatrix<f64>| DMatrix::from_fn(size, size, |i, j| gram[(order[i], order[j])]);
        Self {
            total: cut(&self.total),
            blocks: self.blocks.iter().map(cut).collect(),
            readings: self.readings,
        }
    }

    /// How many readings there were.
    pub fn readings(&self) -> usize {
        self.readings
    }

    /// Sum of squares of the data.
    pub fn data_misfit(&self) -> f64 {
        self.total[(0, 0)]
    }

    /// Sum of squares of column `j` (counted from zero, without the data).
    pub fn size(&self, j: usize) -> f64 {
        self.total[(j + 1, j + 1)]
    }

    /// Products of `columns` with each other (without the data).
    pub fn information(&self, columns: &[usize]) -> DMatrix<f64> {
        let size = columns.len();
        DMatrix::from_fn(size, size, |i, j| {
            self.total[(columns[i] + 1, columns[j] + 1)]
        })
    }

    /// The data with known multiples of columns put back: `data + Σ cⱼ columnⱼ`.
    #[must_use]
    pub fn with_data_shifted(&self, shift: &[(usize, f64)]) -> Self {
        let width = self.total.ncols();
        let mut change = DMatrix::identity(width, width);
        for &(j, c) in shift {
            change[(j + 1, 0)] = c;
        }
        let apply = |gram: &DMatrix<f64>| change.transpose() * gram * &change;
        Self {
            total: apply(&self.total),
            blocks: self.blocks.iter().map(apply).collect(),
            readings: self.readings,
        }
    }

    /// The same with what is believed beforehand of some coefficients: column, mean and standard
    /// deviation. Each is one more row, which belongs to no block.
    #[must_use]
    pub fn believing(&self, beliefs: &[(usize, f64, f64)]) -> Self {
        let mut gram = self.clone();
        for &(j, mean, sd) in beliefs {
            let weight = sd.powi(-2);
            gram.total[(0, 0)] += weight * mean * mean;
            gram.total[(0, j + 1)] += weight * mean;
            gram.total[(j + 1, 0)] += weight * mean;
            gram.total[(j + 1, j + 1)] += weight;
        }
        gram
    }

    /// The coefficients of a fit of `columns`, and the sum of squares that it leaves, where nothing else is asked of
    /// one: far cheaper than [`fit`](Self::fit).
    pub fn solved(&self, columns: &[usize]) -> (DVector<f64>, f64) {
        let Some(Normal {
            matrix,
            target,
            scale,
        }) = Normal::new(&self.total, columns, RIDGE)
        else {
            return (
                DVector::from_element(columns.len(), f64::NAN),
                f64::INFINITY,
            );
        };
        let Some(cholesky) = Cholesky::new(matrix) else {
            let Fit {
                coefficients,
                misfit,
                ..
            } = self.fit(columns);
            return (coefficients, misfit);
        };
        let coefficients = cholesky.solve(&target).component_mul(&scale);
        let left = misfit(&self.total, columns, &coefficients);
        (coefficients, left)
    }

    /// Least squares on `columns` (without the data).
    pub fn fit(&self, columns: &[usize]) -> Fit {
        fit(&self.total, columns, RIDGE)
    }

    /// The same held back from directions in which little is known, by `damping` times
    /// each column's own size (Levenberg, Marquardt).
    pub fn damped_fit(&self, columns: &[usize], damping: f64) -> Fit {
        fit(&self.total, columns, damping.max(RIDGE))
    }

    /// By how much the columns `more`, beside `base`, lower the squares of blocks that they
    /// were not fitted to. `None` where most of what they explain is in one place of the
    /// log (an input that reached its limit once): nothing can then be held out.
    pub fn held_out_gain(&self, base: &[usize], more: &[usize]) -> Option<f64> {
        let with = [base, more].concat();
        let whole = [base, &with].map(|columns| self.fit(columns).coefficients);
        let (mut gain, mut seen, mut all) = (0.0, 0.0, 0.0);
        for (held, block) in self.blocks.iter().enumerate() {
            let rest = self.without_neighbourhood(held);
            let [before, after] = [base, &with]
                .map(|columns| misfit(block, columns, &fit(&rest, columns, RIDGE).coefficients));
            gain += before - after;
            let own = misfit(block, base, &whole[0]) - misfit(block, &with, &whole[1]);
            let elsewhere = more.iter().map(|&j| rest[(j + 1, j + 1)] / self.size(j));
            let elsewhere = elsewhere.sum::<f64>() / more.len() as f64;
            all += own;
            if elsewhere > SHOWN_ELSEWHERE {
                seen += own;
            }
        }
        (seen >= 0.5 * all).then_some(gain)
    }

    /// Per block, the coefficients of all columns by what is outside it.
    pub fn fits_without_block(&self) -> Vec<DVector<f64>> {
        let columns: Vec<usize> = (0..self.total.ncols() - 1).collect();
        let rest = self.blocks.iter().map(|block| &self.total - block);
        rest.map(|rest| fit(&rest, &columns, RIDGE).coefficients)
            .collect()
    }

    /// What is left of the log when a block and its neighbours are held out.
    fn without_neighbourhood(&self, held: usize) -> DMatrix<f64> {
        let near = held.saturating_sub(1)..=(held + 1).min(self.blocks.len() - 1);
        near.fold(self.total.clone(), |rest, block| rest - &self.blocks[block])
    }

    /// Squared multiple correlation of column `j` with `others`.
    pub fn explained_by(&self, j: usize, others: &[usize]) -> f64 {
        let mut order: Vec<usize> = vec![j + 1];
        order.extend(others.iter().map(|o| o + 1));
        let size = order.len();
        let part = DMatrix::from_fn(size, size, |i, j| self.total[(order[i], order[j])]);
        let indices: Vec<usize> = (0..others.len()).collect();
        1.0 - fit(&part, &indices, RIDGE).misfit / self.size(j).max(f64::MIN_POSITIVE)
    }
}

/// `EᵀE` of some rows through faer, which is several times faster on tall matrices.
fn product(rows: &DMatrix<f64>, range: Range<usize>) -> DMatrix<f64> {
    let width = rows.ncols();
    let whole = MatRef::from_column_major_slice(rows.as_slice(), rows.nrows(), width);
    let part = whole.subrows(range.start, range.len());
    let mut lower = Mat::<f64>::zeros(width, width);
    matmul(
        &mut lower,
        BlockStructure::TriangularLower,
        Accum::Replace,
        part.transpose(),
        BlockStructure::Rectangular,
        part,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
    DMatrix::from_fn(width, width, |i, j| lower[(i.max(j), i.min(j))])
}

/// The normal equations of some columns.
struct Normal {
    /// Of unit columns: damping then means the same for all of them.
    matrix: DMatrix<f64>,
    target: DVector<f64>,
    /// One over each column's size; zero for one that is round-off.
    scale: DVector<f64>,
}

impl Normal {
    /// `None` where something is no finite number: the singular values of such a matrix would be searched for ever.
    fn new(gram: &DMatrix<f64>, columns: &[usize], damping: f64) -> Option<Self> {
        let p = columns.len();
        let at = |i: usize| columns[i] + 1;
        let scale = DVector::from_fn(p, |i, _| {
            let size = gram[(at(i), at(i))].sqrt();
            if size > INVISIBLE.sqrt() {
                1.0 / size
            } else {
                0.0
            }
        });
        let mut matrix = DMatrix::from_fn(p, p, |i, j| gram[(at(i), at(j))] * scale[i] * scale[j]);
        for i in 0..p {
            matrix[(i, i)] += damping;
        }
        let target = DVector::from_fn(p, |i, _| gram[(at(i), 0)] * scale[i]);
        let is_finite = matrix.iter().chain(target.iter()).all(|x| x.is_finite());
        is_finite.then_some(Self {
            matrix,
            target,
            scale,
        })
    }
}

fn fit(gram: &DMatrix<f64>, columns: &[usize], damping: f64) -> Fit {
    let p = columns.len();
    if p == 0 {
        let misfit = gram[(0, 0)];
        return Fit {
            coefficients: DVector::zeros(0),
            misfit,
            covariance: DMatrix::zeros(0, 0),
        };
    }
    let Some(Normal {
        matrix,
        target,
        scale,
    }) = Normal::new(gram, columns, damping)
    else {
        return Fit {
            coefficients: DVector::from_element(p, f64::NAN),
            misfit: f64::INFINITY,
            covariance: DMatrix::from_element(p, p, f64::NAN),
        };
    };
    let inverse = match Cholesky::new(matrix.clone()) {
        Some(cholesky) => cholesky.inverse(),
        None => matrix
            .pseudo_inverse(1e-12)
            .unwrap_or_else(|_| DMatrix::zeros(p, p)),
    };
    let coefficients = (&inverse * target).component_mul(&scale);
    let covariance = DMatrix::from_fn(p, p, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    let misfit = misfit(gram, columns, &coefficients);
    Fit {
        coefficients,
        misfit,
        covariance,
    }
}

/// `‖data − Σ cⱼ columnⱼ‖²`
fn misfit(gram: &DMatrix<f64>, columns: &[usize], coefficients: &DVector<f64>) -> f64 {
    let mut total = gram[(0, 0)];
    for (i, &a) in columns.iter().enumerate() {
        total -= 2.0 * coefficients[i] * gram[(a + 1, 0)];
        for (j, &b) in columns.iter().enumerate() {
            total += coefficients[i] * coefficients[j] * gram[(a + 1, b + 1)];
        }
    }
    // Not a number stays infinite: it explains nothing.
    if total.is_nan() {
        f64::INFINITY
    } else {
        total.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two columns that are one, and of a column that is nothing, too.
    #[test]
    fn what_is_solved_is_what_is_fitted() {
        let rows = DMatrix::from_fn(40, 5, |row, column| {
            let x = 0.3 * row as f64;
            [x.sin() + 0.1 * x, x, x.sin(), 2.0 * x, 0.0][column]
        });
        let gram = Gram::new(&rows, &[0..20, 20..40], 40);
        for columns in [&[0_usize, 1][..], &[0, 1, 2], &[0, 3], &[]] {
            let (coefficients, misfit) = gram.solved(columns);
            let fit = gram.fit(columns);
            assert!(
                (coefficients - fit.coefficients).amax() < 1e-6,
                "{columns:?}"
            );
            assert!((misfit - fit.misfit).abs() < 1e-9, "{columns:?}");
        }
        let (_, left) = gram.solved(&[0]);
        assert!((left - gram.fit(&[0]).misfit).abs() < 1e-12 && left > 0.1);
    }
}
