//! Mechanisms as trees: laws, operation counts, and figures of other programs.

mod counts;
mod free;
mod laws;
mod oracles;
mod random;
mod support;
