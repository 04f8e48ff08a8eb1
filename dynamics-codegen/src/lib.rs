//! From a model description to a symbolic graph to Rust, C or an in-process tape.
