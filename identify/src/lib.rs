//! From a measured log to the effect a model lacks.

pub mod machine;
