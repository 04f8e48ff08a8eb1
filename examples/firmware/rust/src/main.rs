//! The Wheelbot's controller and its equation of motion over recorded sensor values: results in bits,
//! and on a Cortex-M4F the instructions that each took. `f32`, no allocation, no standard library.
//!
//!     cargo run --release --target thumbv7em-none-eabihf      # in qemu
//!     cargo run --release                                     # on this machine

#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[path = "../../generated/recorded.rs"]
mod recorded;
mod replay;

#[cfg_attr(target_os = "none", path = "cortex_m4.rs")]
#[cfg_attr(not(target_os = "none"), path = "host.rs")]
mod target;

#[cfg(not(target_os = "none"))]
use target::main;
