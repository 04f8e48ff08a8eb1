//! Why an integration stopped.

use core::fmt;

/// Error of [`DormandPrince`](super::DormandPrince); `E` is that of the right-hand side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum IntegrationError<E> {
    /// The right-hand side failed.
    Rate {
        /// Time of the call, s.
        t: f64,
        /// Its error.
        source: E,
    },
    /// A number that describes the task is out of its range.
    Argument {
        /// Which one.
        name: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        value: f64,
    },
    /// The state or its rate is NaN or infinite, however small the step.
    NotFinite {
        /// Last time with a finite state, s.
        t: f64,
    },
    /// The tolerance demands a step below the resolution of time.
    StepUnderflow {
        /// Time reached, s.
        t: f64,
        /// Step, s.
        step: f64,
    },
    /// More steps than allowed.
    TooManySteps {
        /// Time reached, s.
        t: f64,
        /// The limit.
        limit: usize,
    },
}

impl<E: fmt::Display> fmt::Display for IntegrationError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rate { t, source } => write!(f, "at t = {t} s: {source}"),
            Self::Argument {
                name,
                expected,
                value,
            } => {
                write!(f, "{name} is {value}; it must be {expected}")
            }
            Self::NotFinite { t } => write!(
                f,
                "the state becomes NaN or infinite just after t = {t} s: check the model for a \
                 division by zero or a root of a negative number, and the inputs for NaN"
            ),
            Self::StepUnderflow { t, step } => write!(
                f,
                "at t = {t} s the step fell to {step:e} s, below the resolution of time: the \
                 tolerance is too tight, or the right-hand side jumps or is stiff there (smooth \
                 the jump, or integrate up to it and go on behind it)"
            ),
            Self::TooManySteps { t, limit } => write!(
                f,
                "{limit} steps reached only t = {t} s: loosen the tolerance, raise the limit, or \
                 remove stiffness (large stabilisation or friction rates)"
            ),
        }
    }
}

impl<E: core::error::Error + 'static> core::error::Error for IntegrationError<E> {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Rate { source, .. } => Some(source),
            _ => None,
        }
    }
}
