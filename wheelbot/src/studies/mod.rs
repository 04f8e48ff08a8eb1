//! The programs: each repeats a figure of the thesis and says how near it comes.

pub mod balance;
pub mod basin;
pub mod estimator;
pub mod identify;
mod interval;
pub mod jump;
pub mod pirouette;
pub mod plan;
pub mod push;
mod record;
mod replay;
pub mod study;
mod terms;

pub use study::{Chart, Cloud, Finding, Map, Study, StudyError, Table};
