#![no_std]
//! Runtime of generated robot dynamics: traits, constrained solve, integrators; no_std, no allocation.
