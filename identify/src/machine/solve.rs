//! The constrained solve for sizes known at run time (Udwadia–Kalaba, thesis 3.38–3.42).

use super::Terms;
use nalgebra::{Cholesky, DMatrix, Dyn};

/// Why a state has no unique motion. `sample` counts from zero.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// `rank [M; A] < n`.
    #[error(
        "sample {sample}: the mass matrix is singular and the constraints do not make up for it; \
         give every coordinate some inertia"
    )]
    Singular {
        /// Which state.
        sample: usize,
    },
    /// `M` has a negative eigenvalue, and the constraints leave room for that motion.
    #[error(
        "sample {sample}: the mass matrix is not positive definite: some motion of coordinate \
         {coordinate} (counted from 0) has negative kinetic energy; correct the masses and inertias"
    )]
    Indefinite {
        /// Which state.
        sample: usize,
        /// A coordinate that moves in that motion.
        coordinate: usize,
    },
    /// `b ∉ R(A)`.
    #[error(
        "sample {sample}: the constraints contradict each other (off by {miss:.3e} on acceleration \
         level); drop or correct one of them"
    )]
    Inconsistent {
        /// Which state.
        sample: usize,
        /// `max |A a − b|`.
        miss: f64,
    },
    /// Forces and what they depend on (multipliers, internal states) find no balance.
    #[error(
        "sample {sample}: the forces do not settle: no consistent value of the multipliers or states \
         that they depend on was found; check friction coefficients and rates"
    )]
    Unsettled {
        /// Which state.
        sample: usize,
    },
    /// No motion keeps a contact out of all planes: two of them meet where it is.
    #[error(
        "sample {sample}: no motion keeps the contacts out of all planes; make room between planes \
         that touch the same body from two sides"
    )]
    Pinched {
        /// Which state.
        sample: usize,
    },
    /// An acceleration is not a number.
    #[error("sample {sample}: the acceleration is not finite; check parameters and state")]
    NotFinite {
        /// Which state.
        sample: usize,
    },
}

impl SolveError {
    /// Which state.
    pub fn sample(self) -> usize {
        let (Self::Singular { sample }
        | Self::Indefinite { sample, .. }
        | Self::Inconsistent { sample, .. }
        | Self::Unsettled { sample }
        | Self::Pinched { sample }
        | Self::NotFinite { sample }) = self;
        sample
    }

    /// The same, counted from further back.
    #[must_use]
    pub fn offset(self, by: usize) -> Self {
        self.renumbered(|sample| sample + by)
    }

    /// The same, with the sample counted in another way.
    #[must_use]
    pub(crate) fn renumbered(mut self, number: impl Fn(usize) -> usize) -> Self {
        match &mut self {
            Self::Singular { sample }
            | Self::Indefinite { sample, .. }
            | Self::Inconsistent { sample, .. }
            | Self::Unsettled { sample }
            | Self::Pinched { sample }
            | Self::NotFinite { sample } => {
                *sample = number(*sample);
            }
        }
        self
    }
}

/// Eigenvalues of `G = A M⁻¹ Aᵀ` below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-11;

/// `K = [[M, Aᵀ + Q′], [A, 0]]`, factorised; `Q′ = ∂Q/∂λ` is null but for contact friction.
#[derive(Debug, Clone)]
pub struct Factorisation {
    /// Of `M`, or of `M + α² AᵀA` where `M` is singular [3.49–3.54].
    inertia: Cholesky<f64, Dyn>,
    /// `α²`; zero where `M` is regular.
    penalty: f64,
    constraint: DMatrix<f64>,
    /// `M⁻¹ (Aᵀ + Q′)`, `n×m`.
    compliance: DMatrix<f64>,
    /// `G⁺`, `m×m`.
    inverse: DMatrix<f64>,
}

impl Factorisation {
    /// Factorises. `sample` is what an error calls the state.
    pub(super) fn new(terms: &Terms, sample: usize) -> Result<Self, SolveError> {
        Self::of(
            &terms.mass_matrix,
            &terms.constraint_matrix,
            &terms.multiplier_slope,
            sample,
        )
    }

