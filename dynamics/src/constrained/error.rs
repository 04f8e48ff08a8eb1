//! What can be wrong with a constrained equation of motion.

use core::fmt;

use nalgebra::SMatrix;

use crate::Real;

/// A quantity of the equation of motion, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// `M`.
    Mass,
    /// `Qbar`.
    Force,
    /// `A`.
    Constraint,
    /// `b`.
    ConstraintRate,
    /// `a`.
    Acceleration,
    /// `λ`.
    Multiplier,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mass => "mass matrix M",
            Self::Force => "generalised force Qbar",
            Self::Constraint => "constraint Jacobian A",
            Self::ConstraintRate => "constraint right-hand side b",
            Self::Acceleration => "acceleration a",
            Self::Multiplier => "multiplier lambda",
        })
    }
}

/// Why no acceleration could be found. Rows and columns count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolveError {
    /// An element is NaN or infinite.
    NotFinite {
        /// Where.
        quantity: Quantity,
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// `M` differs from its transpose.
    UnsymmetricMass {
        /// Row of the worse element.
        row: usize,
        /// Column of the worse element.
        column: usize,
        /// `|M_ij − M_ji|`.
        difference: f64,
    },
    /// `M` has a negative eigenvalue.
    IndefiniteMass {
        /// Coordinate at which a pivot is negative.
        coordinate: usize,
    },
    /// `rank [M; A] < n`: some motion has neither inertia nor constraint.
    Undetermined {
        /// Coordinate that moves in that motion.
        coordinate: usize,
    },
    /// `b` is outside the range of `A`.
    Inconsistent {
        /// Constraint row with the largest contradiction.
        row: usize,
        /// Contradiction in that row, in the unit of `b`.
        residual: f64,
        /// Numerical rank of `A`.
        rank: usize,
        /// Number of rows.
        rows: usize,
    },
    /// A force depends on multipliers, and no consistent value of them was found.
    Unsettled {
        /// A constraint row whose multiplier does not come to rest.
        row: usize,
    },
}

impl fmt::Display for SolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite {
                quantity,
                row,
                column,
            } => write!(
                f,
                "the {quantity} is not a finite number at row {row}, column {column}: \
                 check the state, the inputs and the parameters for NaN, infinity or a division by zero"
            ),
            Self::UnsymmetricMass {
                row,
                column,
                difference,
            } => write!(
                f,
                "the mass matrix M is not symmetric: elements ({row}, {column}) and \
                 ({column}, {row}) differ by {difference:e}; M must equal its transpose"
            ),
            Self::IndefiniteMass { coordinate } => write!(
                f,
                "the mass matrix M has negative inertia (seen at coordinate {coordinate}): \
                 kinetic energy must not be negative; check the masses and inertias"
            ),
            Self::Undetermined { coordinate } => write!(
                f,
                "the acceleration is not determined: a motion of coordinate {coordinate} has \
                 neither inertia nor a constraint (rank of [M; A] is below the number of \
                 coordinates); give it inertia or constrain it"
            ),
            Self::Inconsistent {
                row,
                residual,
                rank,
                rows,
            } => write!(
                f,
                "the constraints contradict each other: {rows} rows have rank {rank} and row \
                 {row} misses its right-hand side by {residual:e}; remove the contradicting \
                 constraint, or start from a state that fulfils all of them"
            ),
            Self::Unsettled { row } => write!(
                f,
                "the friction of the contact at constraint row {row} finds no balance with the \
                 force that it comes from: with this much friction the contact jams or has \
                 several motions; lower the coefficient of friction"
            ),
        }
    }
}

impl core::error::Error for SolveError {}

/// Checks every element.
pub(super) fn finite<T: Real, const R: usize, const C: usize>(
    quantity: Quantity,
    m: &SMatrix<T, R, C>,
) -> Result<(), SolveError> {
    for column in 0..C {
        for row in 0..R {
            if !m[(row, column)].is_finite() {
                return Err(SolveError::NotFinite {
                    quantity,
                    row,
                    column,
                });
            }
        }
    }
    Ok(())
}
