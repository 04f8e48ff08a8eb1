//! From a log to the named effects that the model lacks.

mod dictionary;
mod estimate;
mod refine;
mod select;

pub use dictionary::{Candidate, Dictionary, Subject};
pub use estimate::Observed;
pub use select::{Considered, Selection, Term, select};
