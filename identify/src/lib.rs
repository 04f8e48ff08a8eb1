//! From a measured log to the effect a model lacks.

pub mod machine;
pub mod regression;
pub mod trace;
