//! From a measured log to the effect a model lacks.

pub mod fit;
pub mod log;
pub mod machine;
mod number;
pub mod regression;
pub mod report;
pub mod smooth;
pub mod trace;
