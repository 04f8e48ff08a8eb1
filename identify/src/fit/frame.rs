//! Directions that no multiplier reaches, the same from place to place [4.36, 4.37].
//!
//! `ε_u = ((I − A⁺A) J_u)⁺ (I − A⁺A)(M a − Q)` wants a `J_u` whose columns span `N(A)`. A
//! basis by singular vectors would turn and flip as the machine moves, and no function of
//! the state could be learnt in it. Here `N = I − A⁺A` is applied to a constant frame `E`,
//! the mean null space along the log, and made orthonormal the shortest way (Löwdin):
//! `J_u = N E ((N E)ᵀ N E)^(−½)`, smooth wherever `EᵀN E` is regular. Then
//! `ε_u = J_uᵀ (M a − Q)`.

use nalgebra::{DMatrix, DVector};

/// The constant frame `E`, `n×k`.
#[derive(Debug, Clone)]
pub(super) struct Frame(DMatrix<f64>);

/// Eigenvalues below this share of the largest count as zero.
const TOLERANCE: f64 = 1e-10;

impl Frame {
    /// The mean null space of constraint matrices (each `m×n`).
    pub fn new<'a>(n: usize, matrices: impl Iterator<Item = &'a DMatrix<f64>>) -> Self {
        let (mut mean, mut count, mut widest) = (DMatrix::zeros(n, n), 0, 0);
        for a in matrices {
            let projector = projector(a);
            widest = widest.max(projector.trace().round() as usize);
            mean += projector;
            count += 1;
        }
        if widest == n || count == 0 {
            return Self(DMatrix::identity(n, n));
        }
        let eigen = mean.symmetric_eigen();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        let mut frame = DMatrix::from_fn(n, widest, |i, k| eigen.eigenvectors[(i, order[k])]);
        for mut column in frame.column_iter_mut() {
            // Eigenvectors have no sign: the largest entry is positive.
            if column[column.iamax()] < 0.0 {
                column.neg_mut();
            }
        }
        Self(frame)
    }

    /// How many directions.
    pub fn width(&self) -> usize {
        self.0.ncols()
    }

    /// A name for each direction: the coordinate that it moves most.
    pub fn names(&self, coordinates: &[String]) -> Vec<String> {
        let name = |(k, column): (usize, nalgebra::DVectorView<'_, f64>)| {
            let most = coordinates.get(column.iamax()).map_or("", String::as_str);
            match self.width() == coordinates.len() {
                true => most.to_string(),
                false => format!("direction {} (mostly {most})", k + 1),
            }
        };
        self.0.column_iter().enumerate().map(name).collect()
    }

    /// `J_u` where the constraints' matrix is `a`: `n×k`, orthonormal columns that span
    /// `N(A)`; a direction that the constraints forbid here is zero.
    pub fn at(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let seen = projector(a) * &self.0;
        let eigen = seen.tr_mul(&seen).symmetric_eigen();
        let root = eigen.eigenvalues.map(|x| match x > TOLERANCE {
            true => x.sqrt().recip(),
            false => 0.0,
        });
        let vectors = &eigen.eigenvectors;
        seen * vectors * DMatrix::from_diagonal(&root) * vectors.transpose()
    }
}

/// `N = I − A⁺A`, `n×n`.
pub(super) fn projector(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.ncols();
    let mut projector = DMatrix::identity(n, n);
    if a.nrows() == 0 {
        return projector;
    }
    let eigen = a.tr_mul(a).symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    for (k, &value) in eigen.eigenvalues.iter().enumerate() {
        if value > TOLERANCE * largest {
            let v: DVector<f64> = eigen.eigenvectors.column(k).into_owned();
            projector -= &v * v.transpose();
        }
    }
    projector
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// The columns are orthonormal, obey the constraint, and do not jump.
    #[test]
    fn the_basis_is_orthonormal_and_smooth() {
        let slope = |x: f64| dmatrix![0.4 * x, (2.0 * x).cos(), -1.0];
        let all: Vec<_> = (0..200).map(|k| slope(0.01 * f64::from(k) - 1.0)).collect();
        let frame = Frame::new(3, all.iter());
        assert_eq!(frame.width(), 2);
        let mut last: Option<DMatrix<f64>> = None;
        for a in &all {
            let basis = frame.at(a);
            assert!((a * &basis).amax() < 1e-12);
            assert!((basis.tr_mul(&basis) - DMatrix::identity(2, 2)).amax() < 1e-12);
            if let Some(last) = last {
                assert!((&basis - last).amax() < 0.05);
            }
            last = Some(basis);
        }
    }

    /// [4.37] as printed gives the same as `J_uᵀ`, and `J_u ε_u` moves the machine as the
    /// whole force does.
    #[test]
    fn it_is_the_residual_of_the_thesis() {
        let a = dmatrix![0.3, -0.2, -1.0];
        let frame = Frame::new(3, std::iter::once(&a));
        let basis = frame.at(&a);
        let force = nalgebra::dvector![1.0, -2.0, 0.5];
        let n = projector(&a);
        let inverse = (&n * &basis).pseudo_inverse(1e-12).expect("finite");
        let printed = inverse * &n * &force;
        assert!((basis.tr_mul(&force) - printed).amax() < 1e-12);
        let left = &force - &basis * basis.tr_mul(&force);
        assert!((n * left).amax() < 1e-12, "only multipliers feel the rest");
    }

    #[test]
    fn without_constraints_it_is_the_identity() {
        let none = DMatrix::zeros(0, 2);
        let frame = Frame::new(2, std::iter::once(&none));
        assert!((frame.at(&none) - DMatrix::identity(2, 2)).amax() < 1e-14);
    }
}
