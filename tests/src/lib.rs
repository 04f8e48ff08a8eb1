//! What tests that cross crates share: the models, and files under control.

pub mod c_program;
pub mod compiler;
pub mod emitted;
pub mod files;
pub mod floating;
pub mod fuzz;
pub mod models;
pub mod object_code;
pub mod random;
pub mod reference;
pub mod swing;