    /// `slope` is `Q′`, or has no column.
    fn of(
        mass_matrix: &DMatrix<f64>,
        constraint: &DMatrix<f64>,
        slope: &DMatrix<f64>,
        sample: usize,
    ) -> Result<Self, SolveError> {
        if mass_matrix
            .iter()
            .chain(constraint.iter())
            .chain(slope.iter())
            .any(|x| !x.is_finite())
        {
            return Err(SolveError::NotFinite { sample });
        }
        let (inertia, penalty) = factorise_inertia(mass_matrix, constraint)
            .ok_or_else(|| without_motion(mass_matrix, sample))?;
        let mut compliance = constraint.transpose();
        if slope.ncols() > 0 {
            compliance += slope;
        }
        inertia.solve_mut(&mut compliance);
        let gram = constraint * &compliance;
        // The eigenvalue iteration would not end on these.
        if gram.iter().any(|x| !x.is_finite()) {
            return Err(SolveError::NotFinite { sample });
        }
        let inverse = if slope.iter().any(|&x| x != 0.0) {
            let plain = constraint * inertia.solve(&constraint.transpose());
            contact_inverse(&gram, &plain).ok_or(SolveError::Unsettled { sample })?
        } else {
            pseudo_inverse(&gram)
        };
        Ok(Self {
            inertia,
            penalty,
            constraint: constraint.clone(),
            compliance,
            inverse,
        })
    }

    /// Solves `M a = Q + Aᵀλ`, `A a = b` for columns of `Q` (`n×r`) and `b` (`m×r`).
    pub fn solve(&self, force: DMatrix<f64>, bias: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let mut acceleration = force;
        if self.penalty > 0.0 {
            acceleration += self.constraint.transpose() * bias * self.penalty;
        }
        solve_columns(&self.inertia, &mut acceleration);
        if self.constraint.nrows() == 0 {
            let width = acceleration.ncols();
            return (acceleration, DMatrix::zeros(0, width));
        }
        let multiplier = &self.inverse * (bias - &self.constraint * &acceleration);
        acceleration += &self.compliance * &multiplier;
        (acceleration, multiplier)
    }

    /// `P = M⁻¹ − M⁻¹ Aᵀ G⁺ A M⁻¹`, `n×n`: what a force does to the acceleration.
    pub fn mobility(&self) -> DMatrix<f64> {
        let n = self.compliance.nrows();
        self.solve(
            DMatrix::identity(n, n),
            &DMatrix::zeros(self.constraint.nrows(), n),
        )
        .0
    }
}

/// Machines with more coordinates are left to the library, which sums longer columns in another order.
const SMALL: usize = 8;

/// `columns ← M⁻¹ columns`, with `M = L Lᵀ`. Of matrices as small as a machine's, a general solve would spend its
/// time on views of their columns. In the order of the library, so that no bit differs.
fn solve_columns(inertia: &Cholesky<f64, Dyn>, columns: &mut DMatrix<f64>) {
    let lower = inertia.l_dirty();
    let n = lower.nrows();
    if n > SMALL {
        inertia.solve_mut(columns);
        return;
    }
    let column = |j: usize| (lower[(j, j)], &lower.as_slice()[j * n..][j + 1..n]);
    for j in 0..n {
        let (pivot, below) = column(j);
        for x in columns.as_mut_slice().chunks_exact_mut(n) {
            x[j] /= pivot;
            let value = x[j];
            let rest = x[j + 1..].iter_mut().zip(below);
            rest.for_each(|(x, l)| *x -= l * value);
        }
    }
    for j in (0..n).rev() {
        let (pivot, below) = column(j);
        for x in columns.as_mut_slice().chunks_exact_mut(n) {
            let known = x[j + 1..].iter().zip(below).map(|(x, l)| l * x);
            x[j] = (x[j] - known.sum::<f64>()) / pivot;
        }
    }
}

fn factorise_inertia(
    mass_matrix: &DMatrix<f64>,
    constraint: &DMatrix<f64>,
) -> Option<(Cholesky<f64, Dyn>, f64)> {
    let scale = mass_matrix.diagonal().amax();
    let regular = |cholesky: &Cholesky<f64, Dyn>| {
        let pivot = cholesky.l_dirty().diagonal().amin();
        pivot * pivot > 1e-13 * scale
    };
    if let Some(cholesky) = Cholesky::new(mass_matrix.clone()).filter(regular) {
        return Some((cholesky, 0.0));
    }
    let gram = constraint.transpose() * constraint;
    let size = gram.diagonal().amax();
    if size == 0.0 || size.is_nan() {
        return None;
    }
    let penalty = if scale > 0.0 { scale / size } else { 1.0 };
    let cholesky = Cholesky::new(mass_matrix + gram * penalty)?;
    regular(&cholesky).then_some((cholesky, penalty))
}

/// A negative eigenvalue of `M` counts from this share of the largest absolute one.
const NEGATIVE_SHARE: f64 = 1e-9;

/// Why a mass matrix cannot be factorised: it is indefinite, or else singular.
fn without_motion(mass_matrix: &DMatrix<f64>, sample: usize) -> SolveError {
    let eigen = mass_matrix.clone().symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    if eigen.eigenvalues[least] >= -NEGATIVE_SHARE * eigen.eigenvalues.amax() {
        return SolveError::Singular { sample };
    }
    let coordinate = eigen.eigenvectors.column(least).iamax();
    SolveError::Indefinite { sample, coordinate }
}

