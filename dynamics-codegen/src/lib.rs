//! From a model description to a symbolic graph to Rust, C or an in-process tape.
//!
//! ```text
//! text ──parse──▶ syntax tree ──build──▶ model ──derive──▶ system ──emit──▶ Rust | C | tape
//! ```
//!
//! [`compile`] is the whole pipeline.

pub mod build;
mod compile;
pub mod derive;
pub mod diagnostic;
pub mod dimension;
pub mod emit;
pub mod file;
pub mod graph;
pub mod mjcf;
pub mod model;
pub mod parts;
mod plausible;
pub mod robot;
pub mod source;
pub mod syntax;
pub mod table;
pub mod tape;
pub mod tree;
pub mod urdf;

pub use compile::{
    Compiled, compile, compile_bytes, compile_keeping, model_limit, model_of_description,
};
pub use derive::System;
pub use diagnostic::{Diagnostic, Report, Severity};
pub use model::{Library, Model, Variables};
pub use tape::{Column, Stepper, Tape, Workspace};
