//! What can go wrong, where, and how to mend it.

/// Every error this crate returns.
///
/// User input never panics: shapes, non-finite numbers and unusable models end
/// here.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpError {
    /// Two shapes that must agree do not.
    #[error("{what}: expected {expected}, found {found}")]
    Shape {
        /// The quantity whose shape is wrong.
        what: String,
        /// The expected shape.
        expected: String,
        /// The shape that was given.
        found: String,
    },
    /// A value is NaN or infinite.
    #[error(
        "{what}: entry {index} is {value}; every number must be finite (drop the sample or mend the source)"
    )]
    NotFinite {
        /// The quantity that holds the value.
        what: String,
        /// Position of the first offending entry, counted from 0.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// A parameter has a value it must not have.
    #[error("parameter {name} = {value}: expected {expected}")]
    Parameter {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: String,
    },
    /// A parameter name matches nothing.
    #[error("no parameter is called `{name}`; the model has: {known}")]
    UnknownParameter {
        /// The name that was asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// The covariance matrix could not be factorised, even with jitter.
    #[error(
        "covariance matrix is not positive definite at row {row} (point {point}), even with jitter {jitter:e}; {}",
        coincidence(.coincident)
    )]
    NotPositiveDefinite {
        /// Row of the covariance matrix where the factorisation broke down.
        row: usize,
        /// Data point that row belongs to.
        point: usize,
        /// Largest jitter that was tried, absolute.
        jitter: f64,
        /// Pairs of data points whose inputs coincide.
        coincident: Vec<(usize, usize)>,
    },
    /// A constraint `A a = b` whose right-hand side no acceleration can meet.
    #[error(
        "constraint A a = b is inconsistent: residual {residual:e} of b outside the range of A exceeds {tolerance:e}; check the constraint rows that repeat one another"
    )]
    InconsistentConstraint {
        /// Norm of the part of `b` outside the range of `A`.
        residual: f64,
        /// The tolerance it was held against.
        tolerance: f64,
    },
    /// A matrix that must be invertible is not.
    #[error("{what} is singular; {mend}")]
    Singular {
        /// Which matrix.
        what: String,
        /// What to do about it.
        mend: String,
    },
    /// A user-supplied structure failed.
    #[error("structure at theta = {theta:?}: {message}")]
    Structure {
        /// The model parameters at which it failed.
        theta: Vec<f64>,
        /// Its own words.
        message: String,
    },
    /// No starting point of the optimiser gave a finite evidence.
    #[error(
        "training failed: none of the {starts} starting points could be evaluated; first error: {first}"
    )]
    Training {
        /// Number of starting points tried.
        starts: usize,
        /// What the first one said.
        first: String,
    },
    /// A saved model could not be read or written.
    #[error("saved model: {0}")]
    Saved(String),
}

fn coincidence(pairs: &[(usize, usize)]) -> String {
    if pairs.is_empty() {
        return "no two inputs coincide: raise the noise variance or its lower bound".into();
    }
    let list: Vec<String> = pairs.iter().map(|(i, j)| format!("{i} and {j}")).collect();
    format!(
        "data points {} have the same input: remove one of each or raise the noise variance",
        list.join(", ")
    )
}

/// Result with [`GpError`].
pub type Result<T> = std::result::Result<T, GpError>;

pub(crate) fn shape(
    what: impl Into<String>,
    expected: impl ToString,
    found: impl ToString,
) -> GpError {
    GpError::Shape {
        what: what.into(),
        expected: expected.to_string(),
        found: found.to_string(),
    }
}

/// Fail with the place of the first NaN or infinity.
pub(crate) fn finite(what: &str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(GpError::NotFinite {
            what: what.into(),
            index,
            value: values[index],
        }),
    }
}