/// Of `A M⁻¹ (Aᵀ + Q′)`, which is not symmetric; `None` where friction makes it singular
/// that is not so without (`plain`).
fn contact_inverse(matrix: &DMatrix<f64>, plain: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let rank = |matrix: &DMatrix<f64>| {
        let svd = matrix.clone().svd(true, true);
        let largest = svd.singular_values.amax();
        (svd.rank(RANK_TOLERANCE * largest), svd, largest)
    };
    let (wanted, _, scale) = rank(plain);
    let (found, svd, largest) = rank(matrix);
    if found < wanted || largest < RANK_TOLERANCE * scale {
        return None;
    }
    svd.pseudo_inverse(RANK_TOLERANCE * largest).ok()
}

/// Of a symmetric positive semidefinite matrix.
fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    if matrix.nrows() == 0 {
        return matrix.clone();
    }
    let symmetric = (matrix + matrix.transpose()) * 0.5;
    let eigen = symmetric.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let inverse = eigen.eigenvalues.map(|x| {
        if x > RANK_TOLERANCE * largest {
            1.0 / x
        } else {
            0.0
        }
    });
    let mut scaled = eigen.eigenvectors.clone();
    for (mut column, &factor) in scaled.column_iter_mut().zip(inverse.iter()) {
        column *= factor;
    }
    scaled * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn columns_are_solved_as_the_library_solves_them() {
        for n in 1..=SMALL + 1 {
            let root = DMatrix::from_fn(n, n, |i, j| (1.0 + 3.0 * i as f64 + j as f64).sin());
            let mass = &root * root.transpose() + DMatrix::identity(n, n);
            let inertia = Cholesky::new(mass).unwrap();
            let given = DMatrix::from_fn(n, 5, |i, j| (i as f64 - 2.0 * j as f64).cos());
            let mut solved = given.clone();
            solve_columns(&inertia, &mut solved);
            assert_eq!(solved, inertia.solve(&given));
        }
    }

    #[test]
    fn a_doubled_constraint_changes_nothing() {
        let m = dmatrix![2.0, 0.3; 0.3, 1.0];
        let none = DMatrix::zeros(2, 0);
        let single = Factorisation::of(&m, &dmatrix![1.0, 2.0], &none, 0).unwrap();
        let double = Factorisation::of(&m, &dmatrix![1.0, 2.0; 1.0, 2.0], &none, 0).unwrap();
        let q = dmatrix![1.0; -3.0];
        let (a, _) = single.solve(q.clone(), &dmatrix![0.7]);
        let (b, _) = double.solve(q, &dmatrix![0.7; 0.7]);
        assert!((a - b).amax() < 1e-12);
    }

    #[test]
    fn a_singular_mass_matrix_is_carried_by_the_constraint() {
        // Second coordinate massless, tied to the first: a2 = a1, m a1 = Q1 + Q2.
        let none = DMatrix::zeros(2, 0);
        let mass = dmatrix![2.0, 0.0; 0.0, 0.0];
        let f = Factorisation::of(&mass, &dmatrix![1.0, -1.0], &none, 0).unwrap();
        let (a, lambda) = f.solve(dmatrix![3.0; 1.0], &dmatrix![0.0]);
        assert!((a[0] - 2.0).abs() < 1e-12 && (a[1] - 2.0).abs() < 1e-12);
        // 0·a2 = Q2 − λ
        assert!((lambda[0] - 1.0).abs() < 1e-12);
        assert_eq!(
            Factorisation::of(&mass, &dmatrix![1.0, 0.0], &none, 4).unwrap_err(),
            SolveError::Singular { sample: 4 }
        );
    }

    #[test]
    fn a_negative_mass_is_not_called_singular() {
        let (none, free) = (DMatrix::zeros(2, 0), DMatrix::zeros(0, 2));
        let error = |mass: DMatrix<f64>| Factorisation::of(&mass, &free, &none, 3).unwrap_err();
        let negative = SolveError::Indefinite {
            sample: 3,
            coordinate: 1,
        };
        assert_eq!(error(dmatrix![2.0, 0.0; 0.0, -1.0]), negative);
        let crossed = error(dmatrix![1.0, 2.0; 2.0, 1.0]);
        assert!(matches!(crossed, SolveError::Indefinite { .. }));
        // A product of velocities alone: neither coordinate has inertia of its own.
        let saddle = error(dmatrix![0.0, 1.0; 1.0, 0.0]);
        assert!(matches!(saddle, SolveError::Indefinite { .. }));
        let singular = SolveError::Singular { sample: 3 };
        assert_eq!(error(dmatrix![1.0, 1.0; 1.0, 1.0]), singular);
        assert_eq!(error(dmatrix![0.0, 0.0; 0.0, 0.0]), singular);
    }
}
