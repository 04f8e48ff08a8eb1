//! From a log to the named effects that the model lacks.

mod dictionary;
mod estimate;
mod finding;
mod patch;
mod refine;
mod run;
mod score;
mod select;

pub use dictionary::{Candidate, Dictionary, Subject};
pub use estimate::Observed;
pub use finding::{Finding, ParameterEstimate, Rival, Verdict};
pub use patch::patch;
pub use run::{Outcome, Request, Split, TraceError, trace};
pub use score::{Errors, RolloutErrors, Score};
pub use select::{Considered, SMALLEST_SHARE, Selection, Term, likelier_hold, select};
