//! Linear equations `missing = Σ columns · strengths`, whitened per coordinate.

use super::balance::Forces;
use crate::log::{rms, share_of_news};
use crate::regression::{BLOCKS, Gram, INVISIBLE};
use nalgebra::{DMatrix, DVector, DVectorViewMut};
use std::ops::Range;

/// The equations along a log, one row per kept sample and coordinate.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// `[missing | columns]` in units of the scale, samples outside, coordinates inside.
    rows: DMatrix<f64>,
    /// Per coordinate: root mean square of what the columns are thought to leave.
    scale: Vec<f64>,
    /// Effective over actual number of equations per coordinate: errors follow one another.
    news: Vec<f64>,
}

impl Equations {
    /// In units of what is missing.
    pub fn new(missing: &Forces, columns: &[Forces]) -> Self {
        let (n, samples) = (missing.len(), missing.first().map_or(0, Vec::len));
        let scale: Vec<f64> = missing.iter().map(|force| positive(rms(force))).collect();
        let mut rows = DMatrix::zeros(n * samples, 1 + columns.len());
        let all = std::iter::once(missing).chain(columns);
        for (forces, column) in all.zip(rows.column_iter_mut()) {
            write(forces, |i| 1.0 / scale[i], column);
        }
        Self {
            rows,
            news: vec![1.0; scale.len()],
            scale,
        }
    }

    /// Per coordinate, root mean square of what the columns are thought to leave.
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Products of rows, block by block.
    pub fn gram(&self) -> Gram {
        self.gram_of_rows(&self.rows)
    }

    /// The same of some columns.
    pub fn gram_of(&self, columns: &[usize]) -> Gram {
        let all = std::iter::once(0).chain(columns.iter().map(|column| column + 1));
        self.gram_of_rows(&self.rows.select_columns(&all.collect::<Vec<usize>>()))
    }

    fn gram_of_rows(&self, rows: &DMatrix<f64>) -> Gram {
        Gram::new(rows, &self.blocks(), rows.nrows())
    }

    /// The blocks, in rows.
    fn blocks(&self) -> Vec<Range<usize>> {
        let n = self.scale.len();
        let range = |samples: Range<usize>| n * samples.start..n * samples.end;
        (0..BLOCKS).map(|b| range(self.block(b))).collect()
    }

    /// The equations with `further` columns behind theirs, in the same units, and the products of all: those of their
    /// own are in `gram`.
    pub fn extended(&self, gram: &Gram, further: &[Forces]) -> (Self, Gram) {
        let (old, rows) = (self.rows.ncols(), self.rows.nrows());
        let mut own = DMatrix::zeros(rows, further.len());
        for (forces, column) in further.iter().zip(own.column_iter_mut()) {
            write(forces, |i| self.news[i].sqrt() / self.scale[i], column);
        }
        let gram = gram.extended(&self.rows, &own, &self.blocks());
        let mut wider = self.clone();
        wider.rows = wider.rows.resize_horizontally(old + further.len(), 0.0);
        wider.rows.columns_mut(old, further.len()).copy_from(&own);
        (wider, gram)
    }

    /// Number of equations that say something of their own.
    pub fn effective(&self) -> f64 {
        let mean = self.news.iter().sum::<f64>() / self.news.len().max(1) as f64;
        (self.rows.nrows() as f64 * mean).max(1.0)
    }

    /// Takes scale and memory of the errors from what `columns` with `strengths` leave.
    pub fn reweigh(&mut self, columns: &[usize], strengths: &[f64]) {
        let left = self.errors(0..self.samples(), columns, strengths);
        let n = self.scale.len();
        let mut factors = Vec::with_capacity(n);
        for i in 0..n {
            let own: Vec<f64> = left.iter().skip(i).step_by(n).copied().collect();
            let news = share_of_news(&own);
            let size = positive(rms(&own));
            factors.push(news.sqrt() / size);
            self.scale[i] *= size / self.news[i].sqrt();
            self.news[i] = news;
        }
        self.multiply(&factors);
    }

