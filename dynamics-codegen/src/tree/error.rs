//! What can be wrong with a tree.

use thiserror::Error;

/// A tree that has no equations of motion. A reader of robot descriptions finds
/// these first and says the line; this is the last line of defence.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TreeError {
    /// A parent that is not listed before its child.
    #[error(
        "body `{body}` names parent {parent}, which is not listed before it; list parents first"
    )]
    Order {
        /// The child.
        body: String,
        /// The parent's index.
        parent: usize,
    },
    /// A direction without direction.
    #[error("the joint axis of body `{body}` is {axis:?}; it must be finite and not zero")]
    Axis {
        /// The body that the joint carries.
        body: String,
        /// As given.
        axis: [f64; 3],
    },
    /// Not a rotation.
    #[error(
        "the placement of body `{body}` is not a rotation (RᵀR differs from 1 by {error:.1e}, \
         determinant {determinant:.3}); orthonormalise it"
    )]
    Rotation {
        /// The body.
        body: String,
        /// The largest entry of `RᵀR − 1`.
        error: f64,
        /// Of the matrix as given.
        determinant: f64,
    },
    /// A coordinate that does not exist.
    #[error("body `{body}` uses coordinate {index}, but the tree has {coordinates}")]
    Coordinate {
        /// The body.
        body: String,
        /// As given.
        index: usize,
        /// How many there are.
        coordinates: usize,
    },
    /// A ratio that is no number, or zero.
    #[error(
        "body `{body}` moves {ratio} times as far as its coordinate; it must be finite and not zero"
    )]
    Ratio {
        /// The body.
        body: String,
        /// As given.
        ratio: f64,
    },
    /// More than straight-line code can be useful for.
    #[error("the tree has {coordinates} coordinates; at most {most} are supported")]
    TooLarge {
        /// How many there are.
        coordinates: usize,
        /// How many there may be.
        most: usize,
    },
    /// More frames that move than the recursions can go through in a breath.
    #[error("the tree has {joints} joints and frames that move; at most {most} are supported")]
    TooManyJoints {
        /// How many there are.
        joints: usize,
        /// How many there may be.
        most: usize,
    },
    /// A constant that is not finite.
    #[error("body `{body}` has a {what} that is not a finite number")]
    NotFinite {
        /// The body.
        body: String,
        /// Which of its properties.
        what: &'static str,
    },
}
