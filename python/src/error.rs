//! What goes wrong, as exceptions.

use cli::mistake::Mistake;
use pyo3::PyErr;
use pyo3::exceptions::{PyRuntimeError, PyValueError};

pyo3::create_exception!(
    dynamics,
    Error,
    PyValueError,
    "Something that you can mend: a model, a log, an argument. The message says the place, what \
     was expected, and how to mend it."
);
pyo3::create_exception!(
    dynamics,
    SolveError,
    Error,
    "The equation of motion has no unique solution at a state. The message says which state of \
     the batch, counted from 0 in C order, and why."
);

/// A mistake of the user's with its place.
pub fn mistaken(mistake: &Mistake) -> PyErr {
    Error::new_err(mistake.render(false))
}

/// A state without a unique motion.
pub fn unsolved(error: identify::machine::SolveError) -> PyErr {
    SolveError::new_err(error.to_string())
}

/// What the command line's own parts return: the user's mistake, or an internal failure.
pub fn raised(error: &anyhow::Error) -> PyErr {
    match error.downcast_ref::<Mistake>() {
        Some(mistake) => mistaken(mistake),
        None => PyRuntimeError::new_err(format!("internal failure: {error:#}")),
    }
}
