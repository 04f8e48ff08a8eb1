//! Inverses that constrained dynamics need: of a singular `M`, of a rank-deficient `G`.

use super::dense::Dense;
use super::{CONSISTENCY_TOLERANCE, PIVOT_TOLERANCE, RANK_TOLERANCE};
use crate::error::{GpError, Result};
use faer::{Mat, Side};

pub(super) fn singular_mass() -> GpError {
    GpError::Singular {
        what: "M".into(),
        mend: "the unconstrained acceleration does not exist; ask for another quantity".into(),
    }
}

/// `(M + s A^T A)⁻¹` and `s`.
pub(super) fn stiffened(mass: &Dense, a: &Dense) -> Result<(Dense, f64)> {
    let gram = &a.t() * a;
    let s = mass.trace().abs().max(f64::MIN_POSITIVE) / gram.trace().max(f64::MIN_POSITIVE);
    let stiff = mass.clone() + &gram.scaled(s);
    let inverse = stiff.inverse_spd(PIVOT_TOLERANCE).ok_or_else(|| GpError::Singular {
        what: "M stacked on A".into(),
        mend: "the acceleration is not determined: M must be positive definite on the null space of A".into(),
    })?;
    Ok((inverse, s))
}

/// Moore–Penrose inverse of a symmetric positive semi-definite matrix, and its rank.
pub(super) fn pseudo_inverse(g: &Dense) -> Result<(Dense, usize)> {
    let m = g.rows;
    if let Some(inverse) = g.inverse_spd(RANK_TOLERANCE) {
        return Ok((inverse, m));
    }
    let full = Mat::from_fn(m, m, |i, j| g.at(i, j));
    let eigen = full
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| GpError::Singular {
            what: "A M⁻¹ A^T".into(),
            mend: "its eigenvalues did not converge; check the scales of M and A".into(),
        })?;
    let (u, values) = (eigen.U(), eigen.S().column_vector());
    let largest = (0..m).map(|i| values[i].abs()).fold(0.0, f64::max);
    let kept: Vec<usize> = (0..m)
        .filter(|&i| values[i] > RANK_TOLERANCE * largest)
        .collect();
    let mut out = Dense::zeros(m, m);
    for i in 0..m {
        for j in 0..m {
            out.v[i * m + j] = kept
                .iter()
                .map(|&k| u[(i, k)] * u[(j, k)] / values[k])
                .sum();
        }
    }
    Ok((out, kept.len()))
}

pub(super) fn consistent(g: &Dense, gamma: &Dense, b: &Dense) -> Result<()> {
    let residual = (b.clone() - &(g * &(gamma * b))).norm();
    let tolerance = CONSISTENCY_TOLERANCE * (1.0 + b.norm());
    if residual > tolerance {
        return Err(GpError::InconsistentConstraint {
            residual,
            tolerance,
        });
    }
    Ok(())
}
