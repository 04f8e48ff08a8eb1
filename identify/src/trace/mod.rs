//! From a log to the named effects that the model lacks.

mod command;
mod corrected;
mod dictionary;
mod error;
mod estimate;
mod finding;
mod focus;
mod forces;
mod judge;
mod microscope;
mod one_clock;
mod patch;
mod progress;
mod refine;
mod rivals;
mod run;
mod score;
mod screen;
mod select;
mod series;

pub use dictionary::{Candidate, Dictionary, Ranges, Subject};
pub use error::TraceError;
pub use estimate::Observed;
pub use finding::{Finding, ParameterEstimate, Rival, Verdict};
pub use focus::Focus;
pub use microscope::{Dependence, Tried, Unnamed, UnnamedForce};
pub use patch::patch;
pub use progress::{Progress, Silent, Stage};
pub use refine::{Estimate, Explanation, SMALLEST_SHARE};
pub use run::{Basis, Outcome, Request, Split, trace};
pub use score::{Errors, RolloutErrors, Score};
pub(crate) use score::{deviation, errors, filtered, inner_samples};
pub use screen::Considered;
pub use select::{Remaining, Selection, Term, likelier_hold, select};
pub use series::{CoordinateSeries, Details, InputSeries, Prediction, Series, Weighed};
