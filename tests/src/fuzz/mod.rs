//! Damaged input for everything that reads what a user wrote.
//!
//! ```text
//! corpus ──mutate──▶ input ──targets──▶ accepted | refused | failed ──shrink──▶ report
//! ```
//!
//! Input `i` of a kind and a seed is always the same, so that one can be repeated alone. What
//! [`targets`] assert beyond "no panic" is what the readers promise: places inside the text,
//! finite numbers, code that parses. `cargo run -p integration-tests --bin fuzz` runs many
//! in a child process, so that a hang, an overflow of the stack or too much memory is
//! reported with its input ([`supervise`](mod@supervise)); `tests/fuzz.rs` runs a few.

mod bytes;
mod corpus;
mod input;
mod kind;
mod mutate;
mod nest;
mod outcome;
mod scraps;
mod shrink;
pub mod supervise;
mod table;
pub mod targets;
mod token;
pub mod worker;

pub use corpus::{Corpus, Grown, Host};
pub use input::Input;
pub use kind::Kind;
pub use outcome::{Failure, Outcome, outcome};
pub use shrink::shrink;

/// Stack of the thread that runs inputs, in bytes: that of a test thread, the smallest that
/// any of our programs reads input on.
pub const STACK: usize = 2 << 20;
