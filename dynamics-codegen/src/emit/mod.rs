//! Text from a compiled model: Rust and C source, and the review sheet.
//!
//! ```text
//! system ──plan──▶ quantities, functions ──body──▶ straight lines ──▶ Rust | C
//! ```
//!
//! [`quantities`] says what is emitted; the body of a function is built once, in no
//! particular language; each language has a folder of its own.

mod axes;
mod body;
mod c;
mod counts;
mod digest;
mod emission;
mod frames;
mod functions;
mod given;
mod header;
mod indices;
mod meaning;
mod naming;
mod plan;
mod review;
mod review_bodies;
mod routine;
mod rust;
mod solved;
mod split;
mod symbols;
mod telling;
mod text;
mod words;
mod written;

pub use axes::arguments;
pub use c::c;
pub use counts::{OperationCount, operation_counts};
pub use digest::digest;
pub use emission::Emission;
pub use functions::{FunctionError, Functions};
pub use naming::{c_member, identifier};
pub use plan::{Entry, Quantity, quantities};
pub use review::review;
pub use routine::{Array, Routine};
pub use rust::{DuplicateModel, File, module_name, rust, rust_crate, rust_crate_of, rust_file};