    /// Multiplies the equations of each coordinate by a factor.
    fn multiply(&mut self, factors: &[f64]) {
        for mut column in self.rows.column_iter_mut() {
            let each = column.iter_mut().zip(factors.iter().cycle());
            each.for_each(|(entry, factor)| *entry *= factor);
        }
    }

    /// Other forces and columns of the same log in the same units.
    pub fn alike(&self, missing: &Forces, columns: &[Forces]) -> Self {
        let mut other = Self::new(missing, columns);
        let factor = |i: usize| self.news[i].sqrt() * other.scale[i] / self.scale[i];
        let factors: Vec<f64> = (0..self.scale.len()).map(factor).collect();
        other.multiply(&factors);
        other.scale.clone_from(&self.scale);
        other.news.clone_from(&self.news);
        other
    }

    /// Squares left per coordinate by `columns`, with their strengths on all samples.
    pub fn left(&self, columns: &[usize], strengths: &[f64]) -> Vec<f64> {
        self.left_of(0..self.samples(), columns, strengths)
    }

    /// The same of blocks that the strengths were not fitted to.
    pub fn held_out(&self, gram: &Gram, columns: &[usize]) -> Vec<f64> {
        let part = gram.part(columns);
        let mut left = vec![0.0; self.scale.len()];
        for (block, strengths) in part.fits_without_block().iter().enumerate() {
            let of = self.left_of(self.block(block), columns, strengths.as_slice());
            left.iter_mut().zip(of).for_each(|(sum, more)| *sum += more);
        }
        left
    }

    fn left_of(&self, samples: Range<usize>, columns: &[usize], strengths: &[f64]) -> Vec<f64> {
        let (n, left) = (self.scale.len(), self.errors(samples, columns, strengths));
        let squares = |i: usize| left.iter().skip(i).step_by(n).map(|x| x * x).sum();
        (0..n).map(squares).collect()
    }

    /// What `columns` with these strengths leave of some samples, coordinates inside.
    fn errors(&self, samples: Range<usize>, columns: &[usize], strengths: &[f64]) -> DVector<f64> {
        let n = self.scale.len();
        let rows = n * samples.start..n * samples.end;
        let part = |column: usize| {
            let whole = self.rows.column(column);
            whole.rows_range(rows.clone()).into_owned()
        };
        let mut left = part(0);
        for (&column, &strength) in columns.iter().zip(strengths) {
            left.axpy(-strength, &part(column + 1), 1.0);
        }
        left
    }

    fn samples(&self) -> usize {
        self.rows.nrows() / self.scale.len().max(1)
    }

    /// The samples of a block.
    fn block(&self, index: usize) -> Range<usize> {
        let bound = |block: usize| block * self.samples() / BLOCKS;
        bound(index)..bound(index + 1)
    }

    /// Per column, whether it shows in more than a few places of the log: in at least
    /// [`SHOWN`] of the samples, counted by how evenly its squares are spread
    /// (`(Σx²)²/Σx⁴`).
    pub fn visible(&self) -> Vec<bool> {
        let shown = |column: usize| {
            let x = self.rows.column(column);
            let squares: f64 = x.iter().map(|x| x * x).sum();
            let fourth: f64 = x.iter().map(|x| x.powi(4)).sum();
            squares > INVISIBLE && squares * squares > SHOWN * self.samples() as f64 * fourth
        };
        (1..self.rows.ncols()).map(shown).collect()
    }
}

/// Writes forces to a column, samples outside and coordinates inside, those of each coordinate times a factor.
fn write(forces: &Forces, factor: impl Fn(usize) -> f64, mut column: DVectorViewMut<'_, f64>) {
    let n = forces.len();
    for (i, force) in forces.iter().enumerate() {
        let factor = factor(i);
        for (k, value) in force.iter().enumerate() {
            column[k * n + i] = factor * value;
        }
    }
}

/// See [`Equations::visible`].
const SHOWN: f64 = 0.02;

fn positive(x: f64) -> f64 {
    x.max(f64::MIN_POSITIVE.sqrt())
}
