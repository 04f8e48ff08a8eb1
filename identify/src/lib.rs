//! From a measured log to the effect a model lacks.

pub mod log;
pub mod smooth;
