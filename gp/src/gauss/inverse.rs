//! Inverses that constrained dynamics need: of a singular `M`, of a rank-deficient `G`.

use super::{CONSISTENCY_TOLERANCE, RANK_TOLERANCE};
use crate::error::{GpError, Result};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

pub(super) fn singular_mass() -> GpError {
    GpError::Singular {
        what: "M".into(),
        mend: "the unconstrained acceleration does not exist; ask for another quantity".into(),
    }
}

/// `(M + s A^T A)⁻¹` and `s`.
pub(super) fn stiffened(mass: &Mat<f64>, a: &Mat<f64>) -> Result<(Mat<f64>, f64)> {
    let n = mass.nrows();
    let gram = a.transpose() * a;
    let trace = |m: &Mat<f64>| (0..n).map(|i| m[(i, i)]).sum::<f64>();
    let s = trace(mass).abs().max(f64::MIN_POSITIVE) / trace(&gram).max(f64::MIN_POSITIVE);
    let stiff = mass + gram * faer::Scale(s);
    let factor = stiff.llt(Side::Lower).map_err(|_| GpError::Singular {
        what: "M stacked on A".into(),
        mend:
            "the acceleration is not determined: M must be positive definite on the null space of A"
                .into(),
    })?;
    Ok((factor.solve(Mat::<f64>::identity(n, n)), s))
}

/// Moore–Penrose inverse of a symmetric positive semi-definite matrix, and its rank.
pub(super) fn pseudo_inverse(g: &Mat<f64>) -> Result<(Mat<f64>, usize)> {
    let m = g.nrows();
    if m == 0 {
        return Ok((Mat::zeros(0, 0), 0));
    }
    let eigen = g
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| GpError::Singular {
            what: "A M⁻¹ A^T".into(),
            mend: "its eigenvalues did not converge; check the scales of M and A".into(),
        })?;
    let values = eigen.S().column_vector();
    let largest = (0..m).map(|i| values[i].abs()).fold(0.0, f64::max);
    let keep = |i: usize| values[i] > RANK_TOLERANCE * largest;
    let rank = (0..m).filter(|&i| keep(i)).count();
    if rank == m
        && let Ok(c) = g.llt(Side::Lower)
    {
        return Ok((c.solve(Mat::<f64>::identity(m, m)), m));
    }
    let u = eigen.U();
    let scaled = Mat::from_fn(
        m,
        m,
        |i, j| if keep(j) { u[(i, j)] / values[j] } else { 0.0 },
    );
    Ok((scaled * u.transpose(), rank))
}

pub(super) fn consistent(g: &Mat<f64>, gamma: &Mat<f64>, b: &Mat<f64>) -> Result<()> {
    let residual = (b - g * (gamma * b)).norm_l2();
    let tolerance = CONSISTENCY_TOLERANCE * (1.0 + b.norm_l2());
    if residual > tolerance {
        return Err(GpError::InconsistentConstraint {
            residual,
            tolerance,
        });
    }
    Ok(())
}
